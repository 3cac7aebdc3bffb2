// The visibility buffer: depth and triangle of every sample, found in one ordered geometry pass for each 16 samples.
#pragma once

#include "replay/frame/frame_setup.hpp"

namespace subpixel::replay {

// How triangles of a few pixels are rasterised. All ways leave the same bits; `automatic` takes the faster by their
// number.
enum class SmallTriangles { automatic, as_hulls, in_lists };

// Records the passes, named "visibility", and the front-end's compaction to visible triangles; returns the image
// (RGBA32UI array, layers as shaders/include/visibility.glsl reads them). `samples` is 1, 2, 4, 8, 16, 32 or 64 and
// what the front-end was prepared for.
gpu::Image& record_visibility(gpu::PassRecorder& recorder, const FrameSetup& setup,
                              SmallTriangles small = SmallTriangles::automatic);

// Samples in one pass of visibility.frag for an n-sample pattern.
std::uint32_t visibility_group(std::uint32_t samples);

}  // namespace subpixel::replay
