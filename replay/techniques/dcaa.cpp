// Decoupled coverage anti-aliasing: a conservative z-prepass, then one ordered geometry pass that keeps up to S
// surfaces a pixel, each with a mask of up to 64 coverage samples and one plane; the resolve finds what each surface
// shows and lights it once. Wang, Wyman, He and Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics
// 2015.
#include "replay/techniques/dcaa_passes.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

enum class FacetNormal : std::uint32_t {
  two_of_16 = DCAA_NORMAL_2X16,
  two_of_8 = DCAA_NORMAL_2X8,
  three_of_8 = DCAA_NORMAL_3X8,
  three_of_32 = DCAA_NORMAL_3X32,
};

// `nearest` is beyond the paper: nothing that shows is discarded, and only what shows is merged and weighs. Nearest by
// equation 1 of Crassin et al. 2016 with k = 1, as in `hybrid`.
enum class SecondMerge { overlap, nearest, none };

struct DcaaParameters : DecoupledParameters {
  std::uint32_t table_directions = 256, table_distances = 128;
  DecoupledWeight merge_weight = DecoupledWeight::coverage;
  SecondMerge second_merge = SecondMerge::overlap;
  bool keep_front = true, prepass = true;
  FacetNormal facet_normal = FacetNormal::two_of_16;
  std::uint32_t depth_bits = 24;
};
using Setup = SetupFor<DcaaParameters>;

DcaaForm form_of(const DcaaParameters& parameters) {
  DcaaForm form = common_form(parameters);
  if (parameters.second_merge == SecondMerge::overlap) form.options |= DCAA_SECOND_MERGE;
  if (parameters.second_merge == SecondMerge::nearest)
    form.options |= DCAA_NEAREST | DCAA_SHOWN_PART | DCAA_WEIGHT_SHOWN;
  if (parameters.keep_front) form.options |= DCAA_KEEP_FRONT;
  if (parameters.prepass) form.options |= DCAA_PREPASS;
  if (parameters.merge_weight == DecoupledWeight::shown) form.options |= DCAA_WEIGHT_SHOWN;
  form.normal_format = static_cast<std::uint32_t>(parameters.facet_normal);
  form.depth_bits = parameters.depth_bits;
  form.table = {parameters.table_directions, parameters.table_distances};
  return form;
}

MemoryLayout layout(const Setup& setup) {
  const double s = setup.parameters.surfaces, n = setup.samples;
  // Section 4.3 and figure 6: coverage 8 bytes, facet normal 4, and a G-buffer sample of 16 that its depth is part of.
  return {{"coverage", n * s}, {"facet normal", 32 * s}, {"G-buffer samples", 128 * s}};
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  record_dcaa(recorder, setup, form_of(setup.parameters));
}

}  // namespace

extern const Technique kDcaa;

const Technique kDcaa = TechniqueOf<DcaaParameters>{
    .name = "dcaa",
    .title = "Decoupled coverage anti-aliasing",
    .paper = "Wang, Wyman, He, Sen: Decoupled Coverage Anti-Aliasing. High-Performance Graphics 2015",
    .fields = {field::kept_surfaces(), field::samples({16, 32, 64}), field::coverage_source(),
               field::integer("table_directions", &DcaaParameters::table_directions,
                              field::one_of({8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096}),
                              "directions of edges in the table"),
               field::integer("table_distances", &DcaaParameters::table_distances, {8, 1024},
                              "distances of edges from the pixel's centre in the table"),
               field::angle("normal_angle", &DcaaParameters::normal_angle,
                            "largest angle between the facet normals of fragments that merge"),
               field::depth_reach(),
               field::choice("merge_weight", &DcaaParameters::merge_weight,
                             "merges weight by the samples covered, or by those the one in front leaves",
                             {{"coverage", DecoupledWeight::coverage}, {"shown", DecoupledWeight::shown}}),
               field::choice(
                   "second_merge", &DcaaParameters::second_merge,
                   "the surface that has to go merges with one that overlaps it in depth, if there is one; or "
                   "what shows of it joins the nearest, always; or it is discarded",
                   {{"overlap", SecondMerge::overlap}, {"nearest", SecondMerge::nearest}, {"none", SecondMerge::none}}),
               field::condition("keep_front", &DcaaParameters::keep_front, "the front-most surface never has to go"),
               field::condition("prepass", &DcaaParameters::prepass,
                                "a conservative depth prepass rules out fragments"),
               field::choice("facet_normal", &DcaaParameters::facet_normal,
                             "components and bits of a surface's facet normal",
                             {{"2x16", FacetNormal::two_of_16},
                              {"2x8", FacetNormal::two_of_8},
                              {"3x8", FacetNormal::three_of_8},
                              {"3x32", FacetNormal::three_of_32}}),
               field::integer("depth_bits", &DcaaParameters::depth_bits, field::one_of({16, 20, 24, 32}),
                              "bits of a surface's depth"),
               field::order(), field::alpha(), field::resolve(), field::shading()},
    .maps = dcaa_maps(),
    .layout = layout,
    .record = record,
    .lists = ListedMasks::later,
    .whole_only = dcaa_whole_only,
};

}  // namespace subpixel::replay
