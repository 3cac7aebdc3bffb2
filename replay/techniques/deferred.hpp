// Parts that several techniques are put together from: a G-buffer of full samples, shading all of them, the final
// images.
#pragma once

#include "replay/frame/frame_images.hpp"
#include "replay/frame/technique.hpp"

namespace subpixel::replay {

// Depth and a full G-buffer sample of each visibility sample.
MemoryLayout full_sample_layout(const FrameSetup& setup);

// Samples a pass of the full-sample G-buffer handles at once; more are handled in groups that reuse the buffer.
std::uint32_t gbuffer_group(std::uint32_t samples);

// What shaders/deferred/stored_sample.glsl stores of a sample: 8 bytes where they hold all that varies in the scene,
// else 16.
bool narrow_samples(const FrameSetup& setup);
// RGBA16UI or RGBA32UI.
VkFormat stored_sample_format(const FrameSetup& setup);
// The variant, ":NARROW" or ":WIDE", of shaders that write such images.
const char* stored_sample_variant(const FrameSetup& setup);
// An array of them that passes write and later ones read, `name`d.
gpu::Image& stored_samples(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name,
                           std::uint32_t layers);
// A stored sample in each layer: of gbuffer_group(samples) layers, or of all samples.
gpu::Image& gbuffer_image(gpu::PassRecorder& recorder, const FrameSetup& setup, bool all_samples = false);
// Fills it for sample group `group`, whose layers follow those of the groups before when it has all samples; those of
// samples that show the sky stay as they are. Pass "gbuffer".
void record_gbuffer(gpu::PassRecorder& recorder, const FrameSetup& setup, const VisibleFragments& visible,
                    gpu::Image& gbuffer, std::uint32_t group);

// Set-up and both at once, without a depth pass before: fragments come in submission order and store their surfaces
// over those of samples that they hide, so what is hidden later is paid for. Leaves what record_visibility() and
// record_gbuffer() leave for all samples, at least 4, each in 16 bytes; passes "gbuffer". The map and the counter
// "written" say how many fragments have stored something, above 16 samples once for each 16.
struct SampleImages {
  gpu::Image &visibility, &gbuffer;
};
SampleImages record_gbuffer_in_order(gpu::PassRecorder& recorder, const FrameSetup& setup);
MapDescription written_map();

struct PrepassParameters : CommonParameters {
  bool prepass = true;
};
namespace field {
Field<PrepassParameters> prepass();
}

// RGBA32F sum over samples; rgb resolvable values, a lighting executions. Also usable as a storage image.
gpu::Image& sum_image(gpu::PassRecorder& recorder, const FrameSetup& setup);
// What passes that light surfaces read: shadow map and cones.
std::vector<gpu::Binding> light_bindings(const FrameSetup& setup);
// A full-screen pass that reads the scene's lights. Bindings beyond those are the caller's.
gpu::RasterPass lighting_pass(const FrameSetup& setup, std::string name, std::string fragment);
// Shades every covered sample of the group into `sum`; pass "shade".
void record_sample_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& visibility,
                           gpu::Image& gbuffer, gpu::Image& sum, std::uint32_t group);
// From the front-end's set-up to shading: the sum over every sample, all of them lit.
gpu::Image& record_shaded_samples(gpu::PassRecorder& recorder, const FrameSetup& setup);
// From the G-buffer on.
gpu::Image& record_shaded_samples(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                  const VisibleFragments& visible);

// A list of pixels that compute passes work through (shaders/deferred/pixel_list.glsl).
struct PixelList {
  gpu::Buffer* pixels = nullptr;
  gpu::Buffer* groups = nullptr;  // of 64 invocations: the pass's `indirect`
};
// Lists the pixels whose value in `flags` (R32_UINT) is not 0; passes "compact". Throws DeviceError, when the passes
// run, if the device's total is not that of its parts.
PixelList record_pixel_list(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& flags);

// `sum` / samples into the frame's outputs; pass "resolve".
void record_resolve(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& sum);

}  // namespace subpixel::replay
