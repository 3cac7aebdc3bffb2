#include "replay/scene/camera.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "base/error.hpp"
#include "replay/scene/shadow_fit.hpp"

namespace subpixel::replay {
namespace {

capture::Matrix4 captured(const glm::dmat4& m) {
  capture::Matrix4 result;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) result[static_cast<std::size_t>(4 * c + r)] = static_cast<float>(m[c][r]);
  return result;
}

// A perspective camera at (1, 2, 3) written in each convention a capture may have.
capture::Frame frame_in(capture::ClipDepth depth, bool y_up, const glm::dvec3& eye = {1, 2, 3}) {
  constexpr double kNear = 0.1, kFar = 50, kScale = 1.7;
  glm::dmat4 projection(0);
  projection[0][0] = kScale;
  projection[1][1] = y_up ? kScale : -kScale;
  projection[2][3] = -1;
  switch (depth) {
    case capture::ClipDepth::zero_to_one:
      projection[2][2] = -kFar / (kFar - kNear);
      projection[3][2] = -kFar * kNear / (kFar - kNear);
      break;
    case capture::ClipDepth::one_to_zero:
      projection[2][2] = kNear / (kFar - kNear);
      projection[3][2] = kFar * kNear / (kFar - kNear);
      break;
    case capture::ClipDepth::minus_one_to_one:
      projection[2][2] = -(kFar + kNear) / (kFar - kNear);
      projection[3][2] = -2 * kFar * kNear / (kFar - kNear);
      break;
  }
  capture::Frame frame;
  frame.view = captured(glm::lookAt(eye, eye + glm::dvec3(-1, -1.5, -4), glm::dvec3(0, 1, 0)));
  frame.projection = captured(projection);
  frame.clip_depth = depth;
  frame.clip_y_up = y_up;
  return frame;
}

TEST(SceneCamera, AllConventionsGiveTheSameClipPositions) {
  const glm::dvec4 point(0.4, 0.9, -2, 1);
  const Camera expected = camera_of(frame_in(capture::ClipDepth::one_to_zero, false), 0);
  const glm::dvec4 clip = expected.view_projection * point;
  EXPECT_GT(clip.z / clip.w, 0);
  EXPECT_LT(clip.z / clip.w, 1);
  for (const auto depth :
       {capture::ClipDepth::zero_to_one, capture::ClipDepth::one_to_zero, capture::ClipDepth::minus_one_to_one})
    for (const bool y_up : {false, true}) {
      const Camera camera = camera_of(frame_in(depth, y_up), 0);
      const glm::dvec4 found = camera.view_projection * point;
      for (int i = 0; i < 4; ++i) EXPECT_NEAR(found[i], clip[i], 1e-5) << "component " << i;
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(camera.eye[i], expected.eye[i], 1e-5);
    }
}

TEST(SceneCamera, UnusableMatricesAreNamed) {
  capture::Frame frame = frame_in(capture::ClipDepth::one_to_zero, false);
  frame.view[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(camera_of(frame, 3), InputError);
  frame.view = {};
  try {
    camera_of(frame, 3);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("frame 3"), std::string::npos);
  }
}

TEST(SceneCamera, VisibleCornersBoundWhatIsSeen) {
  const Camera camera = camera_of(frame_in(capture::ClipDepth::zero_to_one, true), 0);
  Bounds scene;
  scene.add({-30, 0, -30});
  scene.add({30, 3, 30});
  Bounds seen;
  for (const auto& corner : visible_corners(camera, scene)) seen.add(corner);
  ASSERT_FALSE(seen.empty());
  // Points of the scene that project into the image are inside the box of the corners.
  int inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const glm::dvec3 unit(std::fmod(i * 0.7548776662, 1), std::fmod(i * 0.5698402910, 1),
                          std::fmod(i * 0.3819660113, 1));
    const glm::dvec3 point = scene.low + scene.size() * unit;
    const glm::dvec4 clip = camera.view_projection * glm::dvec4(point, 1);
    if (std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w || clip.z < 0 || clip.z > clip.w) continue;
    ++inside;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(point[axis], seen.low[axis] - 1e-6);
      EXPECT_LE(point[axis], seen.high[axis] + 1e-6);
    }
  }
  EXPECT_GT(inside, 100);
  EXPECT_TRUE(visible_corners(camera, Bounds{}).empty());
  Bounds behind;
  behind.add({1, 2, 10});
  behind.add({2, 3, 12});
  EXPECT_TRUE(visible_corners(camera, behind).empty());
}

TEST(SceneShadow, CascadesCoverWhatIsSeenAndMoveByWholeTexels) {
  constexpr std::uint32_t kSide = 512;
  Bounds scene;
  scene.add({-30, 0, -30});
  scene.add({30, 3, 30});
  const glm::dvec3 sun(0.3, -1, 0.2), mark(0.2, 0.5, -1.5);
  std::array<glm::dvec2, SUBPIXEL_SHADOW_CASCADES> first_place;
  for (int step = 0; step < 8; ++step) {
    const glm::dvec3 eye = glm::dvec3(1, 2, 3) + glm::dvec3(0.013, 0, 0.007) * static_cast<double>(step);
    const Camera camera = camera_of(frame_in(capture::ClipDepth::one_to_zero, false, eye), 0);
    const auto fit = fit_shadow(camera, scene, sun, kSide);
    ASSERT_TRUE(fit);
    for (const auto& corner : visible_corners(camera, scene)) {
      const glm::dvec4 place = fit->world_to_clip(SUBPIXEL_SHADOW_CASCADES - 1) * glm::dvec4(corner, 1);
      for (int axis = 0; axis < 2; ++axis) EXPECT_LT(std::abs(place[axis]), 1 - 20.0 / kSide);
      EXPECT_GT(place.z, 0);
      EXPECT_LT(place.z, 1);
    }
    for (std::size_t c = 0; c < fit->cascades.size(); ++c) {
      const glm::dvec2 place = glm::dvec2(fit->world_to_clip(c) * glm::dvec4(mark, 1)) * (kSide / 2.0);
      if (step == 0) first_place[c] = place;
      const glm::dvec2 moved = place - first_place[c];
      EXPECT_NEAR(moved.x, std::round(moved.x), 1e-6);
      EXPECT_NEAR(moved.y, std::round(moved.y), 1e-6);
      if (c > 0) {
        EXPECT_GT(fit->cascades[c].texel, fit->cascades[c - 1].texel);
      }
    }
    EXPECT_LT(fit->cascades[0].texel, fit->cascades[3].texel / 8);
  }
  EXPECT_FALSE(fit_shadow(camera_of(frame_in(capture::ClipDepth::one_to_zero, false), 0), scene, {0, 0, 0}, kSide));
}

}  // namespace
}  // namespace subpixel::replay
