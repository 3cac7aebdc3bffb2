#include "replay/scene/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "replay/scene/tangents.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

struct Filled {
  GeometryPlan plan;
  std::vector<float> positions, normals, uvs, tangents;
  std::vector<std::uint32_t> indices;
  std::vector<Bounds> bounds;
};

Filled fill(const capture::Capture& capture, VertexNeeds needs) {
  Filled f;
  f.plan = plan_geometry(capture, needs);
  const std::size_t count = f.plan.vertex_count;
  f.positions.resize(3 * count);
  f.normals.resize(3 * count);
  if (needs.uvs) f.uvs.resize(2 * count);
  if (needs.tangents) f.tangents.resize(4 * count);
  f.indices.resize(f.plan.index_count);
  f.bounds = fill_geometry(capture, f.plan, {f.positions, f.normals, f.uvs, f.tangents, f.indices});
  return f;
}

TEST(SceneGeometry, DrawsOfAllFramesShareStreamsAndMeshes) {
  auto capture = flat_capture(8, 8);
  const auto material = add_emitter(capture, {1, 1, 1});
  capture::Draw& draw = add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);
  draw.normal = draw.position;  // any stream: what matters is that there is one
  draw.index_type = capture::IndexType::uint16;
  draw.index_buffer = add_buffer(capture, std::vector<std::uint16_t>{0, 1, 2, 3, 4, 5});
  capture::Draw half = draw;  // same vertices, other index range
  half.index_offset = 6;
  half.index_count = 3;
  capture.frames.push_back(capture.frames[0]);
  capture.frames[1].draws.push_back(half);

  const auto f = fill(capture, {});
  EXPECT_EQ(f.plan.vertex_sets.size(), 1u);
  EXPECT_EQ(f.plan.vertex_count, 6u);
  ASSERT_EQ(f.plan.meshes.size(), 2u);
  EXPECT_EQ(f.plan.mesh_of_draw[0], (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(f.plan.mesh_of_draw[1], (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(f.plan.meshes[1].triangle_count, 1u);
  EXPECT_EQ(f.indices, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 3, 4, 5}));
}

TEST(SceneGeometry, AbsentNormalsBecomeFlat) {
  auto capture = flat_capture(8, 8);
  const auto material = add_emitter(capture, {1, 1, 1});
  // Two triangles over a shared edge, indexed: one faces +z, the other +x.
  capture::Draw& draw = add_triangles(capture, {0, 0, 0, 0, -1, 0, 0, 1, 0, -1, 0, 0, 0, 0, -1}, material);
  draw.index_type = capture::IndexType::uint32;
  draw.index_buffer = add_buffer(capture, std::vector<std::uint32_t>{1, 2, 3, 1, 4, 2});
  draw.index_count = 6;
  const auto f = fill(capture, {});
  ASSERT_EQ(f.plan.vertex_count, 6u);
  EXPECT_EQ(f.indices, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FLOAT_EQ(f.normals[3 * i + 2], 1);
    EXPECT_FLOAT_EQ(f.normals[9 + 3 * i], 1);
  }
}

TEST(SceneGeometry, BrokenVerticesDontReachBoundsNormalsOrUvs) {
  auto capture = flat_capture(8, 8);
  const auto material = add_emitter(capture, {1, 1, 1});
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  capture::Draw& draw =
      add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0, nan, 5, 5, infinity, 5, 5, 1e30f, 5, 5}, material);
  draw.normal = {add_buffer(capture, std::vector<float>(18, nan)), capture::VertexFormat::float32x3, 0, 12};
  draw.uv = {add_buffer(capture, std::vector<float>(12, infinity)), capture::VertexFormat::float32x2, 0, 8};
  const auto f = fill(capture, {true, false});
  EXPECT_EQ(f.bounds[0].low, glm::dvec3(0, 0, 0));
  EXPECT_EQ(f.bounds[0].high, glm::dvec3(1, 1, 0));
  for (const float value : f.normals) EXPECT_TRUE(std::isfinite(value));
  for (const float value : f.uvs) EXPECT_EQ(value, 0.0f);
  EXPECT_TRUE(std::isnan(f.positions[9]));
}

TEST(SceneGeometry, NormalsComeOutUnit) {
  auto capture = flat_capture(8, 8);
  const auto material = add_emitter(capture, {1, 1, 1});
  capture::Draw& draw = add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, material);
  draw.normal = {add_buffer(capture, std::vector<float>{0, 0, 1e-20f, 3, 0, 4, 1e30f, 0, 0}),
                 capture::VertexFormat::float32x3, 0, 12};
  const auto f = fill(capture, {});
  EXPECT_FLOAT_EQ(f.normals[2], 1);
  EXPECT_FLOAT_EQ(f.normals[3], 0.6f);
  EXPECT_FLOAT_EQ(f.normals[5], 0.8f);
  EXPECT_FLOAT_EQ(f.normals[6], 1);
}

TEST(SceneTangents, FollowGrowingUAndSignTheBitangentUpTheImage) {
  const std::vector<float> positions{-1, -1, 0, 1, -1, 0, 1, 1, 0};
  const std::vector<float> normals{0, 0, 1, 0, 0, 1, 0, 0, 1};
  const auto upright = tangents_from_uvs(positions, normals, {0, 1, 1, 1, 1, 0}, {0, 1, 2});
  // u grows along +x; v falls along +y, so the image is upright and cross(normal, tangent) = +y is up.
  EXPECT_EQ(std::vector<float>(upright.begin(), upright.begin() + 4), (std::vector<float>{1, 0, 0, 1}));
  const auto mirrored = tangents_from_uvs(positions, normals, {1, 1, 0, 1, 0, 0}, {0, 1, 2});
  EXPECT_EQ(std::vector<float>(mirrored.begin(), mirrored.begin() + 4), (std::vector<float>{-1, 0, 0, -1}));
  const auto none = tangents_from_uvs(positions, normals, {1, 1, 1, 1, 1, 1}, {0, 1, 2});
  EXPECT_EQ(none, std::vector<float>(12, 0.0f));
}

TEST(SceneGeometry, MakesTangentsOnlyWhereAMapNeedsThem) {
  auto capture = flat_capture(8, 8);
  const auto plain = add_emitter(capture, {1, 1, 1}), mapped = add_emitter(capture, {1, 1, 1});
  capture.materials[mapped].normal_texture = add_texture(capture, 1, 1, {128, 128, 255, 255}, false);
  const auto uvs = add_buffer(capture, rectangle_uvs());
  for (const auto material : {plain, mapped})
    add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material).uv = {uvs, capture::VertexFormat::float32x2, 0, 8};
  const auto f = fill(capture, {true, true});
  ASSERT_EQ(f.plan.vertex_sets.size(), 2u);
  EXPECT_EQ(f.tangents[0], 0.0f);
  EXPECT_FLOAT_EQ(f.tangents[4 * 6], 1.0f);
}

}  // namespace
}  // namespace subpixel::replay
