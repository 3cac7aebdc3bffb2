// Random pixels for tests of per-pixel algorithms: samples of a few triangles, whose normals, depths and materials lie
// near the limits that such algorithms compare with.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "shaders/frontend/frontend_types.h"
#include "shaders/frontend/sample_patterns.h"

namespace subpixel::replay {

struct RandomTriangle {
  std::uint32_t number = 0, material = 0;
  glm::vec3 normal{0, 0, 1};
  glm::vec2 slopes{0};
  float depth = 0;  // at the pixel's centre
};

struct RandomSample {
  const RandomTriangle* triangle = nullptr;  // none: the sky
  float depth = 0;
  std::uint32_t number() const { return triangle ? triangle->number : SUBPIXEL_NO_TRIANGLE; }
};

class PixelGenerator {
 public:
  explicit PixelGenerator(std::uint64_t seed) : engine_(seed) {}

  // `angle`: radians around which the angles between normals lie.
  std::vector<RandomSample> pixel(std::uint32_t samples, double angle) {
    triangles_.resize(1 + whole(samples < 16 ? 7 : 11));
    const glm::dvec3 around = direction();
    const double depth = std::exp2(-10.0 * real());
    const double steep = depth * std::exp2(-8.0 * real());
    for (auto& t : triangles_) {
      t.number = whole(8) == 0 ? static_cast<std::uint32_t>(engine_()) & 0x7fffffffu : whole(100'000);
      t.material = whole(4) == 0 ? whole(3) : 0;
      const double away = whole(6) == 0 ? 3.0 * real() : angle * (0.5 + 0.6 * real()) * (whole(2) == 0 ? 1.0 : 0.3);
      t.normal = glm::vec3(
          glm::normalize(around + std::tan(std::min(away, 1.5)) * glm::normalize(glm::cross(around, direction()))));
      t.slopes = glm::vec2(steep * (2 * real() - 1), steep * (2 * real() - 1));
      t.depth = static_cast<float>(depth + steep * 4.0 * (real() - 0.5) * (whole(3) == 0 ? 1.0 : 0.25));
    }
    const bool sky = whole(4) == 0;
    const std::uint32_t main_triangle = whole(static_cast<std::uint32_t>(triangles_.size()));
    const std::uint32_t others = 1 + whole(6);  // of 6 samples belong to any triangle, the rest to one
    std::vector<RandomSample> pixel(samples);
    for (std::uint32_t s = 0; s < samples; ++s) {
      if (sky && whole(4) == 0) continue;
      const std::uint32_t which =
          whole(6) < others ? whole(static_cast<std::uint32_t>(triangles_.size())) : main_triangle;
      const RandomTriangle& t = triangles_[which];
      const auto offset = gpu_types::sample_offset(samples, s);
      pixel[s] = {
          &t,
          t.depth + (t.slopes.x * static_cast<float>(offset.x) + t.slopes.y * static_cast<float>(offset.y)) / 128.0f};
    }
    return pixel;
  }

  std::uint32_t whole(std::uint32_t below) { return static_cast<std::uint32_t>(engine_() % below); }
  double real() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  glm::dvec3 direction() {
    const double z = 2 * real() - 1, turn = 6.283185307179586 * real(), r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }

  std::mt19937_64 engine_;
  std::vector<RandomTriangle> triangles_;  // of the last pixel
};

}  // namespace subpixel::replay
