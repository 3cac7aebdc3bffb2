// What GpuScene puts on the device.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "replay/scene/gpu_scene.hpp"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

capture::Matrix4 scaled(float x, float y, float z) {
  return {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1};
}

TEST(SceneDevice, DrawsAndInstancesFollowSubmissionOrder) {
  auto capture = flat_capture(8, 8);
  const auto first = add_emitter(capture, {1, 1, 1}), second = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, rectangle(-1, -1, 0, 0, 0), second);
  auto& many = add_triangles(capture, rectangle(0, 0, 1, 1, 0), first);
  many.instance_buffer = add_buffer(
      capture, std::vector<capture::Matrix4>{scaled(1, 1, 1), scaled(2, 2, 2), scaled(-1, 1, 1), scaled(0, 1, 1)});
  many.instance_count = 4;
  auto& nothing = add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, first);
  nothing.index_count = 0;

  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, 8, 8);
  ASSERT_EQ(scene.draws().size(), 2u);
  EXPECT_EQ(scene.draws()[0].material, second);
  EXPECT_EQ(scene.draws()[1].material, first);
  EXPECT_EQ(scene.draws()[1].first_instance, 1u);
  EXPECT_EQ(scene.draws()[1].instance_count, 4u);
  EXPECT_EQ(scene.draws()[1].triangle_count, 2u);
  EXPECT_EQ(scene.triangle_count(), 10u);
  EXPECT_EQ(scene.constants().counts.z, 5u);
  const auto records = scene.instances.as<gpu_types::InstanceRecord>();
  EXPECT_EQ(records[2].world_row[0], glm::vec4(2, 0, 0, 0));
  EXPECT_EQ(records[1].normal_row[0].w, 1.0f);
  EXPECT_EQ(records[3].normal_row[0].w, -1.0f);
  // A flattened object still has a normal across the flattened axis.
  EXPECT_GT(std::abs(records[4].normal_row[0].x), 0.5f);
}

TEST(SceneDevice, NormalsTurnWithTheInverseTranspose) {
  auto capture = flat_capture(8, 8);
  auto& draw = add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {1, 1, 1}));
  // Sheared and mirrored, with a translation.
  draw.transform = {2, 0.5f, 0, 0, 0, -3, 1, 0, 1, 0, 0.25f, 0, 5, 6, 7, 1};
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, 8, 8);
  const auto record = scene.instances.as<gpu_types::InstanceRecord>()[0];
  const auto apply = [](const glm::vec4(&rows)[3], const glm::vec3& v) {
    return glm::vec3(glm::dot(glm::vec3(rows[0]), v), glm::dot(glm::vec3(rows[1]), v), glm::dot(glm::vec3(rows[2]), v));
  };
  EXPECT_EQ(record.normal_row[0].w, -1.0f);
  const glm::vec3 normal(0.36f, 0.48f, 0.8f), tangent(0.8f, -0.6f, 0), bitangent = glm::cross(normal, tangent);
  const glm::vec3 moved = apply(record.normal_row, normal);
  EXPECT_NEAR(glm::dot(moved, apply(record.world_row, tangent)), 0, 1e-5);
  EXPECT_NEAR(glm::dot(moved, apply(record.world_row, bitangent)), 0, 1e-5);
  // It stays on the side of the surface it was on.
  EXPECT_GT(glm::dot(moved, apply(record.world_row, normal)), 0);
}

TEST(SceneDevice, MaterialsWithTheSameTexturesShareASet) {
  auto capture = flat_capture(8, 8);
  for (int i = 0; i < 4; ++i) {
    const auto material = add_emitter(capture, {1, 1, 1});
    if (i < 2) capture.materials[material].base_colour_texture = 0;
    add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);
  }
  add_texture(capture, 2, 2, std::vector<std::uint8_t>(16, 200), true);
  GpuScene scene(test_device(), capture, {});
  EXPECT_EQ(scene.material_set(0), scene.material_set(1));
  EXPECT_EQ(scene.material_set(2), scene.material_set(3));
  EXPECT_NE(scene.material_set(0), scene.material_set(2));
  EXPECT_TRUE(scene.has_textures(0));
  EXPECT_FALSE(scene.has_textures(2));
  EXPECT_GT(scene.bytes(), 0u);
}

TEST(SceneDevice, PointLightsAreAsManyAsAskedFor) {
  auto capture = flat_capture(8, 8);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {1, 1, 1}));
  capture.frames[0].point_lights.push_back({{0.5f, 0.5f, 0.5f}, {1, 2, 3}, 4});
  for (const std::uint32_t count : {0u, 1u, 5u, 50u, 256u}) {
    GpuScene scene(test_device(), capture, {.point_lights = count});
    scene.set_frame(0, 8, 8);
    EXPECT_EQ(scene.constants().counts.x, count);
    EXPECT_EQ(scene.features().has(FEATURE_POINT_LIGHTS), count > 0);
    if (count > 0) {
      EXPECT_EQ(scene.constants().point_lights[0].intensity.z, 3.0f);
    }
    for (std::uint32_t i = 0; i < count; ++i)
      EXPECT_GT(scene.constants().point_lights[i].position_range.w, 0.0f) << "light " << i << " of " << count;
  }
  GpuScene as_captured(test_device(), capture, {});
  as_captured.set_frame(0, 8, 8);
  EXPECT_EQ(as_captured.constants().counts.x, 1u);
  EXPECT_THROW(GpuScene(test_device(), capture, {.point_lights = SUBPIXEL_MAX_POINT_LIGHTS + 1}), UsageError);
}

TEST(SceneDevice, WhatCantBeUsedIsNamed) {
  auto capture = flat_capture(8, 8);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {1, 1, 1}));
  GpuScene scene(test_device(), capture, {});
  EXPECT_THROW(scene.set_frame(1, 8, 8), UsageError);
  capture.frames[0].view = {};
  EXPECT_THROW(scene.set_frame(0, 8, 8), InputError);

  auto broken = flat_capture(8, 8);
  broken.materials.emplace_back();
  broken.materials[0].base_colour_texture = 0;
  broken.textures.push_back({"missing bark", capture::TextureEncoding::image_file, true, 0, 0, {std::byte{1}}});
  add_triangles(broken, rectangle(-1, -1, 1, 1, 0), 0);
  try {
    GpuScene refused(test_device(), broken, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("missing bark"), std::string::npos) << error.what();
  }
  // Textures that no draw uses may be anything.
  broken.frames[0].draws.clear();
  EXPECT_NO_THROW(GpuScene(test_device(), broken, {}));
}

TEST(SceneDevice, IsTakenByNumberOrByAPartOfItsName) {
  const auto devices = gpu::vulkan_devices();
  std::size_t lavapipe = 0;
  while (lavapipe < devices.size() && !devices[lavapipe].is_lavapipe) ++lavapipe;
  ASSERT_LT(lavapipe, devices.size());
  EXPECT_TRUE(devices[lavapipe].missing.empty());
  for (const std::string& wanted : {std::to_string(lavapipe), std::string("LLVMpipe")}) {
    gpu::DeviceOptions options;
    options.device = wanted;
    const gpu::Device device(options);
    EXPECT_EQ(device.info().device, devices[lavapipe].name) << wanted;
  }
}

TEST(SceneDevice, OnlyShadowsPayForAShadowMap) {
  auto capture = flat_capture(8, 8);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {1, 1, 1}));
  capture.frames[0].sun = capture::DirectionalLight{{0, 0, -1}, {1, 1, 1}, false};
  GpuScene without(test_device(), capture, {});
  without.set_frame(0, 8, 8);
  EXPECT_EQ(without.shadow_map.description().width, 1u);
  for (const auto& cascade : without.constants().shadow_cascades) EXPECT_EQ(cascade.x, 0.0f);
  capture.frames[0].sun->shadows = true;
  GpuScene with(test_device(), capture, {.shadow_map_size = 256});
  with.set_frame(0, 8, 8);
  EXPECT_EQ(with.shadow_map.description().width, 256u);
  EXPECT_GT(with.constants().shadow_cascades[3].x, 0.0f);
}

}  // namespace
}  // namespace subpixel::replay
