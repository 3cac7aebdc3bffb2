// Decoupled coverage anti-aliasing: a conservative z-prepass, then one ordered geometry pass that keeps up to S
// surfaces a pixel, each with a mask of up to 64 coverage samples and one plane; the resolve finds what each surface
// shows and lights it once. Wang, Wyman, He and Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics
// 2015.
#include <cmath>
#include <numbers>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/dcaa_passes.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

std::uint32_t whole(const FrameSetup& setup, std::string_view name) {
  return static_cast<std::uint32_t>(setup.number(name));
}

std::uint32_t normal_format(const FrameSetup& setup) {
  const std::string format = setup.choice("facet_normal");
  return format == "2x8"
             ? DCAA_NORMAL_2X8
             : (format == "3x8" ? DCAA_NORMAL_3X8 : (format == "3x32" ? DCAA_NORMAL_3X32 : DCAA_NORMAL_2X16));
}

DcaaForm form_of(const FrameSetup& setup) {
  DcaaForm form;
  form.surfaces = whole(setup, "surfaces");
  if (setup.parameters.at("second_merge").get<bool>()) form.options |= DCAA_SECOND_MERGE;
  if (setup.parameters.at("keep_front").get<bool>()) form.options |= DCAA_KEEP_FRONT;
  if (setup.parameters.at("prepass").get<bool>()) form.options |= DCAA_PREPASS;
  if (setup.choice("coverage") == "lut") form.options |= DCAA_TABLE;
  if (setup.choice("merge_weight") == "shown") form.options |= DCAA_WEIGHT_SHOWN;
  form.normal_cosine = static_cast<float>(std::cos(setup.number("normal_angle")));
  form.depth_reach = static_cast<float>(setup.number("depth_reach"));
  form.normal_format = normal_format(setup);
  form.depth_bits = whole(setup, "depth_bits");
  form.table = {whole(setup, "table_directions"), whole(setup, "table_distances")};
  return form;
}

MemoryLayout layout(const FrameSetup& setup) {
  const double s = setup.number("surfaces"), n = setup.samples;
  const double depth = setup.number("depth_bits");
  const double facet =
      normal_format(setup) == DCAA_NORMAL_3X32 ? 96 : (normal_format(setup) == DCAA_NORMAL_2X16 ? 32 : 24);
  MemoryLayout memory;
  // Section 4.3 and figure 6: coverage 8 bytes, facet normal 4, and a G-buffer sample of 16 that its depth is part of.
  memory.paper = {{"coverage", n * s}, {"facet normal", 32 * s}, {"G-buffer samples", 128 * s}};
  memory.fitted = {{"coverage", n * s},
                   {"facet normal", facet * s},
                   {"depth", depth * s},
                   {"attributes", fitted_surface_bits(setup.scene.features()) * s},
                   {"count word", 32}};
  if (setup.parameters.at("prepass").get<bool>()) memory.fitted.push_back({"prepass planes", 256});
  return memory;
}

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  record_dcaa(recorder, setup, form_of(setup));
}

}  // namespace

extern const Technique kDcaa;

const Technique kDcaa{
    "dcaa",
    "Decoupled coverage anti-aliasing",
    "Wang, Wyman, He, Sen: Decoupled Coverage Anti-Aliasing. High-Performance Graphics 2015",
    {integer_parameter("surfaces", "surfaces kept for a pixel", 1, DCAA_MAX_SURFACES, 4),
     samples_parameter({16, 32, 64}, 64),
     choice_parameter("coverage", "masks come from a table of half-planes, or from exact edges", {"lut", "exact"}),
     integer_parameter("table_directions", "directions of edges in the table", 8, 4096, 256,
                       {8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096}),
     integer_parameter("table_distances", "distances of edges from the pixel's centre in the table", 8, 1024, 128),
     number_parameter("normal_angle", "largest angle between the facet normals of fragments that merge", "radians", 0,
                      std::numbers::pi, std::numbers::pi / 16),
     number_parameter("depth_reach", "how far from the pixel's centre the depth intervals of surfaces reach", "pixels",
                      0, 8, 0.5),
     choice_parameter("merge_weight", "merges weight by the samples covered, or by those the one in front leaves",
                      {"coverage", "shown"}),
     condition_parameter("second_merge", "the surface that has to go merges with one that overlaps it in depth"),
     condition_parameter("keep_front", "the front-most surface never has to go"),
     condition_parameter("prepass", "a conservative depth prepass rules out fragments"),
     choice_parameter("facet_normal", "components and bits of a surface's facet normal",
                      {"2x16", "2x8", "3x8", "3x32"}),
     integer_parameter("depth_bits", "bits of a surface's depth", 16, 32, 24, {16, 20, 24, 32}), order_parameter(),
     alpha_parameter(), resolve_parameter(), shading_parameter()},
    dcaa_maps(),
    layout,
    record};

}  // namespace subpixel::replay
