// The visibility buffer: depth and triangle of every sample, found in one ordered geometry pass for each 16 samples, or
// where the device has no ordered attachments in three passes of atomic operations, which leave the same bits.
#pragma once

#include "replay/frontend/frontend_frame.hpp"

namespace subpixel::replay {

// The parts of the choice below, for frames in bands: do lists pay for a frame of so many pixels with these triangles;
// does a block's list of what is prepared outgrow the loops of the device (counted only where that is possible)?
bool small_lists_pay(const Frontend& frontend, std::uint64_t pixels);
bool small_lists_too_long(const FrontendFrame& frame);

// The faster way for the small triangles of the frame, by their number. Where the device ends long loops, a run on the
// spot may count the lists.
SmallTriangles choose_small_triangles(const FrontendFrame& frame);

// Records the passes, named "visibility"; returns the image
// (RGBA32UI array, layers as shaders/include/visibility.glsl reads them), of 1, 2, 4, 8, 16, 32 or 64 samples.
gpu::Image& record_visibility(gpu::PassRecorder& recorder, const FrontendFrame& frame);

// The image by itself, not filled.
gpu::Image& visibility_image(gpu::PassRecorder& recorder, const FrontendFrame& frame);
// Makes its layers of sample group `g` the attachments of `pass`, whose shader includes nearest_samples.glsl with
// GROUP = visibility_group().
void attach_visibility(gpu::RasterPass& pass, const Frontend& frontend, gpu::Image& image, std::uint32_t g);

// Samples in one pass of visibility.frag: up to 16, or 8 where the device has but four colour attachments.
std::uint32_t visibility_group(const Frontend& frontend);

}  // namespace subpixel::replay
