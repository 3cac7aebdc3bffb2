// The passes of decoupled coverage anti-aliasing, for the techniques that are made of them.
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include "replay/frame/technique.hpp"
#include "replay/techniques/dcaa_table.hpp"

namespace subpixel::replay {

enum class DecoupledCoverage { table, exact };
enum class DecoupledWeight { coverage, shown };

// What the techniques made of these passes let one choose alike.
struct DecoupledParameters : OrderedParameters {
  std::uint32_t surfaces = 4;
  DecoupledCoverage coverage = DecoupledCoverage::table;
  double normal_angle = std::numbers::pi / 16;
  double depth_reach = 0.5;  // pixels

  DecoupledParameters() { samples = 64; }
};

namespace field {
Field<DecoupledParameters> kept_surfaces();
Field<DecoupledParameters> coverage_source();
Field<DecoupledParameters> depth_reach();
}  // namespace field

// How a technique wants its surfaces kept and merged; the shaders' specialization constants.
struct DcaaForm {
  std::uint32_t surfaces = 4;
  std::uint32_t options = 0;        // DCAA_ bits of dcaa_interface.h
  float normal_cosine = 1;          // of the largest angle between facet normals that merge at the first attempt
  float depth_reach = 0.5F;         // of depth intervals, in pixels from the centre
  std::uint32_t normal_format = 0;  // DCAA_NORMAL_ of facet normals
  std::uint32_t depth_bits = 24;
  CoverageTableSize table{256, 128};
  float inverse_length = 1;       // 1 / k of the distance between aggregates, 1 / world units; with DCAA_NEAREST
  std::uint32_t shadow_taps = 4;  // with DCAA_DISTRIBUTION
  std::uint32_t least_shown = 0;  // samples; surfaces that show fewer are lit as part of the nearest
};

// The part of a form that those parameters decide.
DcaaForm common_form(const DecoupledParameters& parameters);

// All passes of a frame, outputs and maps included.
void record_dcaa(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form);

// The depth prepass by itself: an image (RGBA32UI array of two layers) whose first layer's xyz are float bits of a
// plane of reversed depth, z at the pixel's centre, dz/dx and dz/dy, that no sample of a visible surface lies behind; z
// is 0 where nothing is known.
gpu::Image& record_depth_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form);

// The maps that record_dcaa() leaves.
std::vector<MapDescription> dcaa_maps();
// Technique::whole_only.
std::string dcaa_whole_only(const FrameSetup& whole);

}  // namespace subpixel::replay
