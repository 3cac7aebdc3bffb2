// The same bits from every run on one machine, whatever the number of threads: images, counters, errors.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

using nlohmann::json;

std::string text_of(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

struct Outcome {
  json results;                               // all but their times
  std::map<std::string, std::string> images;  // by file name
};

struct Case {
  const char* scene;
  std::vector<const char*> others;  // environments of the runs that are compared with a first one
};

void PrintTo(const Case& chosen, std::ostream* out) {
  *out << chosen.scene;
}

class Determinism : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-determinism-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    const Finished made = run_binary(
        fmt::format("generate {} scene.spcap --frames 1 --size 160x90 --density 0.05", GetParam().scene), folder_);
    ASSERT_EQ(made.code, 0) << made.error;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Outcome replay(const std::string& techniques, const std::string& environment) {
    std::filesystem::remove_all(folder_ / "out");
    const Finished run =
        run_binary("replay scene.spcap --repeat 1 --reference-samples 16 --out out --techniques " + techniques, folder_,
                   environment);
    EXPECT_EQ(run.code, 0) << run.error;
    if (run.code != 0) return {};
    Outcome outcome{json::parse(text_of(folder_ / "out" / "results.json")).at("results"), {}};
    for (json& result : outcome.results) {
      result.erase("ms");
      result.erase("spread");
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out"))
      if (entry.path().extension() == ".png" || entry.path().extension() == ".exr")
        outcome.images[entry.path().filename()] = text_of(entry.path());
    return outcome;
  }

  std::filesystem::path folder_;
};

TEST_P(Determinism, SameBitsWithEveryNumberOfThreads) {
  std::vector<std::string> names;
  for (const json& technique : json::parse(run_binary("techniques --json", folder_).out))
    names.push_back(technique.at("name"));
  const std::string techniques = fmt::format("{}", fmt::join(names, ","));
  const Outcome first = replay(techniques, "");
  // A PNG, an EXR, an error and a shading map of each.
  EXPECT_GE(first.images.size(), 4u * names.size());
  for (const char* environment : GetParam().others) {
    const Outcome other = replay(techniques, environment);
    EXPECT_EQ(first.results, other.results) << environment;
    ASSERT_EQ(first.images.size(), other.images.size());
    for (const auto& [name, bytes] : first.images)
      EXPECT_TRUE(bytes == other.images.at(name)) << name << " " << environment;
  }
}

// `quads` adds the alpha test and emission.
INSTANTIATE_TEST_SUITE_P(Scenes, Determinism,
                         testing::Values(Case{"grass",
                                              {"", "LP_NUM_THREADS=1", "LP_NUM_THREADS=2", "LP_NUM_THREADS=8"}},
                                         Case{"quads", {"LP_NUM_THREADS=1", "LP_NUM_THREADS=8"}}),
                         [](const auto& chosen) { return std::string(chosen.param.scene); });

}  // namespace
}  // namespace subpixel::tests
