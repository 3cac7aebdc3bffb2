// The passes of decoupled coverage anti-aliasing, for the techniques that are made of them.
#pragma once

#include <cstdint>
#include <vector>

#include "replay/techniques/dcaa_table.hpp"
#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

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
};

// All passes of a frame, outputs and maps included. Takes the parameters `order` and `alpha` from the setup.
void record_dcaa(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form);

// The depth prepass by itself: an image (RGBA32UI array of two layers) whose first layer's xyz are float bits of a
// plane of reversed depth, z at the pixel's centre, dz/dx and dz/dy, that no sample of a visible surface lies behind; z
// is 0 where nothing is known.
gpu::Image& record_depth_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form);

// The maps that record_dcaa() leaves.
std::vector<MapDescription> dcaa_maps();

}  // namespace subpixel::replay
