// The procedural scenes: the same bytes for the same options, sound captures, frames that move a little.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>
#include <span>
#include <tuple>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/reading/reader.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/generate/generate.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {
namespace {

GenerateOptions small_options() {
  return {.frames = 2, .width = 64, .height = 36, .seed = 7, .density = 0.05};
}

std::string hash_of(std::string_view scene, const GenerateOptions& options) {
  return content_hash_hex(encode_capture(generate(scene, options), {.zstd_level = 0}));
}

class GeneratedScene : public testing::TestWithParam<std::string> {};

TEST_P(GeneratedScene, IsASoundCapture) {
  const Capture capture = generate(GetParam(), small_options());
  ASSERT_EQ(capture.frames.size(), 2u);
  EXPECT_EQ(capture.frames[0].width, 64u);
  EXPECT_EQ(capture.frames[0].height, 36u);
  for (const Problem& problem : validate_capture(capture)) {
    if (GetParam() == "empty" && problem.why == "no draw calls") continue;
    // Allowed, since engines record such vertices; replay leaves their triangles out.
    if (GetParam() == "hard_bad_vertices" && problem.severity == Problem::Severity::note) continue;
    ADD_FAILURE() << problem.where << ": " << problem.why;
  }
  EXPECT_EQ(encode_capture(decode_capture(encode_capture(capture))), encode_capture(capture));
}

TEST_P(GeneratedScene, IsTheSameEveryTime) {
  EXPECT_EQ(hash_of(GetParam(), small_options()), hash_of(GetParam(), small_options()));
}

TEST_P(GeneratedScene, MovesFromFrameToFrame) {
  const Capture capture = generate(GetParam(), small_options());
  EXPECT_NE(capture.frames[0].view, capture.frames[1].view);
  for (std::size_t i = 12; i < 15; ++i) EXPECT_NEAR(capture.frames[0].view[i], capture.frames[1].view[i], 0.2);
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const SceneInfo& scene : list_scenes()) names.emplace_back(scene.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, GeneratedScene, testing::ValuesIn(scene_names()),
                         [](const auto& scene) { return scene.param; });

// The bytes of other machines: a change here is a change of every capture made with these names, and wants a new number
// of the generator in scene_metadata.hpp.
TEST(GenerateScenes, GoldenBytes) {
  const std::pair<const char*, const char*> golden[] = {
      {"grass", "02cc341fdd52a4a8e76e4904bf5fe53a"},     {"city", "c492598550ba1054ca3c2bd8d0eb42a0"},
      {"fur", "ee76e3c513475056b2d80b15b4d9f9c3"},       {"tubes", "c4937d7e0e0be341b13c2ae2693b29d9"},
      {"bamboo", "9ad2c0282605fc90e341ad5c05e822a9"},    {"foliage", "bb5f4fde94aa710e6adaf4e5f8bb1726"},
      {"arcade", "b5225cc2b95c77cc0df2907078eebffe"},    {"triangle", "87e868ce266f6d65bc07295076d8ac40"},
      {"empty", "a4cb0b2b637906f8f01ec123d5474bd9"},     {"cube", "16c1c0ffe9bde70e9bc35946f438a7f0"},
      {"quads", "c6939e0bc1e261a3751cd21060273ed5"},     {"plant", "2010971acd32d0faef36648dae540985"},
      {"cathedral", "b1ee9445e4965a35b2dcf864360f1ed0"}, {"spheres", "dc61fca93375163fa92343c88321f3a2"},
  };
  for (const auto& [scene, hash] : golden) EXPECT_EQ(hash_of(scene, small_options()), hash) << scene;
}

// The same for the hard cases, all together: the hash of their hashes.
TEST(GenerateScenes, GoldenBytesOfTheHardCases) {
  std::string hashes;
  for (const SceneInfo& scene : list_scenes())
    if (scene.group == SceneGroup::hard) hashes += hash_of(scene.name, small_options());
  EXPECT_EQ(hashes.size(), 30u * 32);
  EXPECT_EQ(content_hash_hex(std::as_bytes(std::span(hashes))), "1c8482133d4ab55d7e99efb7f21544a5");
}

TEST(GenerateScenes, SeedAndDensityCount) {
  for (const char* scene : {"grass", "plant"}) {
    GenerateOptions options = small_options();
    const std::string one = hash_of(scene, options);
    options.seed = 8;
    EXPECT_NE(hash_of(scene, options), one) << scene;
    options = small_options();
    options.density = 0.2;
    EXPECT_NE(hash_of(scene, options), one) << scene;
  }
}

std::uint64_t triangles(const Capture& capture) {
  std::uint64_t sum = 0;
  for (const Draw& draw : capture.frames[0].draws) sum += triangle_count(draw);
  return sum;
}

TEST(GenerateScenes, FullSizesAreAsDocumented) {
  const Capture grass = generate("grass", {.frames = 1});
  EXPECT_NEAR(static_cast<double>(triangles(grass)), 260e3, 15e3);
  EXPECT_EQ(grass.frames[0].point_lights.size(), 32u);
  EXPECT_TRUE(grass.frames[0].sun && grass.frames[0].sun->shadows);
  const Capture city = generate("city", {.frames = 1});
  EXPECT_GT(triangles(city), 150000u);
  EXPECT_EQ(city.frames[0].point_lights.size(), 32u);
  EXPECT_GT(city.frames[0].draws.size(), 100u) << "a stream of draws";
  const std::tuple<const char*, std::uint64_t, std::uint64_t> expected[] = {
      {"fur", 370'000, 400'000},     {"tubes", 160'000, 190'000}, {"bamboo", 350'000, 380'000},
      {"foliage", 340'000, 370'000}, {"arcade", 80'000, 100'000}, {"plant", 300'000, 900'000},
      {"cathedral", 60'000, 110'000}};
  for (const auto& [name, least, most] : expected) {
    const Capture capture = generate(name, {.frames = 1});
    EXPECT_GT(triangles(capture), least) << name;
    EXPECT_LT(triangles(capture), most) << name;
    EXPECT_EQ(capture.frames[0].point_lights.size(), 32u) << name;
    EXPECT_TRUE(capture.frames[0].sun && capture.frames[0].sun->shadows) << name;
  }
}

// Of the vertices of the first frame's draws, in the world.
std::pair<glm::dvec3, glm::dvec3> bounds(const Capture& capture) {
  glm::dvec3 low(1e30);
  glm::dvec3 high(-1e30);
  const auto matrix_at = [](const std::byte* bytes) {
    Matrix4 values;
    std::memcpy(values.data(), bytes, sizeof(values));
    return glm::dmat4(glm::make_mat4(values.data()));
  };
  for (const Draw& draw : capture.frames[0].draws)
    for (std::uint32_t i = 0; i < draw.instance_count; ++i) {
      glm::dmat4 place(glm::make_mat4(draw.transform.data()));
      if (draw.instance_buffer != kNone)
        place *= matrix_at(&capture.buffers[draw.instance_buffer].bytes[draw.instance_offset + 64 * std::size_t{i}]);
      const auto& vertices = capture.buffers[draw.position.buffer].bytes;
      for (std::uint32_t v = 0; v < draw.vertex_count; ++v) {
        float at[3];
        std::memcpy(at, &vertices[draw.position.offset + std::size_t{v} * draw.position.stride], sizeof(at));
        const glm::dvec3 world(place * glm::dvec4(at[0], at[1], at[2], 1));
        low = glm::min(low, world);
        high = glm::max(high, world);
      }
    }
  return {low, high};
}

// The building is as large as its plan says, whatever the seed, and the camera is inside it.
TEST(GenerateScenes, BuildingsKeepToTheirPlan) {
  struct Plan {
    const char* scene;
    glm::dvec3 low, high;
  };
  const Plan plans[] = {{"plant", {-60, -0.31, -60}, {60, 24.01, 60}},  // the ground around it is 120 m wide
                        {"cathedral", {-7.76, -0.21, -31.51}, {7.76, 15.71, 4.01}}};
  for (const auto& [scene, least, most] : plans)
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const Capture capture = generate(scene, {.frames = 1, .seed = seed, .density = 0.3});
      const auto [low, high] = bounds(capture);
      const glm::dvec3 eye(glm::inverse(glm::dmat4(glm::make_mat4(capture.frames[0].view.data())))[3]);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(low[axis], least[axis]) << scene << ", axis " << axis;
        EXPECT_LE(high[axis], most[axis]) << scene << ", axis " << axis;
        EXPECT_LT(low[axis], least[axis] + 1) << scene << ", axis " << axis;
        EXPECT_GT(high[axis], most[axis] - 1) << scene << ", axis " << axis;
        EXPECT_GT(eye[axis], low[axis]) << scene << ", axis " << axis;
        EXPECT_LT(eye[axis], high[axis]) << scene << ", axis " << axis;
      }
    }
}

TEST(GenerateScenes, WrongRequestsAreNamed) {
  const auto message = [](std::string_view scene, const GenerateOptions& options) -> std::string {
    try {
      generate(scene, options);
      return "";
    } catch (const UsageError& error) {
      return error.what();
    }
  };
  EXPECT_NE(message("gras", {}).find("unknown scene 'gras': the scenes are grass, city,"), std::string::npos);
  EXPECT_NE(message("cube", {.frames = 0}).find("0 is outside 1 to 65536: frames"), std::string::npos);
  EXPECT_NE(message("cube", {.width = 0}).find("width"), std::string::npos);
  EXPECT_NE(message("cube", {.height = 16385}).find("16385 is outside 1 to 16384: height"), std::string::npos);
  EXPECT_NE(message("cube", {.density = std::nan("")}).find("density"), std::string::npos);
}

TEST(GenerateScenes, RandomIsSplitMix64) {
  Random random(1234567);  // the first values of the published reference implementation
  EXPECT_EQ(random.next(), 6457827717110365317u);
  EXPECT_EQ(random.next(), 3203168211198807973u);
  EXPECT_EQ(random.next(), 9817491932198370423u);
  for (int i = 0; i < 1000; ++i) EXPECT_LT(random.below(7), 7u);
}

TEST(GenerateScenes, NoiseRepeatsWithItsPeriod) {
  for (int i = 0; i < 50; ++i) {
    const double x = i * 0.37;
    EXPECT_NEAR(tileable_noise(x, 0.2, 8, 4, 3), tileable_noise(x + 8, 0.2, 8, 4, 3), 1e-9);
    EXPECT_NEAR(tileable_noise(0.2, x, 8, 4, 3), tileable_noise(0.2, x + 8, 8, 4, 3), 1e-9);
  }
}

TEST(GenerateScenes, LeafTexturesHaveHolesAndLeaves) {
  const Texture leaf = leaf_texture("leaf", 64, {80, 140, 50}, 3);
  std::set<std::uint8_t> alphas;
  std::size_t covered = 0;
  for (std::size_t i = 3; i < leaf.bytes.size(); i += 4) {
    alphas.insert(std::to_integer<std::uint8_t>(leaf.bytes[i]));
    covered += leaf.bytes[i] == std::byte{255} ? 1 : 0;
  }
  EXPECT_EQ(alphas, (std::set<std::uint8_t>{0, 255}));
  EXPECT_GT(covered, 64u * 64 / 5);
  EXPECT_LT(covered, 64u * 64 * 4 / 5);
}

}  // namespace
}  // namespace subpixel::capture
