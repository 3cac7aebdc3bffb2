// Decoupled coverage with aggregates: DCAA's masks and planes, whose second merge makes aggregates as AGAA does. No
// publication describes it; both papers name their combination as future work.
//   Wang, Wyman, He, Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics 2015
//   Crassin, McGuire, Fatahalian, Lefohn, "Aggregate G-Buffer Anti-Aliasing", extended version, IEEE TVCG 2016
//
// When a pixel's list is full, what shows of the least visible surface joins the surface nearest to it by AGAA's
// distance, whatever their depths, instead of being averaged with one that overlaps it in depth or else dropped. Merged
// shading normals keep the length of their mean, and lighting is filtered over the distribution that it stands for.
#include <cmath>

#include "replay/techniques/dcaa_passes.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

enum class SecondMerge { nearest, overlapping };
enum class MergedNormals { distribution, sggx, mean };

struct HybridParameters : DecoupledParameters {
  SecondMerge second_merge = SecondMerge::nearest;
  bool shown_only = true;
  double length = 1;  // world units
  MergedNormals normals = MergedNormals::distribution;
  DecoupledWeight merge_weight = DecoupledWeight::shown;
  std::uint32_t shadow_taps = 4;
  double least_shown = 0.04;  // of the pixel: under three of 64 samples
};
using Setup = SetupFor<HybridParameters>;

DcaaForm form_of(const HybridParameters& parameters) {
  DcaaForm form = common_form(parameters);
  form.options |= DCAA_KEEP_FRONT | DCAA_PREPASS;
  form.options |= parameters.second_merge == SecondMerge::nearest ? DCAA_NEAREST : DCAA_SECOND_MERGE;
  if (parameters.shown_only) form.options |= DCAA_SHOWN_PART;
  if (parameters.normals != MergedNormals::mean) form.options |= DCAA_DISTRIBUTION;
  if (parameters.normals == MergedNormals::sggx) form.options |= DCAA_SECOND_MOMENTS;
  if (parameters.merge_weight == DecoupledWeight::shown) form.options |= DCAA_WEIGHT_SHOWN;
  form.inverse_length = static_cast<float>(1 / parameters.length);
  form.shadow_taps = parameters.shadow_taps;
  form.least_shown = static_cast<std::uint32_t>(std::ceil(parameters.least_shown * parameters.samples));
  return form;
}

MemoryLayout layout(const Setup& setup) {
  const double s = setup.parameters.surfaces, n = setup.samples;
  // DCAA's surface: the length of a mean normal takes 8 of its normal's 32 bits.
  MemoryLayout memory{{"coverage", n * s}, {"facet normal", 32 * s}, {"G-buffer samples", 128 * s}};
  if (setup.parameters.normals == MergedNormals::sggx) memory.push_back({"second moments", 96 * s});
  return memory;
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  record_dcaa(recorder, setup, form_of(setup.parameters));
}

}  // namespace

extern const Technique kHybrid;

const Technique kHybrid = TechniqueOf<HybridParameters>{
    .name = "hybrid",
    .title = "Decoupled coverage with aggregates",
    .paper = "None: the future work of Wang et al. 2015 (DCAA) and Crassin et al. 2016 (AGAA)",
    .fields = {field::kept_surfaces(), field::samples({16, 32, 64}), field::coverage_source(),
               field::angle("normal_angle", &HybridParameters::normal_angle,
                            "largest angle between the facet normals of fragments that merge at the first attempt"),
               field::depth_reach(),
               field::choice(
                   "second_merge", &HybridParameters::second_merge,
                   "what has to go joins the nearest surface by the distance of aggregates, or as in dcaa one that "
                   "overlaps it in depth",
                   {{"nearest", SecondMerge::nearest}, {"overlapping", SecondMerge::overlapping}}),
               field::condition("shown_only", &HybridParameters::shown_only,
                                "fragments bring only samples that no surface wholly in front of them covers"),
               field::number("length", &HybridParameters::length, {1e-6, 1e6},
                             "largest scale of local detail: a distance as large parts surfaces as opposite normals do",
                             "world units"),
               field::choice(
                   "normals", &HybridParameters::normals,
                   "merged normals keep the length of their mean, for filtered lighting; their second moments, "
                   "too, for an anisotropic one; or neither",
                   {{"distribution", MergedNormals::distribution},
                    {"sggx", MergedNormals::sggx},
                    {"mean", MergedNormals::mean}}),
               field::choice("merge_weight", &HybridParameters::merge_weight,
                             "merges weight by the samples that the one in front leaves, or by those covered",
                             {{"shown", DecoupledWeight::shown}, {"coverage", DecoupledWeight::coverage}}),
               field::integer("shadow_taps", &HybridParameters::shadow_taps, field::one_of({1, 2, 4, 8}),
                              "points of a surface's footprint at which its shadow is looked up"),
               field::number("least_shown", &HybridParameters::least_shown, {0, 1},
                             "surfaces that show less of the pixel are lit as part of the nearest", "of the pixel"),
               field::order(), field::alpha(), field::resolve(), field::shading()},
    .maps = dcaa_maps(),
    .layout = layout,
    .record = record,
    .lists = ListedMasks::later,
    .whole_only = dcaa_whole_only,
};

}  // namespace subpixel::replay
