// What is heard of mistakes under the validation layer: each names its pass and its objects; and `replay --validate`.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "replay/gpu/pass_recorder.hpp"
#include "tests/technique/run_binary.hpp"
#include "tests/technique/validation_fixture.hpp"

namespace subpixel::replay {
namespace {

namespace fs = std::filesystem;

// Two fills of one buffer without a barrier between them.
void write_twice(gpu::Device& device, const gpu::Buffer& buffer) {
  device.run("fill twice", [&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 1);
    vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 2);
  });
}

void expect_one(const std::vector<std::string>& said, const std::string& start, const std::vector<std::string>& words) {
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(said[0].starts_with(start)) << said[0];
  for (const std::string& word : words) EXPECT_NE(said[0].find(word), std::string::npos) << said[0];
  EXPECT_EQ(said[0].find('\n'), std::string::npos);
}

TEST_F(Validation, AHazardNamesItsPass) {
  const auto said = messages([](gpu::Device& device, std::vector<std::string>&) {
    const gpu::Buffer buffer(device, "written twice", 256);
    write_twice(device, buffer);
  });
  expect_one(said, "error: pass 'fill twice': ", {"SYNC-HAZARD-WRITE-AFTER-WRITE"});
}

// One recorded pass of three is wrong, and only that one is named.
TEST_F(Validation, ARecordedPassIsNamed) {
  const auto said = messages([](gpu::Device& device, std::vector<std::string>&) {
    gpu::PassRecorder recorder(device);
    gpu::Image& target =
        recorder.image({"target", VK_FORMAT_R32G32B32A32_UINT, 16, 16, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false});
    gpu::RasterPass pass;
    pass.pipeline.vertex = "frontend/litmus.vert";
    pass.pipeline.fragment = "frontend/litmus.frag:ATTACHMENT";
    pass.pipeline.targets.ordered_read = pass.pipeline.targets.clear = true;
    pass.colours = {{target}};
    pass.clear_colours = {{}};
    for (const float width : {8.0f, 0.0f, 4.0f}) {
      pass.name = "viewport of " + std::to_string(static_cast<int>(width));
      pass.draws = [width](gpu::DrawEncoder& encoder) { encoder.viewport(0, 0, width, 8); };
      recorder.raster(pass);
    }
    recorder.run();
  });
  expect_one(said, "error: pass 'viewport of 0': ", {"VUID-VkViewport-width-01770"});
}

TEST_F(Validation, AnObjectIsNamed) {
  const auto said = messages([](gpu::Device& device, std::vector<std::string>&) {
    const gpu::Image image(device, {"a named image"});
    device.run("wrong layout", [&](VkCommandBuffer commands) {
      const VkClearColorValue black{};
      const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
      vkCmdClearColorImage(commands, image.handle(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, &black, 1, &all);
    });
  });
  EXPECT_TRUE(std::ranges::any_of(said, [](const std::string& message) {
    return message.starts_with("error: pass 'wrong layout': ") && message.find("a named image") != std::string::npos;
  }));
}

class ReplayValidate : public Validation {
 protected:
  void SetUp() override {
    Validation::SetUp();
    folder_ = fs::temp_directory_path() / ("subpixel-validate-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    ASSERT_EQ(tests::run_binary("generate cube cube.spcap --frames 1 --size 32x24", folder_).code, 0);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  tests::Finished replay(const std::string& environment) const {
    return tests::run_binary(
        "replay cube.spcap --techniques noaa --reference-samples 0 --repeat 1 --out out --validate", folder_,
        environment);
  }
  std::vector<std::string> lines_of(const std::string& text) const {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
      if (line.starts_with("validation: ") || line.starts_with("subpixel: ")) lines.push_back(line);
    return lines;
  }

  fs::path folder_;
};

TEST_F(ReplayValidate, SaysNothingOfWhatIsRight) {
  const auto finished = replay("");
  EXPECT_EQ(finished.code, 0) << finished.error;
  EXPECT_TRUE(lines_of(finished.error).empty()) << finished.error;
}

// A shader that declares a capability the device was not asked for, which lavapipe does not mind.
TEST_F(ReplayValidate, AnErrorEndsTheRunAsOursOnceAllIsWritten) {
  const fs::path shaders = folder_ / "shaders", file = shaders / gpu::spirv_file("shade/resolve.frag");
  fs::copy(SUBPIXEL_SPIRV_DIR, shaders, fs::copy_options::recursive);
  const gpu::ShaderLibrary library(shaders);
  const auto words = library.words("shade/resolve.frag");
  std::vector<std::uint32_t> changed(words.begin(), words.end());
  constexpr std::array<std::uint32_t, 2> kGeometry{2u << 16 | 17u, 2u};  // OpCapability Geometry
  changed.insert(changed.begin() + 5, kGeometry.begin(), kGeometry.end());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(changed.data()), static_cast<std::streamsize>(changed.size() * 4));
  const auto finished = replay("SUBPIXEL_SHADERS='" + shaders.string() + "'");
  EXPECT_EQ(finished.code, 70) << finished.error;
  const auto lines = lines_of(finished.error);
  ASSERT_GE(lines.size(), 2u) << finished.error;
  EXPECT_NE(lines.front().find("validation: error: "), std::string::npos) << lines.front();
  EXPECT_NE(lines.front().find("shade/resolve.frag'"), std::string::npos) << lines.front();
  EXPECT_TRUE(lines.back().starts_with("subpixel: internal error: ")) << lines.back();
  EXPECT_TRUE(fs::exists(folder_ / "out" / "results.json"));
}

TEST_F(ReplayValidate, WithoutTheLayerItsPackageIsNamed) {
  const auto finished = replay("VK_LAYER_PATH='" + folder_.string() + "'");
  EXPECT_EQ(finished.code, 4) << finished.error;
  const auto lines = lines_of(finished.error);
  ASSERT_EQ(lines.size(), 1u) << finished.error;
  EXPECT_NE(lines[0].find("vulkan-validationlayers"), std::string::npos) << lines[0];
}

}  // namespace
}  // namespace subpixel::replay
