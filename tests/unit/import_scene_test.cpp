// Scene descriptions: what they build, and that every mistake in one is named.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "scenes/import/import.hpp"
#include "scenes/import/json_fields.hpp"
#include "scenes/import/scene_description.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

constexpr const char* kScene = R"({
  "title": "Test", "licence": "CC0-1.0", "frames": 4, "size": [80, 60],
  "sun": {"direction": [0, -1, 0], "irradiance": [1, 2, 3]},
  "point_lights": [{"position": [0, 1, 0], "intensity": [1, 1, 1], "range": 3}],
  "camera": {"keys": [{"time_s": 0, "eye": [0, 1, 5], "target": [0, 1, 0]},
                      {"time_s": 1, "eye": [0, 1, 4], "target": [0, 1, 0], "fov_degrees": 60}]},
  "materials": {"lawn": {"pattern": "noise", "low": [40, 60, 20], "high": [80, 100, 40]},
                "slabs": {"pattern": "bricks", "low": [90, 90, 90], "high": [120, 120, 120]}},
  "ground": [{"material": "lawn", "rectangle": [-5, -5, 5, 5]},
             {"material": "slabs", "path": [[0, 5], [1, 0], [0, -5]], "width_m": 1, "y": 0.02}],
  "grass": [{"rectangle": [-1, -1, 1, 1], "blades_per_patch": 5}],
  "models": {"post": {"file": "post.obj", "height_m": 3, "two_sided": true,
                      "light": {"offset": [0, 3, 0], "intensity": [5, 5, 5], "range": 4}}},
  "placements": [{"model": "post", "position": [2, 0, 0], "rotation_degrees": 90, "scale": 2},
                 {"model": "post", "repeat": {"count": 3, "step": [1, 0, 0]}},
                 {"model": "post", "scatter": {"count": 5, "rectangle": [-4, -4, 4, 4], "spacing_m": 1, "seed": 3}}]
})";

class ImportScene : public testing::Test {
 protected:
  ImportScene() : folder_(std::filesystem::path(testing::TempDir()) / ("import_scene_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    // 2 x 6 x 0 units, not standing at the origin.
    write("post.obj", "v 10 4 1\nv 12 4 1\nv 11 10 1\nf 1 2 3\n");
  }
  ~ImportScene() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  // The message with which the scene is refused after `from` in it is replaced by `to`.
  std::string refusal_with(const std::string& from, const std::string& to) const {
    std::string text = kScene;
    EXPECT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    try {
      import_file(write("scene.json", text));
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

TEST_F(ImportScene, BuildsWhatItSays) {
  const Capture capture = import_file(write("scene.json", kScene));
  EXPECT_EQ(capture.metadata.title, "Test");
  EXPECT_EQ(capture.metadata.licence, "CC0-1.0");
  ASSERT_EQ(capture.frames.size(), 4u);
  const Frame& frame = capture.frames[0];
  EXPECT_EQ(frame.width, 80u);
  EXPECT_EQ(frame.sun->irradiance, (Float3{1, 2, 3}));
  ASSERT_EQ(frame.point_lights.size(), 10u) << "one of its own, one with each of 9 posts";
  EXPECT_EQ(frame.point_lights[1].position, (Float3{2, 6, 0})) << "the offset grows with the model";
  const auto post = std::find_if(frame.draws.begin(), frame.draws.end(),
                                 [](const Draw& draw) { return draw.name.starts_with("post"); });
  ASSERT_NE(post, frame.draws.end());
  EXPECT_EQ(post->instance_count, 9u);
  EXPECT_TRUE(capture.materials[post->material].two_sided);
  // Half a unit a metre, foot's middle at the position: the first is scaled by 2 once more and turned.
  const Matrix4 place = world_transforms(capture, *post)[0];
  const auto placed = [&](float x, float y, float z) {
    return std::array{place[0] * x + place[4] * y + place[8] * z + place[12],
                      place[1] * x + place[5] * y + place[9] * z + place[13]};
  };
  EXPECT_NEAR(placed(11, 4, 1)[0], 2, 1e-5);
  EXPECT_NEAR(placed(11, 4, 1)[1], 0, 1e-5);
  EXPECT_NEAR(placed(11, 10, 1)[1], 6, 1e-5);
  for (const Problem& problem : validate_capture(capture)) ADD_FAILURE() << problem.where << ": " << problem.why;
  EXPECT_EQ(refusal(encode_capture(capture)), "");
}

TEST_F(ImportScene, IsTheSameEveryTime) {
  const auto path = write("scene.json", kScene);
  EXPECT_EQ(encode_capture(import_file(path)), encode_capture(import_file(path)));
}

TEST_F(ImportScene, OptionsWin) {
  const Capture capture = import_file(write("scene.json", kScene), {.frames = 2, .width = 20, .height = 10});
  EXPECT_EQ(capture.frames.size(), 2u);
  EXPECT_EQ(capture.frames[1].width, 20u);
  EXPECT_THROW(import_file(folder_ / "scene.json", {.camera = "orbit"}), UsageError);
}

TEST_F(ImportScene, ModelsAreLookedForInTheAssetFolders) {
  std::filesystem::create_directories(folder_ / "assets");
  std::filesystem::rename(folder_ / "post.obj", folder_ / "assets" / "post.obj");
  const std::string missing = refusal_with("Test", "Test");
  EXPECT_NE(missing.find("the file post.obj is missing: looked for in " + folder_.string()), std::string::npos)
      << missing;
  EXPECT_EQ(import_file(folder_ / "scene.json", {.asset_folders = {folder_ / "assets"}}).frames.size(), 4u);
}

TEST_F(ImportScene, BrokenJsonIsPlaced) {
  const std::string message = refusal_with("\"frames\": 4,", "\"frames\": 4;");
  EXPECT_NE(message.find("broken JSON: parse error at line 2, column"), std::string::npos) << message;
  EXPECT_NE(refusal_with(kScene, "").find("broken JSON"), std::string::npos);
  EXPECT_NE(refusal_with(kScene, "[]").find("not an object"), std::string::npos);
}

TEST_F(ImportScene, MistakesNameTheirField) {
  const std::tuple<const char*, const char*, const char*> mistakes[] = {
      {"\"frames\": 4", "\"frames\": 0", "0 is outside 1 to 65536"},
      {"\"frames\": 4", "\"frames\": 1.5", "not a whole number"},
      {"\"frames\": 4", "\"frames\": \"4\"", "field frames"},
      {"\"frames\": 4", "\"frame\": 4", "scene.json, field frame"},
      {"[80, 60]", "[80]", "field size"},
      {"[80, 60]", "[80, 0.5]", "not a picture's size"},
      {"[0, -1, 0]", "[0, -1]", "field sun.direction"},
      {"[0, -1, 0]", "[0, 0, 0]", "of length 0"},
      {"[1, 2, 3]", "[1, -2, 3]", "negative"},
      {"\"eye\": [0, 1, 4]", "\"eye\": [0, 1, 4e99]", "4e+99 is beyond"},
      {"\"range\": 3", "\"range\": 0", "field point_lights[0].range"},
      {"\"eye\": [0, 1, 4]", "\"eye\": [0, 1, \"4\"]", "field camera.keys[1].eye"},
      {"\"eye\": [0, 1, 5], ", "", "field camera.keys[0].eye"},
      {"\"time_s\": 1", "\"time_s\": 0", "not after the key before"},
      {"\"target\": [0, 1, 0]}", "\"target\": [0, 1, 5]}", "the same point as eye"},
      {"\"pattern\": \"noise\"", "\"pattern\": \"nose\"", "not one of plain, noise, bricks"},
      {"\"material\": \"lawn\"", "\"material\": \"loan\"", "no material is named loan"},
      {"[-5, -5, 5, 5]", "[-5, -5, -5, 5]", "its second corner"},
      {"[[0, 5], [1, 0], [0, -5]]", "[[0, 5]]", "fewer than 2 points"},
      {"[[0, 5], [1, 0], [0, -5]]", "[[0, 5], [1]]", "field ground[1].path"},
      {"[-1, -1, 1, 1]", "[-1, -1, 1e6, 1e6]", "field grass[0].patch_m"},
      {"\"height_m\": 3", "\"height_m\": 1e9", "field models.post.height_m"},
      {"\"height_m\": 3", "\"hieght_m\": 3", "field models.post.hieght_m"},
      {"\"two_sided\": true", "\"two_sided\": [\"bark\"]", "no material bark"},
      {"\"two_sided\": true", "\"emissive\": {\"bulb\": [1, 1, 1]}", "no material bulb, only DefaultMaterial"},
      {"\"two_sided\": true", "\"emissive\": [1, 1, 1]", "field models.post.emissive"},
      {"\"model\": \"post\", \"position\"", "\"model\": \"pots\", \"position\"", "no model is named pots"},
      {"\"count\": 3", "\"count\": 2000000", "field placements[1].repeat.count"},
      {"\"step\": [1, 0, 0]", "\"step\": 1", "field placements[1].repeat.step"},
      {"\"seed\": 3", "\"sead\": 3", "field placements[2].scatter.sead"},
  };
  for (const auto& [from, to, expected] : mistakes) {
    const std::string message = refusal_with(from, to);
    EXPECT_NE(message.find(expected), std::string::npos) << from << " to " << to << ": " << message;
  }
}

TEST_F(ImportScene, ScatterKeepsItsDistance) {
  const SceneDescription scene = read_scene_description(write("scene.json", kScene));
  ASSERT_EQ(scene.placements.size(), 9u);
  for (std::size_t i = 4; i < 9; ++i) {
    for (std::size_t k = 4; k < i; ++k) {
      const glm::dvec3 apart = scene.placements[i].position - scene.placements[k].position;
      EXPECT_GE(apart.x * apart.x + apart.z * apart.z, 1.0);
    }
  }
}

TEST(ImportPark, SmallParkIsWholeWhereItsModelsAreInstalled) {
  const std::filesystem::path scenes = std::filesystem::path(SUBPIXEL_SOURCE_DIR) / "scenes/described";
  EXPECT_EQ(read_scene_description(scenes / "park.json").frames, 10u);
  if (!std::filesystem::exists("/usr/share/sweethome3d/furniture/Scopia.sh3f"))
    GTEST_SKIP() << "no sweethome3d-furniture";
  const Capture capture = import_file(scenes / "park_small.json", {.frames = 2});
  std::uint64_t triangles = 0;
  for (const Draw& draw : capture.frames[0].draws) triangles += triangle_count(draw);
  EXPECT_NEAR(static_cast<double>(triangles), 123e3, 5e3);
  for (const Problem& problem : validate_capture(capture)) {
    EXPECT_NE(problem.severity, Problem::Severity::error) << problem.where << ": " << problem.why;
  }
  EXPECT_EQ(refusal(encode_capture(capture)), "");
}

}  // namespace
}  // namespace subpixel::capture
