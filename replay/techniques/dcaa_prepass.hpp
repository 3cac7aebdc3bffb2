// The depth prepass of decoupled coverage anti-aliasing, by itself for tests.
#pragma once

#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

// Records the z-prepass and returns its image (RGBA32UI array of two layers): the first layer's xyz are float bits of a
// plane of reversed depth, z at the pixel's centre, dz/dx and dz/dy, that no sample of a visible surface lies behind; z
// is 0 where nothing is known. Takes the parameters of `dcaa`.
gpu::Image& record_depth_bound(gpu::PassRecorder& recorder, const FrameSetup& setup);

}  // namespace subpixel::replay
