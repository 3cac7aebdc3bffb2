#include "replay/scene/materials.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

capture::Capture one_material(const capture::Material& material) {
  auto capture = flat_capture(8, 8);
  capture.materials.push_back(material);
  add_texture(capture, 1, 1, {255, 255, 255, 255}, true);
  add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 0);
  return capture;
}

std::uint32_t features(const capture::Material& material) {
  return detect_features(one_material(material), PointLights::captured);
}

TEST(SceneFeatures, AreWhatUsedMaterialsNeed) {
  capture::Material material;
  EXPECT_EQ(features(material), 0u);
  material.metallic = 0.5f;
  EXPECT_EQ(features(material), FEATURE_METAL);
  material = {};
  material.emissive = {0, 0.1f, 0};
  EXPECT_EQ(features(material), FEATURE_EMISSIVE);
  material.emissive_texture = 0;
  EXPECT_EQ(features(material), FEATURE_EMISSIVE | FEATURE_EMISSIVE_TEXTURE);
  material.emissive = {0, 0, 0};  // the factor multiplies the texture away
  EXPECT_EQ(features(material), 0u);
  material = {};
  material.normal_texture = 0;
  EXPECT_EQ(features(material), FEATURE_NORMAL_MAP);
  material = {};
  material.metallic_roughness_texture = 0;
  EXPECT_EQ(features(material), FEATURE_ROUGHNESS_TEXTURE | FEATURE_VARYING_ROUGHNESS);
  material = {};
  material.two_sided = true;
  EXPECT_EQ(features(material), FEATURE_TWO_SIDED);
  material = {};
  material.base_colour_texture = 0;
  EXPECT_EQ(features(material), FEATURE_BASE_TEXTURE);
  material.alpha_mode = capture::AlphaMode::test;
  EXPECT_EQ(features(material), FEATURE_BASE_TEXTURE | FEATURE_ALPHA_TEST);
}

TEST(SceneFeatures, AreWhatTexturesAndColoursNeed) {
  capture::Material material;
  // Nothing is read by these.
  material.base_colour_uv.set = 1;
  material.normal_uv.matrix[0] = 2;
  material.normal_scale = 3;
  EXPECT_EQ(features(material), 0u);
  material.base_colour_texture = 0;
  EXPECT_EQ(features(material), FEATURE_BASE_TEXTURE | FEATURE_SECOND_UV);
  material.normal_texture = 0;
  EXPECT_EQ(features(material), FEATURE_BASE_TEXTURE | FEATURE_SECOND_UV | FEATURE_NORMAL_MAP | FEATURE_NORMAL_SCALE |
                                    FEATURE_TEXTURE_TRANSFORM);
  material.normal_uv.matrix[0] = std::numeric_limits<float>::quiet_NaN();  // as if it were not there
  material.normal_scale = 1;
  EXPECT_EQ(features(material), FEATURE_BASE_TEXTURE | FEATURE_SECOND_UV | FEATURE_NORMAL_MAP);
  // Of an unlit material the base colour alone counts.
  material.unlit = true;
  material.roughness = 0.3f;
  material.emissive_texture = material.metallic_roughness_texture = 0;
  EXPECT_EQ(features(material),
            FEATURE_BASE_TEXTURE | FEATURE_SECOND_UV | FEATURE_UNLIT | FEATURE_EMISSIVE | FEATURE_METAL);
  auto capture = one_material(material);
  capture.materials.push_back({});
  add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 1);
  EXPECT_EQ(detect_features(capture, PointLights::captured) & FEATURE_VARYING_ROUGHNESS, 0u);
  capture.textures[0].sampler.wrap_v = capture::Wrap::clamp_to_edge;
  EXPECT_NE(detect_features(capture, PointLights::captured) & FEATURE_SAMPLERS, 0u);
}

TEST(SceneFeatures, TranslucentColoursMakeAnAlphaTest) {
  capture::Material material;
  material.alpha_mode = capture::AlphaMode::test;
  auto capture = one_material(material);
  auto& colour = capture.frames[0].draws[0].colour;
  colour = {0, capture::VertexFormat::float32x3, 0, 12};
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_VERTEX_COLOUR);
  colour.format = capture::VertexFormat::unorm8x4;
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_VERTEX_COLOUR | FEATURE_ALPHA_TEST);
  const auto use = material_uses(capture)[0];
  EXPECT_NE(record_of(capture.materials[0], 0, use).flags.x & MATERIAL_ALPHA_TEST, 0u);
  capture.materials[0].alpha_mode = capture::AlphaMode::opaque;
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_VERTEX_COLOUR);
}

TEST(SceneFeatures, SpotLightsAreThoseThatAreKept) {
  auto capture = one_material({});
  capture.frames[0].point_lights.resize(2);
  capture.frames[0].point_lights[1].cone.emplace();
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_POINT_LIGHTS | FEATURE_SPOT_LIGHTS);
  EXPECT_EQ(detect_features(capture, PointLights::none), 0u);
}

TEST(SceneFeatures, IgnoreMaterialsNothingUses) {
  auto capture = one_material({});
  capture::Material unused;
  unused.metallic = 1;
  unused.roughness = 0.1f;
  capture.materials.push_back(unused);
  EXPECT_EQ(detect_features(capture, PointLights::captured), 0u);
  add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 1);
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_METAL | FEATURE_VARYING_ROUGHNESS);
}

TEST(SceneFeatures, LightsOfAllFramesCount) {
  auto capture = one_material({});
  capture.frames.push_back(capture.frames[0]);
  capture.frames[1].sun = capture::DirectionalLight{{0, -1, 0}, {1, 1, 1}, false};
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_SUN);
  capture.frames[1].sun->shadows = true;
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_SUN | FEATURE_SHADOWS);
  capture.frames[1].sun->irradiance = {0, 0, 0};
  EXPECT_EQ(detect_features(capture, PointLights::captured), 0u);
  capture.frames[0].point_lights.emplace_back();
  EXPECT_EQ(detect_features(capture, PointLights::captured), FEATURE_POINT_LIGHTS);
  EXPECT_EQ(detect_features(capture, PointLights::none), 0u);
  capture.frames[0].point_lights.clear();
  EXPECT_EQ(detect_features(capture, PointLights::some), FEATURE_POINT_LIGHTS);
}

TEST(SceneMaterials, AlphaDecidesOnlyWhereItCan) {
  capture::Material material;
  material.base_colour[3] = 0.6f;
  EXPECT_FALSE(is_alpha_tested(material));
  material.alpha_mode = capture::AlphaMode::test;
  EXPECT_FALSE(is_alpha_tested(material));  // 0.6 passes 0.5 everywhere
  material.base_colour[3] = 0.4f;
  EXPECT_TRUE(is_alpha_tested(material));
  material.alpha_mode = capture::AlphaMode::blend;
  material.base_colour[3] = 0.9f;
  EXPECT_TRUE(is_alpha_tested(material));  // a tenth of the samples shows what is behind
  material.base_colour[3] = 1.0f;
  EXPECT_FALSE(is_alpha_tested(material));
  material.base_colour_texture = 0;
  EXPECT_TRUE(is_alpha_tested(material));
}

TEST(SceneMaterials, TextureIsCutAtTheLowestCutoffOfItsMaterials) {
  capture::Material first;
  first.base_colour_texture = 0;
  first.alpha_mode = capture::AlphaMode::test;
  first.alpha_cutoff = 0.6f;
  auto capture = one_material(first);
  ASSERT_EQ(texture_uses(capture).size(), 1u);
  EXPECT_FLOAT_EQ(texture_uses(capture)[0].alpha_cutoff.value(), 0.6f);
  first.alpha_cutoff = 0.2f;
  first.base_colour[3] = 0.5f;  // alpha 0.4 of the texture is 0.2 of the material
  capture.materials.push_back(first);
  add_triangles(capture, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 1);
  EXPECT_FLOAT_EQ(texture_uses(capture)[0].alpha_cutoff.value(), 0.4f);
  EXPECT_TRUE(texture_uses(capture)[0].alpha_weighted);
}

}  // namespace
}  // namespace subpixel::replay
