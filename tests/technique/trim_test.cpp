// A trimmed capture draws the same bits as the one it was cut from.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

class Trim : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-trim-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void run(const std::string& arguments) const {
    const Finished finished = run_binary(arguments, folder_);
    ASSERT_EQ(finished.code, 0) << arguments << "\n" << finished.error;
  }

  std::string bytes(const std::filesystem::path& path) const {
    std::ifstream file(folder_ / path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::filesystem::path folder_;
};

TEST_F(Trim, DrawsTheSameBits) {
  const std::string replay = " --techniques noaa,msaa:samples=4 --repeat 1 --reference-samples 0 --out ";
  run("generate foliage whole.spcap --frames 2 --size 48x36 --density 0.1");
  run("trim whole.spcap part.spcap --frames 1");
  EXPECT_LT(std::filesystem::file_size(folder_ / "part.spcap"), std::filesystem::file_size(folder_ / "whole.spcap"));
  run("replay whole.spcap --frames 1" + replay + "whole");
  run("replay part.spcap --frames 0" + replay + "part");
  std::size_t compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "whole")) {
    std::string name = entry.path().filename();
    if (entry.path().extension() != ".exr") continue;
    const std::string before = bytes("whole/" + name);
    ASSERT_TRUE(name.starts_with("frame0001_")) << name;
    name[8] = '0';
    EXPECT_EQ(bytes("part/" + name), before) << name;
    ++compared;
  }
  EXPECT_EQ(compared, 4u);  // two images, and the numbers of a map for each
}

}  // namespace
}  // namespace subpixel::tests
