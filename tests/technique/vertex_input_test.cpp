// Second texture coordinates, texture transforms, vertex colours and normal scales, by every path: against the same
// scene with transforms baked into its coordinates, and against colours known without rendering.
#include <gtest/gtest.h>

#include <random>

#include "tests/technique/every_path.hpp"
#include "tests/technique/rich_scene.hpp"

namespace subpixel::replay {
namespace {

TEST(SceneVertexInputs, SecondCoordinatesAndTransformsAreWhatBakedOnesShow) {
  // The same from transforms of the first set, from the second set alone, and from one of each.
  const auto transformed = rich_scene(UvSource::transforms), baked = rich_scene(UvSource::baked);
  const auto mixed = rich_scene(UvSource::mixed);
  const auto a = every_path(transformed, kRichWidth, kRichHeight), b = every_path(baked, kRichWidth, kRichHeight);
  const auto c = every_path(mixed, kRichWidth, kRichHeight);
  ASSERT_EQ(a.size(), techniques().size() + 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    expect_same_image(a[i], b[i], 2e-3, 6);
    expect_same_image(c[i], b[i], 2e-3, 6);
  }
  // And not what they show without.
  auto plain = transformed;
  for (auto& material : plain.materials)
    material.base_colour_uv = material.metallic_roughness_uv = material.normal_uv = material.emissive_uv = {};
  const auto untransformed = technique_path(plain, "noaa", kRichWidth, kRichHeight);
  const auto noaa = technique_path(transformed, "noaa", kRichWidth, kRichHeight);
  std::size_t others = 0;
  for (std::size_t i = 0; i < noaa.radiance.size(); ++i)
    others += glm::length(noaa.radiance[i] - untransformed.radiance[i]) > 0.05f ? 1 : 0;
  EXPECT_GT(others, noaa.radiance.size() / 4);
}

TEST(SceneVertexInputs, ShadowsOfAlphaTestedTexturesAreWhereTheirCoordinatesSay) {
  // The plate lets the sun through where its texture is transparent: of the floor, the half that the transform shows.
  for (const bool second : {false, true}) {
    auto capture = flat_capture(32, 32);
    capture.frames[0].ambient = {0, 0, 0};
    capture.frames[0].sun = capture::DirectionalLight{{0, 0, -1}, {3, 3, 3}, true};
    capture::Material floor, plate;
    plate.alpha_mode = capture::AlphaMode::test;
    plate.base_colour_texture = add_texture(capture, 2, 1, {255, 255, 255, 255, 255, 255, 255, 0}, true);
    plate.base_colour_uv.matrix = {-1, 0, 1, 0, 1, 0};  // the right half covers
    plate.base_colour_uv.set = second ? 1 : 0;
    capture.materials = {floor, plate};
    // The plate turns its back to the camera, so that the floor is seen through it.
    add_triangles(capture, rectangle(-1, -1, 1, 1, -0.5f), 0);
    auto& draw = add_triangles(capture, rectangle(1, -1, -1, 1, 0.5f), 1);
    auto& stream = second ? draw.uv2 : draw.uv;
    stream = {add_buffer(capture, std::vector<float>{1, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}),
              capture::VertexFormat::float32x2, 0, 8};
    const PathImage path = technique_path(capture, "noaa", 32, 32);
    EXPECT_GT(path.radiance[16 * 32 + 6].x, 0.3f) << "second " << second;
    EXPECT_EQ(path.radiance[16 * 32 + 25].x, 0.0f) << "second " << second;
  }
}

TEST(SceneVertexInputs, ColoursMultiplyTheBaseColour) {
  auto capture = flat_capture(32, 32);
  capture::Material material;
  material.unlit = true;
  material.base_colour = {0.5f, 1, 0.25f, 1};
  capture.materials.push_back(material);
  auto& draw = add_triangles(capture, rectangle(-1, -1, 1, 0, 0), 0);
  // Red to blue from left to right, three floats each.
  draw.colour = {
      add_buffer(capture, std::vector<float>{1, 0.5f, 0, 0, 0.5f, 1, 0, 0.5f, 1, 1, 0.5f, 0, 0, 0.5f, 1, 1, 0.5f, 0}),
      capture::VertexFormat::float32x3, 0, 12};
  // A draw without colours beside it is white; values that are none are black.
  add_triangles(capture, rectangle(-1, 0, 0, 1, 0), 0);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  auto& broken = add_triangles(capture, rectangle(0, 0, 1, 1, 0), 0);
  std::vector<float> values;
  for (int corner = 0; corner < 6; ++corner) values.insert(values.end(), {nan, -1, infinity, 1});
  broken.colour = {add_buffer(capture, values), capture::VertexFormat::float32x4, 0, 16};
  const ExpectedAt expected = [](double x, double y) -> std::optional<glm::dvec3> {
    if (x < 0 || y < 0 || x > 32 || y > 32 || std::abs(y - 16) < 0.5) return std::nullopt;
    if (y < 16)
      return x < 15.5   ? std::optional(glm::dvec3(0.5, 1, 0.25))
             : x > 16.5 ? std::optional(glm::dvec3(0))
                        : std::nullopt;
    return glm::dvec3(0.5, 1, 0.25) * glm::dvec3(1 - x / 32, 0.5, x / 32);
  };
  for (const PathImage& path : every_path(capture, 32, 32)) expect_image(path, 32, expected, 0.012, 0.012);
}

TEST(SceneVertexInputs, AlphaOfColoursCounts) {
  // Alpha rises from 0 on the left to 1 on the right. Above, a test at 0.25 of factor 0.5 cuts in the middle; below, a
  // blended material covers what its alpha says.
  auto capture = flat_capture(32, 32);
  capture.frames[0].sky = {0, 0, 1};
  for (const auto mode : {capture::AlphaMode::test, capture::AlphaMode::blend}) {
    capture::Material material;
    material.unlit = true;
    material.base_colour = {1, 0, 0, mode == capture::AlphaMode::test ? 0.5f : 1.0f};
    material.alpha_mode = mode;
    material.alpha_cutoff = 0.25f;
    const bool above = mode == capture::AlphaMode::test;
    auto& draw = add_triangles(capture, rectangle(-1, above ? 0 : -1, 1, above ? 1 : 0, 0),
                               static_cast<std::uint32_t>(capture.materials.size()));
    capture.materials.push_back(material);
    std::vector<float> colours;
    for (const float right : {0.0f, 1.0f, 1.0f, 0.0f, 1.0f, 0.0f}) colours.insert(colours.end(), {1, 1, 1, right});
    draw.colour = {add_buffer(capture, colours), capture::VertexFormat::float32x4, 0, 16};
  }
  const ExpectedAt expected = [](double x, double y) -> std::optional<glm::dvec3> {
    if (x < 0 || y < 0 || x > 32 || y > 32 || std::abs(y - 16) < 0.5 || std::abs(x - 16) < 0.5) return std::nullopt;
    const double covered = y < 16 ? (x < 16 ? 0.0 : 1.0) : x / 32;
    return glm::dvec3(covered, 0, 1 - covered);
  };
  for (const PathImage& path : every_path(capture, 32, 32)) {
    // One sample shows all or nothing of a blended surface; others in steps.
    const bool one_sample = path.name.starts_with("noaa") || path.name.starts_with("fxaa") ||
                            path.name.starts_with("smaa") || path.name.starts_with("taa");
    const ExpectedAt upper = [&](double x, double y) { return y < 16 || !one_sample ? expected(x, y) : std::nullopt; };
    expect_image(path, 32, upper, 0.14, 0.12);
  }
  for (const char* alpha : {"test", "per_sample"}) {
    const ExpectedAt tested = [&](double x, double y) { return y < 16 ? expected(x, y) : std::nullopt; };
    for (const char* technique : {"msaa", "streaming", "dcaa"})
      expect_image(technique_path(capture, technique, 32, 32, {{"alpha", alpha}}), 32, tested, 0.01, 0.01);
  }
}

TEST(SceneVertexInputs, TransparentColoursCastNoShadow) {
  auto capture = flat_capture(32, 32);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sun = capture::DirectionalLight{{0, 0, -1}, {3, 3, 3}, true};
  capture::Material floor, plate;
  plate.alpha_mode = capture::AlphaMode::test;
  capture.materials = {floor, plate};
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.5f), 0);
  auto& draw = add_triangles(capture, rectangle(1, -1, -1, 1, 0.5f), 1);  // its back towards the camera
  std::vector<float> colours;
  for (const float alpha : {0.0f, 1.0f, 1.0f, 0.0f, 1.0f, 0.0f}) colours.insert(colours.end(), {1, 1, 1, alpha});
  draw.colour = {add_buffer(capture, colours), capture::VertexFormat::float32x4, 0, 16};
  for (const PathImage& path : {technique_path(capture, "noaa", 32, 32), reference_path(capture, 32, 32)}) {
    EXPECT_EQ(path.radiance[16 * 32 + 6].x, 0.0f) << path.name;
    EXPECT_GT(path.radiance[16 * 32 + 25].x, 0.3f) << path.name;
  }
}

TEST(SceneVertexInputs, ANormalMapIsScaled) {
  // A map that leans by atan(1/2) along u, scaled to a lean of atan(2) and of 0; the sun comes from where it leans to.
  for (const float scale : {4.0f, 0.0f, 1.0f}) {
    auto capture = flat_capture(16, 16);
    capture.frames[0].ambient = {0, 0, 0};
    capture.frames[0].sun = capture::DirectionalLight{{-0.6f, 0, -0.8f}, {1, 1, 1}, false};
    capture::Material material;
    material.roughness = 1;
    material.metallic = 0;
    material.normal_scale = scale;
    const glm::dvec2 mapped = glm::dvec2(1, 2) / std::sqrt(5.0);
    const auto byte = [](double n) { return static_cast<std::uint8_t>(std::lround((n * 0.5 + 0.5) * 255)); };
    material.normal_texture = add_texture(capture, 1, 1, {byte(mapped.x), 128, byte(mapped.y), 255}, false);
    capture.materials.push_back(material);
    auto& draw = add_triangles(capture, rectangle(-1, -1, 1, 1, 0), 0);
    draw.uv = {add_buffer(capture, rectangle_uvs()), capture::VertexFormat::float32x2, 0, 8};
    // The same by vertex normals.
    auto plain = capture;
    plain.materials[0].normal_texture = capture::kNone;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(scale * mapped.x, 0, mapped.y));
    std::vector<float> normals;
    for (int corner = 0; corner < 6; ++corner)
      for (int c = 0; c < 3; ++c) normals.push_back(static_cast<float>(normal[c]));
    plain.frames[0].draws[0].normal = {add_buffer(plain, normals), capture::VertexFormat::float32x3, 0, 12};
    const auto a = every_path(capture, 16, 16);
    const auto b = technique_path(plain, "noaa", 16, 16);
    EXPECT_GT(b.radiance[8 * 16 + 8].x, 0.1f);
    for (const PathImage& path : a)
      EXPECT_NEAR(path.radiance[8 * 16 + 8].x, b.radiance[8 * 16 + 8].x, 0.01) << path.name << " scale " << scale;
  }
}

}  // namespace
}  // namespace subpixel::replay
