#include "replay/scene/lights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

constexpr int kCandidates = 64;  // points tried for each light
constexpr double kRangePerDistance = 0.4;
constexpr double kLiftPerDistance = 0.04;
// Irradiance a light gives at a quarter of its range, before exposure: about that of an overcast noon against a sun
// of 3.
constexpr double kIrradiance = 1.5;

// PCG hash (Jarzynski and Olano 2020, "Hash functions for GPU rendering").
std::uint32_t hash(std::uint32_t value) {
  const std::uint32_t state = value * 747796405u + 2891336453u;
  const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// A hue of medium saturation with mean 1.
glm::dvec3 tint(std::uint32_t i) {
  const double hue = std::fmod(0.618033988749895 * i, 1.0);
  glm::dvec3 colour;
  for (int c = 0; c < 3; ++c) colour[c] = 1.0 + 0.6 * std::cos(6.283185307179586 * (hue - c / 3.0));
  return colour;
}

bool finite(float value) {
  return std::isfinite(value);
}

// Cosines between a cone's inner and outer angle, at least: a step from light to dark, and still finite.
constexpr double kSharpestEdge = 1e-5;

glm::dvec3 direction_of(const capture::SpotCone& cone) {
  return {cone.direction[0], cone.direction[1], cone.direction[2]};
}

bool is_usable(const capture::PointLight& light) {
  const bool lit = std::all_of(light.position.begin(), light.position.end(), finite) &&
                   std::all_of(light.intensity.begin(), light.intensity.end(), finite) && finite(light.range) &&
                   light.range >= 1e-6f;
  if (!lit || !light.cone) return lit;
  const double length = glm::length(direction_of(*light.cone));
  return length > 1e-12 && std::isfinite(length) && finite(light.cone->inner_cosine) &&
         finite(light.cone->outer_cosine);
}

}  // namespace

void require_few_lights(const capture::Frame& frame, std::uint32_t index) {
  if (frame.point_lights.size() <= SUBPIXEL_MAX_POINT_LIGHTS) return;
  throw InputError(
      fmt::format("frame {}", index),
      fmt::format("it has {} point lights, at most {} can be shaded; a replay that asks for so many takes the first",
                  frame.point_lights.size(), SUBPIXEL_MAX_POINT_LIGHTS),
      "point_lights");
}

std::vector<gpu_types::PointLightConstants> light_constants(const std::vector<capture::PointLight>& lights) {
  assert(lights.size() <= SUBPIXEL_MAX_POINT_LIGHTS);
  std::vector<gpu_types::PointLightConstants> result;
  for (const auto& light : lights) {
    if (!is_usable(light)) continue;
    result.push_back({{light.position[0], light.position[1], light.position[2], light.range},
                      {light.intensity[0], light.intensity[1], light.intensity[2], 1.0f / light.range / light.range}});
  }
  return result;
}

std::vector<gpu_types::SpotConeConstants> cone_constants(const std::vector<capture::PointLight>& lights) {
  std::vector<gpu_types::SpotConeConstants> result;
  for (const auto& light : lights) {
    if (!is_usable(light)) continue;
    auto& cone = result.emplace_back(gpu_types::SpotConeConstants{glm::vec4(0, 0, 0, 1)});
    if (!light.cone) continue;
    const glm::dvec3 direction = glm::normalize(direction_of(*light.cone));
    const double inner = light.cone->inner_cosine, outer = light.cone->outer_cosine;
    const double scale = 1 / std::max(inner - outer, kSharpestEdge);
    cone.plane = glm::vec4(direction * scale, -outer * scale);
  }
  return result;
}

std::vector<capture::PointLight> placed_lights(std::uint32_t first, std::uint32_t count,
                                               const std::vector<LightStage>& stages, const Bounds& bounds) {
  std::vector<capture::PointLight> lights;
  if (stages.empty() || bounds.empty()) return lights;
  for (std::uint32_t i = first; i < count; ++i) {
    const auto& stage = stages[i % stages.size()];
    // Where in the image: the R2 sequence (Roberts 2018), kept off the border.
    const double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0), v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    const glm::dvec2 target(1.6 * u - 0.8, 1.6 * v - 0.8);
    glm::dvec3 best = bounds.centre();
    double best_distance = 1e30;
    for (std::uint32_t c = 0; c < kCandidates && stage.point_count > 0; ++c) {
      const std::uint64_t number = (std::uint64_t{hash(i * kCandidates + c)} << 32 | hash(~(i * kCandidates + c)));
      const glm::dvec3 point = stage.point(number % stage.point_count);
      const glm::dvec4 clip = stage.camera.view_projection * glm::dvec4(point, 1);
      if (!(clip.w > 0) || !(std::abs(clip.x) < clip.w) || !(std::abs(clip.y) < clip.w)) continue;
      const double distance = glm::length(glm::dvec2(clip) / clip.w - target);
      if (distance < best_distance) {
        best_distance = distance;
        best = point;
      }
    }
    const glm::dvec3 to_eye = stage.camera.eye - best;
    const double distance = std::clamp(glm::length(to_eye), 1e-3, glm::length(bounds.size()) + 1e-3);
    const glm::dvec3 up = glm::dvec3(glm::transpose(stage.camera.view)[1]);
    const glm::dvec3 lifted = best + to_eye * kLiftPerDistance + up * (kLiftPerDistance * distance);
    const glm::dvec3 position = glm::clamp(lifted, bounds.low, bounds.high);
    const double range = kRangePerDistance * distance;
    const double at_quarter = range * range / 16 * kIrradiance / std::max(1e-6, static_cast<double>(stage.exposure));
    const glm::dvec3 intensity = tint(i) * at_quarter;
    capture::PointLight light;
    for (int axis = 0; axis < 3; ++axis) {
      light.position[static_cast<std::size_t>(axis)] = static_cast<float>(position[axis]);
      light.intensity[static_cast<std::size_t>(axis)] = static_cast<float>(intensity[axis]);
    }
    light.range = static_cast<float>(range);
    lights.push_back(light);
  }
  return lights;
}

}  // namespace subpixel::replay
