// SUBPIXEL_SHADERS: SPIR-V of a folder instead of the embedded one, and what is said of a folder that doesn't do.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "replay/gpu/pipeline.hpp"
#include "replay/gpu/spirv.hpp"
#include "shaders/embedded.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::replay {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::uint32_t>;

class ShaderFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("subpixel-shaders-" + std::to_string(getpid()));
    fs::copy(SUBPIXEL_SPIRV_DIR, folder_, fs::copy_options::recursive);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(std::string_view shader, std::span<const std::uint32_t> words) const {
    std::ofstream(folder_ / gpu::spirv_file(shader), std::ios::binary)
        .write(reinterpret_cast<const char*>(words.data()), static_cast<std::streamsize>(words.size_bytes()));
  }
  Words read(std::string_view shader) const {
    const gpu::ShaderLibrary library(folder_);
    const auto words = library.words(shader);
    return {words.begin(), words.end()};
  }
  // What a folder is refused for.
  std::string refusal() const {
    try {
      const gpu::ShaderLibrary library(folder_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST(ShaderFiles, NamesHaveTheirVariant) {
  EXPECT_EQ(gpu::spirv_file("frontend/setup.comp"), "frontend/setup.comp.spv");
  EXPECT_EQ(gpu::spirv_file("techniques/dcaa/merge.frag:BUFFER"), "techniques/dcaa/merge.frag.BUFFER.spv");
  std::vector<fs::path> files;
  for (const auto& shader : shaders::all()) files.push_back(gpu::spirv_file(shader.name));
  std::ranges::sort(files);
  EXPECT_EQ(std::ranges::adjacent_find(files), files.end());
}

TEST_F(ShaderFolder, WhatTheBuildLeavesIsWhatItEmbeds) {
  const gpu::ShaderLibrary embedded({}), library(folder_);
  EXPECT_TRUE(embedded.embedded());
  EXPECT_FALSE(library.embedded());
  for (const auto& shader : shaders::all()) {
    EXPECT_TRUE(std::ranges::equal(library.words(shader.name), shader.words)) << shader.name;
    EXPECT_TRUE(std::ranges::equal(embedded.words(shader.name), shader.words)) << shader.name;
  }
  EXPECT_THROW(library.words("scene/none.vert"), std::logic_error);
  EXPECT_THROW(embedded.words("scene/none.vert"), std::logic_error);
}

TEST_F(ShaderFolder, AMissingOrBrokenFileIsNamed) {
  const std::string_view name = "techniques/dcaa/merge.frag:BUFFER";
  const std::string file = "techniques/dcaa/merge.frag.BUFFER.spv";
  const Words good = read(name);
  const auto expect = [&](const std::string& why) {
    SCOPED_TRACE(why);
    const std::string said = refusal();
    EXPECT_NE(said.find(why), std::string::npos) << said;
    EXPECT_NE(said.find(file), std::string::npos) << said;
  };
  const auto expect_of = [&](const Words& words, const std::string& why) {
    write(name, words);
    expect(why);
  };
  expect_of({}, "0 bytes are no SPIR-V module");
  expect_of({good.begin(), good.begin() + 4}, "16 bytes are no SPIR-V module");
  expect_of({good.begin(), good.end() - 1}, "does not end with a function's end");
  expect_of({good.begin(), good.begin() + 6}, "does not end within the module");
  Words words = good;
  words[0] = 0x03022307;
  expect_of(words, "begins with 03022307");
  words = good;
  words[1] = 0x00010700;
  expect_of(words, "SPIR-V 1.7");
  words = good;
  words[5] &= 0xffff;
  expect_of(words, "the instruction at word 5");
  const auto embedded = gpu::ShaderLibrary({}).words("frontend/setup.comp");
  expect_of({embedded.begin(), embedded.end()}, "no entry point \"main\" for its stage");
  write(name, good);
  std::ofstream(folder_ / file, std::ios::binary | std::ios::app) << 'x';
  expect("not whole SPIR-V words");
  fs::remove(folder_ / file);
  expect("can't be read: No such file");
  fs::create_directory(folder_ / file);
  expect("can't be read");
  fs::remove(folder_ / file);
  write(name, good);
  EXPECT_EQ(refusal(), "");
}

// Each prefix of a module, and each with one word changed to 0: none is read beyond its end.
TEST(Spirv, CutModulesAreRefused) {
  const auto shaders = shaders::all();
  const auto shader = std::ranges::find(shaders, "scene/shadow.frag:TESTED", &shaders::Embedded::name);
  ASSERT_NE(shader, shaders.end());
  EXPECT_EQ(gpu::fault_in_spirv(shader->words, shader->name), "");
  std::size_t whole = 0;
  for (std::size_t words = 0; words < shader->words.size(); ++words) {
    const Words cut(shader->words.begin(), shader->words.begin() + static_cast<std::ptrdiff_t>(words));
    whole += gpu::fault_in_spirv(cut, shader->name).empty() ? 1 : 0;
  }
  EXPECT_LT(whole, 40u) << "what is cut between two functions";
  for (std::size_t at = 0; at < shader->words.size(); ++at) {
    Words changed(shader->words.begin(), shader->words.end());
    changed[at] = 0;
    gpu::fault_in_spirv(changed, shader->name);
  }
  EXPECT_NE(gpu::fault_in_spirv(shader->words, "scene/shadow.vert"), "");
}

// The binary takes it: an image made with the build's files is the same, one of an edited resolve is not.
TEST_F(ShaderFolder, ReplaysUseIt) {
  const fs::path work = folder_ / "work";
  fs::create_directories(work);
  ASSERT_EQ(tests::run_binary("generate cube cube.spcap --frames 1 --size 32x24", work).code, 0);
  const auto image = [&](const std::string& out, const std::string& environment) {
    const auto finished = tests::run_binary(
        "replay cube.spcap --techniques noaa --reference-samples 0 --repeat 1 --out " + out, work, environment);
    EXPECT_EQ(finished.code, 0) << finished.error;
    std::ifstream file(work / out / "frame0000_00_noaa.png", std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto build_of = [&](const std::string& out) {
    std::ifstream file(work / out / "results.json");
    const std::string text(std::istreambuf_iterator<char>(file), {});
    return text.find("with shaders of a folder") != std::string::npos;
  };
  const std::string environment = "SUBPIXEL_SHADERS='" + folder_.string() + "'";
  const std::string embedded = image("embedded", ""), same = image("same", environment);
  EXPECT_FALSE(embedded.empty());
  EXPECT_EQ(embedded, same);
  EXPECT_FALSE(build_of("embedded"));
  EXPECT_TRUE(build_of("same"));
  write("shade/resolve.frag", read("tests/red_resolve.frag"));
  EXPECT_NE(image("edited", environment), embedded);

  fs::remove(folder_ / "frontend/setup.comp.spv");
  const auto refused = tests::run_binary("replay cube.spcap --techniques noaa --out out", work, environment);
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.error.find("frontend/setup.comp.spv"), std::string::npos) << refused.error;
  const auto none =
      tests::run_binary("replay cube.spcap --techniques noaa --out out", work, "SUBPIXEL_SHADERS=nowhere");
  EXPECT_EQ(none.code, 3);
  EXPECT_NE(none.error.find("nowhere"), std::string::npos) << none.error;
}

// What only tests and bench use is not in the product.
TEST(EmbeddedShaders, TheProductHasNoneOfTheTests) {
  const auto all = shaders::all();
  const auto is_of_tests = [](const shaders::Embedded& shader) {
    return shader.name.starts_with("tests/") || shader.name.starts_with("bench/");
  };
  EXPECT_GT(std::ranges::count_if(all, is_of_tests), 0);
  EXPECT_EQ(std::ranges::count_if(shaders::replay_shaders(), is_of_tests), 0);
  std::ifstream file(SUBPIXEL_BINARY, std::ios::binary);
  const std::string binary(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(binary.find("frontend/setup.comp"), std::string::npos);
  EXPECT_EQ(binary.find("tests/shade_probe.comp"), std::string::npos);
}

}  // namespace
}  // namespace subpixel::replay
