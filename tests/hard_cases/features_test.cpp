// Only what a scene needs is modelled: a plain scene holds no texture coordinates, tangents, textures or shadow map,
// its shaders read none of the data that only absent features use, and specialised shaders show what general ones show.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "replay/frame/run_frame.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"
#include "tests/technique/rich_scene.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

// Nothing but one opaque material and a sun without shadows.
capture::Capture plain_scene() {
  return capture::generate("cube", {.frames = 1, .width = 48, .height = 36});
}

constexpr std::uint64_t kEmptyBuffer = 16;  // gpu::Buffer's size for no bytes

TEST(Features, APlainSceneAllocatesNothingItDoesNotNeed) {
  FrameScene plain(test_device(), plain_scene());
  EXPECT_EQ(plain.scene.features().bits, FEATURE_SUN);
  EXPECT_EQ(plain.scene.uvs.bytes(), kEmptyBuffer);
  EXPECT_EQ(plain.scene.tangents.bytes(), kEmptyBuffer);
  for (const gpu::Buffer* buffer : {&plain.scene.second_uvs, &plain.scene.colours, &plain.scene.uv_mappings,
                                    &plain.scene.spot_cones, &plain.scene.light_cells})
    EXPECT_EQ(buffer->bytes(), kEmptyBuffer) << buffer->name();
  EXPECT_EQ(plain.scene.shadow_map.description().width, 1u);
  // The whole ledger: geometry, one material, and two images of a texel.
  const std::uint64_t needed = plain.scene.positions.bytes() + plain.scene.normals.bytes() +
                               plain.scene.indices.bytes() + plain.scene.instances.bytes() +
                               plain.scene.materials.bytes() + plain.scene.frame_constants.bytes() +
                               plain.scene.shadow_map.bytes() + 7 * kEmptyBuffer;
  EXPECT_LE(plain.scene.bytes() - needed, 4096u) << "the white texel's image and nothing else";

  FrameScene general(test_device(), plain_scene(), {.forced_features = kAllFeatures});
  EXPECT_EQ(general.scene.features().bits, kAllFeatures);
  EXPECT_GT(general.scene.uvs.bytes(), kEmptyBuffer);
  EXPECT_GT(general.scene.tangents.bytes(), kEmptyBuffer);
  EXPECT_GT(general.scene.second_uvs.bytes(), kEmptyBuffer);
  EXPECT_GT(general.scene.colours.bytes(), kEmptyBuffer);
  EXPECT_EQ(general.scene.shadow_map.description().width, 2048u);
  EXPECT_GT(general.scene.bytes(), plain.scene.bytes() + 4 * 2048 * 2048);
}

TEST(Features, WithoutShadowsNoPassRunsBeforeTheTechniques) {
  FrameScene plain(test_device(), plain_scene());
  const double before = test_device().total_ms();
  plain.scene.set_frame(0, plain.width(), plain.height());
  EXPECT_EQ(test_device().total_ms(), before);
  capture::Capture shadowed = plain_scene();
  shadowed.frames[0].sun->shadows = true;
  FrameScene with(test_device(), shadowed);
  const double between = test_device().total_ms();
  with.scene.set_frame(0, with.width(), with.height());
  EXPECT_GT(test_device().total_ms(), between);
}

// Metal without roughness that varies: of the used materials, which the first is none of.
capture::Capture metal_scene() {
  capture::Capture capture = plain_scene();
  capture.materials.push_back(capture.materials[0]);
  const auto used = static_cast<std::uint32_t>(capture.materials.size() - 1);
  for (auto& draw : capture.frames[0].draws) draw.material = used;
  capture.materials[used].metallic = 0.625f;
  capture.materials[used].roughness = 0.3711f;
  capture.materials[0].roughness = 0.9f;
  return capture;
}

// Spheres of several roughnesses, and of metal or not.
capture::Capture rough_scene(bool metal) {
  capture::Capture capture = capture::generate("spheres", {.frames = 1, .width = 48, .height = 36});
  for (auto& material : capture.materials) material.metallic = metal ? material.metallic : 0.0f;
  return capture;
}

// Full G-buffer samples take 8 bytes on the device where that is enough, and show what 16 bytes show. Emission that the
// scene does not have, forced on, widens them and changes nothing else.
TEST(Features, FullSamplesTakeNoMoreWordsThanTheSceneNeeds) {
  struct SampleCase {
    const char* name;
    capture::Capture capture;
    std::uint32_t needs;  // of what decides
    bool narrow;
  };
  const std::uint32_t deciding = FEATURE_EMISSIVE | FEATURE_METAL | FEATURE_VARYING_ROUGHNESS;
  const SampleCase cases[] = {
      {"plain", plain_scene(), 0, true},
      {"metal", metal_scene(), FEATURE_METAL, true},
      {"roughness", rough_scene(false), FEATURE_VARYING_ROUGHNESS, true},
      {"metal and roughness", rough_scene(true), FEATURE_METAL | FEATURE_VARYING_ROUGHNESS, false},
  };
  // Samples or surfaces whose attributes a technique holds at once.
  const std::pair<const char*, std::uint64_t> holders[] = {
      {"fxaa", 1}, {"smaa", 1}, {"msaa", 8}, {"simple_complex", 8}, {"sbaa", 4}};
  for (const SampleCase& of : cases) {
    FrameScene fitted(test_device(), of.capture),
        wide(test_device(), of.capture, {.forced_features = FEATURE_EMISSIVE});
    ASSERT_EQ(fitted.scene.features().bits & deciding, of.needs) << of.name;
    for (const auto& [name, layers] : holders) {
      SCOPED_TRACE(fmt::format("{}, {}", of.name, name));
      const FrameRun a = run_frame(fitted, find_technique(name).with()),
                     b = run_frame(wide, find_technique(name).with());
      EXPECT_EQ(b.memory.allocated_bytes - a.memory.allocated_bytes,
                of.narrow ? 8 * layers * fitted.width() * fitted.height() : 0);
      EXPECT_EQ(a.radiance.pixels, b.radiance.pixels);
      EXPECT_EQ(a.display.pixels, b.display.pixels);
      EXPECT_EQ(a.executions, b.executions);
      EXPECT_GT(std::ranges::max(a.executions), 0.0f);
    }
  }
  // General shaders have the wide samples.
  FrameScene general(test_device(), plain_scene(), {.forced_features = kAllFeatures}),
      wide(test_device(), plain_scene(), {.forced_features = FEATURE_EMISSIVE});
  for (const auto& [name, layers] : holders)
    EXPECT_EQ(run_frame(general, find_technique(name).with()).memory.allocated_bytes,
              run_frame(wide, find_technique(name).with()).memory.allocated_bytes)
        << name;
}

std::vector<std::string> pass_names(const FrameRun& run) {
  std::vector<std::string> names;
  for (const PassTime& pass : run.ms.passes) names.push_back(pass.name);
  return names;
}

class FeaturesOf : public testing::TestWithParam<const Technique*> {};

// Whatever only absent features read is made useless: a shader that still looked at it would show.
TEST_P(FeaturesOf, APlainScenesShadersReadNothingElse) {
  FrameScene scene(test_device(), plain_scene());
  const FrameRun expected = run_frame(scene, GetParam()->with());
  constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
  for (gpu_types::MaterialRecord& material : scene.scene.materials.as<gpu_types::MaterialRecord>()) {
    material.base_colour.w = kBad;
    material.emissive_cutoff = glm::vec4(kBad);
    material.metal_rough.x = material.metal_rough.z = kBad;
    material.flags.x |= MATERIAL_BASE_TEXTURE | MATERIAL_ALPHA_TEST | MATERIAL_NORMAL_MAP | MATERIAL_ROUGHNESS_TEXTURE |
                        MATERIAL_EMISSIVE_TEXTURE | MATERIAL_ALPHA_BLEND | MATERIAL_UNLIT | 15 * MATERIAL_SECOND_UV;
    material.flags.y = 1u << 30;
  }
  auto& frame = scene.scene.frame_constants.as<gpu_types::FrameConstants>()[0];
  frame.shadow_matrix = glm::mat4(kBad);
  for (auto& cascade : frame.shadow_cascades) cascade = glm::vec4(kBad);
  for (auto& light : frame.point_lights) light = {glm::vec4(kBad), glm::vec4(kBad)};
  frame.counts.x = SUBPIXEL_MAX_POINT_LIGHTS;
  const FrameRun result = run_frame(scene, GetParam()->with());
  EXPECT_EQ(result.radiance.pixels, expected.radiance.pixels);
  EXPECT_EQ(result.executions, expected.executions);
}

// A material that no draw has decides nothing, least of all the roughness of those that are drawn.
TEST_P(FeaturesOf, AMaterialThatIsNotDrawnChangesNothing) {
  capture::Capture capture = metal_scene();
  FrameScene scene(test_device(), capture);
  capture.materials[0] = capture.materials[1];
  FrameScene same(test_device(), capture);
  ASSERT_EQ(scene.scene.features().bits & FEATURE_VARYING_ROUGHNESS, 0u);
  std::vector<ParameterValues> settings{{}};
  if (GetParam()->name == "streaming" || GetParam()->name == "agaa") settings.push_back({{"samples", 16}});
  for (const ParameterValues& values : settings) {
    const FrameRun a = run_frame(scene, GetParam()->with(values)), b = run_frame(same, GetParam()->with(values));
    EXPECT_EQ(a.display.pixels, b.display.pixels);
    EXPECT_EQ(a.executions, b.executions);
  }
}

// As many lights as a frame may have, of which the last alone shines: it must reach every surface of a pixel. Lights
// without intensity add 0.
TEST_P(FeaturesOf, TheLastOfManyLightsIsLit) {
  capture::Capture capture = capture::generate("hard_many_lights", {.frames = 1, .width = 48, .height = 36});
  auto& lights = capture.frames[0].point_lights;
  capture::PointLight bright = lights[0];
  bright.position = {0, 0.5f, 1};
  bright.intensity = {4, 3, 2};
  bright.range = 20;
  capture::PointLight dark = bright;
  dark.intensity = {0, 0, 0};
  lights = {bright};
  FrameScene alone(test_device(), capture);
  const FrameRun expected = run_frame(alone, GetParam()->with());
  lights.assign(SUBPIXEL_MAX_POINT_LIGHTS, dark);
  lights.back() = bright;
  FrameScene last(test_device(), capture);
  const FrameRun result = run_frame(last, GetParam()->with());
  EXPECT_EQ(result.radiance.pixels, expected.radiance.pixels);
  EXPECT_GT(*std::max_element(result.radiance.pixels.begin(), result.radiance.pixels.end()), 0.01f);
}

TEST_P(FeaturesOf, FittedLayoutsHoldOnlyWhatTheSceneNeeds) {
  FrameScene plain(test_device(), plain_scene());
  FrameScene general(test_device(), plain_scene(), {.forced_features = kAllFeatures});
  const FrameRun fitted = run_frame(plain, GetParam()->with()), full = run_frame(general, GetParam()->with());
  EXPECT_EQ(fitted.memory.paper_bytes_per_pixel, full.memory.paper_bytes_per_pixel)
      << "a publication's format is what it is";
  EXPECT_LE(fitted.memory.fitted_bytes_per_pixel, full.memory.fitted_bytes_per_pixel);
  // These keep colours and triangles, which every scene needs.
  if (GetParam()->name != "forward" && GetParam()->name != "visibility") {
    EXPECT_LT(fitted.memory.fitted_bytes_per_pixel, full.memory.fitted_bytes_per_pixel);
  }
  EXPECT_LE(fitted.memory.allocated_bytes, full.memory.allocated_bytes);
  EXPECT_EQ(pass_names(fitted), pass_names(full));
}

TEST_P(FeaturesOf, GeneralShadersShowTheSame) {
  for (const std::string_view name : {"cube", "quads", "spheres", "hard_alpha_foliage", "hard_shadow_albedo", "rich"}) {
    const capture::Capture capture = name == "rich" ? rich_scene(UvSource::transforms)
                                                    : capture::generate(name, {.frames = 1, .width = 48, .height = 36});
    FrameScene specialised(test_device(), capture);
    FrameScene general(test_device(), capture, {.forced_features = kAllFeatures});
    ASSERT_NE(specialised.scene.features().bits, kAllFeatures) << name;
    const FrameRun a = run_frame(specialised, GetParam()->with()), b = run_frame(general, GetParam()->with());
    EXPECT_EQ(a.executions, b.executions) << name;
    // Compilers round sums of other terms differently: a hundredth of an 8-bit step. A filter that compares neighbours
    // may then decide otherwise in a pixel; history carries that on.
    const std::string_view technique = GetParam()->name;
    const std::size_t allowed = technique == "fxaa" || technique == "smaa" ? 6 : technique == "taa" ? 48 : 0;
    std::size_t other = 0;
    for (std::size_t i = 0; i < a.display.pixels.size(); ++i)
      other += std::abs(a.display.pixels[i] - b.display.pixels[i]) < 4e-5f ? 0 : 1;
    EXPECT_LE(other, allowed) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, FeaturesOf,
                         testing::ValuesIn(std::vector<const Technique*>(techniques().begin(), techniques().end())),
                         [](const auto& technique) { return std::string(technique.param->name); });

}  // namespace
}  // namespace subpixel::replay
