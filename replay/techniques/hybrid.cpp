// Decoupled coverage with aggregates: DCAA's masks and planes, whose second merge makes aggregates as AGAA does. No
// publication describes it; both papers name their combination as future work.
//   Wang, Wyman, He, Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics 2015
//   Crassin, McGuire, Fatahalian, Lefohn, "Aggregate G-Buffer Anti-Aliasing", extended version, IEEE TVCG 2016
//
// When a pixel's list is full, what shows of the least visible surface joins the surface nearest to it by AGAA's
// distance, whatever their depths, instead of being averaged with one that overlaps it in depth or else dropped. Merged
// shading normals keep the length of their mean, and lighting is filtered over the distribution that it stands for.
#include <cmath>
#include <numbers>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/dcaa_passes.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

DcaaForm form_of(const FrameSetup& setup) {
  DcaaForm form;
  form.surfaces = setup.parameters.at("surfaces").get<std::uint32_t>();
  form.options = DCAA_KEEP_FRONT | DCAA_PREPASS;
  form.options |= setup.choice("second_merge") == "nearest" ? DCAA_NEAREST : DCAA_SECOND_MERGE;
  if (setup.choice("normals") != "mean") form.options |= DCAA_DISTRIBUTION;
  if (setup.choice("normals") == "sggx") form.options |= DCAA_SECOND_MOMENTS;
  if (setup.choice("merge_weight") == "shown") form.options |= DCAA_WEIGHT_SHOWN;
  if (setup.choice("coverage") == "lut") form.options |= DCAA_TABLE;
  form.normal_cosine = static_cast<float>(std::cos(setup.number("normal_angle")));
  form.depth_reach = static_cast<float>(setup.number("depth_reach"));
  form.inverse_length = static_cast<float>(1 / setup.number("length"));
  form.shadow_taps = setup.parameters.at("shadow_taps").get<std::uint32_t>();
  return form;
}

MemoryLayout layout(const FrameSetup& setup) {
  const double s = setup.number("surfaces"), n = setup.samples;
  MemoryLayout memory;
  // DCAA's surface: the length of a mean normal takes 8 of its normal's 32 bits.
  memory.paper = {{"coverage", n * s}, {"facet normal", 32 * s}, {"G-buffer samples", 128 * s}};
  memory.fitted = {{"coverage", n * s}, {"facet normal", 32 * s},
                   {"depth", 24 * s},   {"attributes", fitted_surface_bits(setup.scene.features()) * s},
                   {"count word", 32},  {"prepass planes", 256}};
  if (setup.choice("normals") == "sggx") {
    memory.paper.push_back({"second moments", 96 * s});
    memory.fitted.push_back({"second moments", 96 * s});
  }
  return memory;
}

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  record_dcaa(recorder, setup, form_of(setup));
}

}  // namespace

extern const Technique kHybrid;

const Technique kHybrid{
    "hybrid",
    "Decoupled coverage with aggregates",
    "None: the future work of Wang et al. 2015 (DCAA) and Crassin et al. 2016 (AGAA)",
    {integer_parameter("surfaces", "surfaces kept for a pixel", 1, DCAA_MAX_SURFACES, 4),
     samples_parameter({16, 32, 64}, 64),
     choice_parameter("coverage", "masks come from a table of half-planes, or from exact edges", {"lut", "exact"}),
     number_parameter("normal_angle",
                      "largest angle between the facet normals of fragments that merge at the first attempt", "radians",
                      0, std::numbers::pi, std::numbers::pi / 16),
     number_parameter("depth_reach", "how far from the pixel's centre the depth intervals of surfaces reach", "pixels",
                      0, 8, 0.5),
     choice_parameter("second_merge",
                      "what has to go joins the nearest surface by the distance of aggregates, or as in dcaa one that "
                      "overlaps it in depth",
                      {"nearest", "overlapping"}),
     number_parameter("length",
                      "largest scale of local detail: a distance as large parts surfaces as opposite normals do",
                      "world units", 1e-6, 1e6, 1),
     choice_parameter("normals",
                      "merged normals keep the length of their mean, for filtered lighting; their second moments, too, "
                      "for an anisotropic one; or neither",
                      {"distribution", "sggx", "mean"}),
     choice_parameter("merge_weight", "merges weight by the samples that the one in front leaves, or by those covered",
                      {"shown", "coverage"}),
     integer_parameter("shadow_taps", "points of a surface's footprint at which its shadow is looked up", 1, 8, 4,
                       {1, 2, 4, 8}),
     order_parameter(), alpha_parameter(), resolve_parameter(), shading_parameter()},
    dcaa_maps(),
    layout,
    record};

}  // namespace subpixel::replay
