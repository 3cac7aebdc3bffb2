// Point lights of a frame, captured or placed.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "replay/scene/camera.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// Throws InputError when a frame has more point lights than shaders can hold, SUBPIXEL_MAX_POINT_LIGHTS.
void require_few_lights(const capture::Frame& frame, std::uint32_t index);

// Up to SUBPIXEL_MAX_POINT_LIGHTS lights as the shaders read them; those that are not finite, have no range, or a
// cone without direction, are left out.
std::vector<gpu_types::PointLightConstants> light_constants(const std::vector<capture::PointLight>& lights);
// Their cones, one for each of those lights.
std::vector<gpu_types::SpotConeConstants> cone_constants(const std::vector<capture::PointLight>& lights);

// A camera to place lights for, with points of what its frame draws.
struct LightStage {
  Camera camera;
  float exposure = 1;
  std::uint64_t point_count = 0;
  std::function<glm::dvec3(std::uint64_t)> point;  // world; [0, point_count)
};

// Lights number `first` to `count` - 1, the same ones for the same stages: each a little before a visible point of the
// scene, spread evenly over the images of the stages, with a range that is a fixed part of its distance to the eye, so
// that near and far lights cover about as many pixels. All lie inside `bounds`.
std::vector<capture::PointLight> placed_lights(std::uint32_t first, std::uint32_t count,
                                               const std::vector<LightStage>& stages, const Bounds& bounds);

}  // namespace subpixel::replay
