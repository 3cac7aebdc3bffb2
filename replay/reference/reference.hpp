// The ground truth: the scene's current frame by the device's own rasteriser, many samples a pixel.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "replay/measure/image.hpp"
#include "replay/scene/gpu_scene.hpp"

namespace subpixel::replay {

inline constexpr std::uint32_t kDefaultReferenceSamples = 512;

// What one pixel of a reference was shaded by.
struct PixelShading {
  std::uint32_t turn = 0;
  std::uint32_t samples = 0;                                  // bits of the turn's samples that see the triangle
  glm::vec2 at{0};                                            // where it was shaded, in the pixel, 0 to 1 each way
  std::uint32_t first_index = 0, instance = 0, material = 0;  // of the triangle
  glm::vec3 radiance{0};
};
struct PixelReference {
  glm::uvec2 pixel{0};
  std::vector<PixelShading> shadings;
};

struct ReferenceOptions {
  std::uint32_t samples = kDefaultReferenceSamples;  // visibility samples a pixel, by replay/results/limits.hpp, not 0
  std::uint32_t shading_model = 0;                   // SHADING_MODEL_ of shaders/include/interface.h
  PixelReference* story = nullptr;                   // filled for its pixel
  bool shade_all_samples = false;  // a triangle at each sample that sees it, not once a turn: what the other tends to
  bool tone_map_samples = false;   // the display image is the mean of tone-mapped samples, not the tone-mapped mean
};

struct ReferenceImage {
  Image linear;   // 3 channels, mean radiance
  Image display;  // 3 channels, [0, 1]
};

// Called after each turn with turns done and turns in all (samples / 4 or / 16, turns.hpp). May throw to stop.
using ReferenceProgress = std::function<void(std::uint32_t done, std::uint32_t total)>;

// What it holds by pixel; it is drawn whole, since the device's rasteriser rounds a little differently in other rows.
std::uint64_t reference_bytes(std::uint32_t samples, std::uint32_t width, std::uint32_t height, bool tone_map_samples);

// Each turn draws triangle numbers at two or four times the width and height, which is four or sixteen samples a pixel
// (and on lavapipe faster than the driver's own), and shades each triangle that some of four samples see once, so a
// pixel has at least samples / 4 shading samples. Samples and shading points of all turns are spread evenly over the
// pixel's square: the result tends to the box-filtered image. Texture gradients are analytic, of one pixel, as in the
// techniques. Throws UsageError (options out of range), InputError and DeviceError.
ReferenceImage render_reference(gpu::Device& device, GpuScene& scene, const ReferenceOptions& options,
                                const ReferenceProgress& progress = {});

}  // namespace subpixel::replay
