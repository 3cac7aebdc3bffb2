// Two walls that meet in the middle of a pixel, at known angles and depths: for the conditions under which a technique
// takes samples of different triangles for one surface.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {

// The left wall turns away from the viewer to its left by `left` radians, the right one to its right by `right`. Where
// they meet, the right one is nearer by `step`, which is half as much in depth.
struct Walls {
  float left = 0, right = 0, step = 0;
  bool turned = false;    // the left wall's triangles are wound the other way
  bool mirrored = false;  // a transform that mirrors puts the left wall in its place
  static constexpr std::uint32_t kWidth = 15, kHeight = 3;
  static constexpr std::uint32_t kMeetingPixel = kWidth + 7;  // both walls' diagonals are elsewhere
};

inline capture::Capture walls_that_meet(const Walls& walls) {
  capture::Capture capture = flat_capture(Walls::kWidth, Walls::kHeight);
  const float l = -0.5f * std::tan(walls.left), m = walls.step, r = m - 0.5f * std::tan(walls.right);
  const float mirror = walls.mirrored ? -1.0f : 1.0f, outer = -0.5f * mirror;
  std::vector<float> left{outer, -1, l, 0, -1, 0, 0, 1, 0, outer, -1, l, 0, 1, 0, outer, 1, l};
  if (walls.turned)
    for (const std::ptrdiff_t triangle : {0, 9}) {
      const auto corner = left.begin() + triangle;
      std::swap_ranges(corner, corner + 3, corner + 3);
    }
  const auto material = add_emitter(capture, {1, 1, 1});
  capture.materials[material].two_sided = true;
  add_triangles(capture, left, material).transform[0] = mirror;
  add_triangles(capture, {0, -1, m, 0.5f, -1, r, 0.5f, 1, r, 0, -1, m, 0.5f, 1, r, 0, 1, m}, material);
  return capture;
}

}  // namespace subpixel::replay
