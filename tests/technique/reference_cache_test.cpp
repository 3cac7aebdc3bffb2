#include "replay/reference/reference_cache.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <vector>

#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

class ReferenceCacheFolder : public testing::Test {
 protected:
  ReferenceCacheFolder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("subpixel_") + test->name() + "_" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    capture_.frames[0].ambient = {0, 0, 0};
    add_triangles(capture_, {-0.83f, -0.71f, 0, 0.92f, -0.37f, 0, -0.11f, 0.88f, 0},
                  add_emitter(capture_, {1, 0.5f, 3}));
  }
  ~ReferenceCacheFolder() override { std::filesystem::remove_all(folder_); }

  std::vector<char> read(const std::filesystem::path& path) const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::filesystem::path& path, const std::vector<char>& bytes) const {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

  std::filesystem::path folder_;
  capture::Capture capture_ = flat_capture(24, 24);
};

TEST_F(ReferenceCacheFolder, GivesBackTheSameBits) {
  GpuScene scene(test_device(), capture_, {});
  scene.set_frame(0, 24, 24);
  const ReferenceCache cache(folder_ / "made" / "on" / "demand");
  const auto first = cached_reference(test_device(), scene, "abc", 0, {.samples = 16}, cache);
  EXPECT_FALSE(first.from_cache);
  EXPECT_EQ(first.store_error, "");
  int turns = 0;
  const auto second = cached_reference(test_device(), scene, "abc", 0, {.samples = 16}, cache,
                                       [&](std::uint32_t, std::uint32_t) { ++turns; });
  EXPECT_TRUE(second.from_cache);
  EXPECT_EQ(turns, 0);
  EXPECT_EQ(second.image.linear.pixels, first.image.linear.pixels);
  EXPECT_EQ(second.image.display.pixels, first.image.display.pixels);
  EXPECT_EQ(second.image.linear.encoding, Encoding::linear);
  EXPECT_EQ(second.image.display.encoding, Encoding::display);
}

TEST_F(ReferenceCacheFolder, TakesNothingFromADamagedFile) {
  GpuScene scene(test_device(), capture_, {});
  scene.set_frame(0, 24, 24);
  const ReferenceCache cache(folder_);
  const auto image = cached_reference(test_device(), scene, "abc", 0, {.samples = 4}, cache).image;
  const std::string key = reference_key(test_device(), scene, "abc", 0, {.samples = 4});
  const auto path = cache.path_of(key);
  const auto whole = read(path);
  ASSERT_GT(whole.size(), 48u);
  ASSERT_TRUE(cache.load(key));
  for (std::size_t at = 0; at < whole.size(); at += at < 64 ? 1 : 37) {
    auto damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write(path, damaged);
    EXPECT_FALSE(cache.load(key)) << "byte " << at;
  }
  for (std::size_t size = 0; size < whole.size(); size += size < 64 ? 1 : 41) {
    write(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_FALSE(cache.load(key)) << size << " bytes";
  }
  auto longer = whole;
  longer.push_back(0);
  write(path, longer);
  EXPECT_FALSE(cache.load(key));
  const auto again = cached_reference(test_device(), scene, "abc", 0, {.samples = 4}, cache);
  EXPECT_FALSE(again.from_cache);
  EXPECT_EQ(again.image.linear.pixels, image.linear.pixels);
  EXPECT_EQ(read(path), whole);
}

TEST_F(ReferenceCacheFolder, EverythingTheImageDependsOnIsInTheKey) {
  GpuScene scene(test_device(), capture_, {});
  scene.set_frame(0, 24, 24);
  const ReferenceOptions options{.samples = 16};
  std::set<std::string> keys;
  const auto key = [&](const char* hash, std::uint32_t frame, const ReferenceOptions& with) {
    return reference_key(test_device(), scene, hash, frame, with);
  };
  keys.insert(key("abc", 0, options));
  EXPECT_EQ(keys.count(key("abc", 0, options)), 1u);
  keys.insert(key("abd", 0, options));
  keys.insert(key("abc", 1, options));
  keys.insert(key("abc", 0, {.samples = 20}));
  keys.insert(key("abc", 0, {.samples = 16, .shading_model = 1}));
  keys.insert(key("abc", 0, {.samples = 16, .tone_map_samples = true}));
  scene.set_frame(0, 24, 25);
  keys.insert(key("abc", 0, options));
  GpuScene lit(test_device(), capture_, {.point_lights = 3});
  lit.set_frame(0, 24, 24);
  keys.insert(reference_key(test_device(), lit, "abc", 0, options));
  EXPECT_EQ(keys.size(), 8u);
}

TEST_F(ReferenceCacheFolder, AFolderThatCantBeWrittenCostsOnlyTheCache) {
  write(folder_.string() + "_file", {'x'});
  GpuScene scene(test_device(), capture_, {});
  scene.set_frame(0, 24, 24);
  const ReferenceCache cache(folder_.string() + "_file");
  const auto result = cached_reference(test_device(), scene, "abc", 0, {.samples = 4}, cache);
  EXPECT_FALSE(result.from_cache);
  EXPECT_NE(result.store_error, "");
  EXPECT_EQ(result.image.linear.width, 24u);
  std::filesystem::remove(folder_.string() + "_file");
}

}  // namespace
}  // namespace subpixel::replay
