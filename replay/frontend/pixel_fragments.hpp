// All fragments of one pixel, for whoever wants to know what happens there.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "replay/frontend/fragment_lists.hpp"
#include "shaders/story/story_interface.h"

namespace subpixel::replay {

struct PixelFragment {
  std::uint32_t record = 0;                     // of the front-end, by which techniques know the triangle
  std::uint32_t first_index = 0, instance = 0;  // of the source triangle, in the scene's arrays
  std::uint32_t material = 0;
  bool back_face = false, clipped = false;
  gpu_types::StoryFragment found;
};

// Where in the current frame's draws a triangle comes from.
struct TriangleSource {
  std::uint32_t draw = 0, instance = 0, triangle = 0;  // instance of the draw, triangle of its mesh
};
TriangleSource triangle_source(const GpuScene& scene, std::uint32_t first_index, std::uint32_t instance);

// The fragments whose triangle's edges reach `pixel`, in submission order, by runs on the spot. The front-end is
// prepared.
std::vector<PixelFragment> find_pixel_fragments(const FrontendFrame& frame, glm::uvec2 pixel);

// Lists that hold them alone, number i the i-th, with the masks that `masks` says: whole frames go through such lists.
FragmentLists pixel_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame, glm::uvec2 pixel,
                          std::span<const PixelFragment> fragments, ListedMasks masks);

}  // namespace subpixel::replay
