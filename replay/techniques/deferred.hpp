// Parts that several techniques are put together from: a G-buffer of full samples, shading all of them, the final images.
#pragma once

#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

// Samples a pass of the full-sample G-buffer handles at once; more are handled in groups that reuse the buffer.
std::uint32_t gbuffer_group(std::uint32_t samples);

// RGBA32UI array of gbuffer_group(samples) layers, 16 bytes a sample as in shaders/include/packing.glsl.
gpu::Image& gbuffer_image(gpu::PassRecorder& recorder, const FrameSetup& setup);
// Fills it for sample group `group`; pass "gbuffer".
void record_gbuffer(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& visibility, gpu::Image& gbuffer,
                    std::uint32_t group);

// RGBA32F sum over samples; rgb resolvable values, a lighting executions.
gpu::Image& sum_image(gpu::PassRecorder& recorder, const FrameSetup& setup);
// A full-screen pass that reads the scene's lights. Bindings beyond those are the caller's.
gpu::RasterPass lighting_pass(const FrameSetup& setup, std::string name, std::string fragment);
// Shades every covered sample of the group into `sum`; pass "shade".
void record_sample_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& visibility,
                           gpu::Image& gbuffer, gpu::Image& sum, std::uint32_t group);
// `sum` / samples into the frame's outputs; pass "resolve".
void record_resolve(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& sum);

}  // namespace subpixel::replay
