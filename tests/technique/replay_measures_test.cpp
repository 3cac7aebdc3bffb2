// What `subpixel replay` measures besides the technique itself.
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "replay/replay.hpp"
#include "replay/results/parameters.hpp"
#include "replay/results/worker_protocol.hpp"
#include "replay/techniques/complete_technique.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

using nlohmann::json;

class ReplayMeasures : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-measures-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  json replay(const std::string& generated, const std::string& options) {
    const Finished made = run_binary("generate " + generated, folder_);
    EXPECT_EQ(made.code, 0) << made.error;
    const Finished run = run_binary("replay scene.spcap --repeat 1 --out out " + options, folder_);
    EXPECT_EQ(run.code, 0) << run.error;
    std::ifstream file(folder_ / "out" / "results.json");
    return json::parse(file);
  }

  std::filesystem::path folder_;
};

TEST_F(ReplayMeasures, TimeOutsideOfPassesIsTheSumOfItsParts) {
  const json head =
      replay("cube scene.spcap --frames 2 --size 64x36", "--techniques noaa,msaa --reference-samples 8").at("head");
  double sum = 0;
  for (const char* part : {"load", "scene", "prepare", "submit", "measure", "reference", "write", "report"}) {
    EXPECT_GT(head.at("outside_parts_s").at(part), 0) << part;
    sum += head.at("outside_parts_s").at(part).get<double>();
  }
  EXPECT_EQ(head.at("outside_parts_s").size(), 8u);
  EXPECT_NEAR(sum, head.at("outside_gpu_s"), 1e-6);
  EXPECT_LT(sum, head.at("wall_s"));
}

// One triangle over the whole frame: every pass shades each pixel once, or once for each time it draws the geometry.
TEST_F(ReplayMeasures, FragmentsOfEveryRasterPass) {
  const json results = replay("hard_fullscreen scene.spcap --frames 1 --size 64x36",
                              "--techniques noaa,msaa:samples=32,streaming,forward,linked_list --reference-samples 0")
                           .at("results");
  constexpr std::uint64_t kPixels = std::uint64_t{64} * 36;
  for (const json& result : results) {
    const json& fragments = result.at("shading").at("fragments");
    // Samples go in groups of 16 through visibility, of 8 through the G-buffer of msaa and its shading.
    const bool groups = result.at("samples") == 32;
    for (const auto& pass : fragments.items()) {
      // Lists are counted first, then stored.
      const bool by_eight = pass.key() == "gbuffer" || pass.key() == "shade";
      const bool twice = pass.key() == "collect" || (groups && pass.key() == "visibility");
      const std::uint64_t draws = twice ? 2 : groups && by_eight ? 4 : 1;
      EXPECT_EQ(pass.value(), draws * kPixels) << result.at("technique") << " " << pass.key();
      EXPECT_TRUE(result.at("ms").at("passes").contains(pass.key())) << pass.key();
    }
    EXPECT_FALSE(fragments.contains("setup"));
    EXPECT_GE(fragments.size(), 2u) << result.at("technique");
  }
}

// Pixels in groups of 8x4 wait for their busiest: every pixel has one execution in one case; in the other one group's
// pixels have more than others.
TEST_F(ReplayMeasures, ExecutionsOfGroups) {
  const json full = replay("hard_fullscreen scene.spcap --frames 1 --size 61x37", "--techniques noaa,msaa");
  for (const json& result : full.at("results")) {
    const json& shading = result.at("shading");
    EXPECT_EQ(shading.at("group_executions"), shading.at("executions")) << result.at("technique");
  }
  const json cube = replay("cube scene.spcap --frames 1 --size 61x37", "--techniques simple_complex");
  const json& shading = cube.at("results").at(0).at("shading");
  EXPECT_GT(shading.at("group_executions"), shading.at("executions"));
  EXPECT_LE(shading.at("group_executions"), 8 * 61 * 37);
}

// Where every pixel has one fragment, what the passes keep can be told by hand.
TEST_F(ReplayMeasures, MemoryIsWhatThePassesKeep) {
  const json results =
      replay("hard_fullscreen scene.spcap --frames 1 --size 64x36",
             "--techniques msaa:samples=8,msaa:samples=16,streaming:order=lists,streaming:order=one_pass "
             "--reference-samples 0")
          .at("results");
  const auto fitted = [&](std::size_t i) {
    return results.at(i).at("memory").at("fitted_bytes_per_pixel").get<double>();
  };
  const auto allocated = [&](std::size_t i) {
    return results.at(i).at("memory").at("allocated_bytes").get<double>() / (64 * 36);
  };
  // Depth and triangle of each sample, eight G-buffer samples at a time, a sum, and the list of what shows: 16 + 4
  // bytes a fragment and 4 a pixel for its end, then 4 a triangle and sums by group.
  constexpr double kShown = 16 + 4 + 4;
  for (const auto& [i, samples] : {std::pair(0, 8), std::pair(1, 16)}) {
    EXPECT_GE(fitted(i), samples * 8 + 8 * 16 + 16 + kShown);
    EXPECT_LE(fitted(i), samples * 8 + 8 * 16 + 16 + kShown + 1);
  }
  // A list has 16 + 4 bytes a fragment, 4 a pixel for its end and 4 for what is kept, and 24 a surface; the state
  // beside it eight depths, a count word and three surfaces of 20 bytes. The ordered pass has the state alone, in whole
  // tiles.
  EXPECT_EQ(results.at(2).at("counters").at("listed_fragments"), 64 * 36);
  constexpr double kList = 16 + 4 + 4 + 4 + 24, kState = 8 * 4 + 4 + 3 * 20;
  EXPECT_GE(fitted(2), kList + kState);
  EXPECT_LE(fitted(2), kList + kState + 24);  // the state comes in units of 16 bytes, sums by group
  EXPECT_GE(fitted(3), kState);
  EXPECT_LT(fitted(3), fitted(2));
  // Two images come out, of 16 bytes a pixel each, and maps of 4.
  EXPECT_NEAR(allocated(0) - fitted(0), 2 * 16, 1e-9);
  EXPECT_NEAR(allocated(2) - fitted(2), 2 * 16 + 4 * 4, 1e-9);
}

// What accumulates frames reads those before the wanted ones from the file too.
TEST_F(ReplayMeasures, AFrameAloneHasTheHistoryItHasAmongOthers) {
  const std::string options = "--techniques taa:history=2,noaa --reference-samples 16 --frames ";
  const json all = replay("city scene.spcap --frames 4 --size 48x27", options + "0-3").at("results");
  const json alone = replay("city scene.spcap --frames 4 --size 48x27", options + "3-3").at("results");
  ASSERT_EQ(all.size(), 8u);
  ASSERT_EQ(alone.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const json &a = all.at(6 + i), &b = alone.at(i);
    EXPECT_EQ(a.at("technique"), b.at("technique"));
    EXPECT_EQ(a.at("error").at("mse"), b.at("error").at("mse"));
    EXPECT_EQ(a.at("shading"), b.at("shading"));
  }
  EXPECT_LT(all.at(6).at("error").at("mse"), all.at(7).at("error").at("mse"));
}

// What the service does when a worker died: the rest of the run is measured as if it had never stopped. Flicker is told
// from the image of the frame before, which another process drew.
// A result is measured while the next technique is prepared; what goes wrong there must not take it along.
TEST_F(ReplayMeasures, AreReportedThoughTheNextTechniqueFails) {
  ASSERT_EQ(run_binary("generate spheres scene.spcap --frames 1 --size 64x36", folder_).code, 0);
  replay::ReplayJob job{folder_ / "scene.spcap", folder_ / "out", folder_ / "cache", {}};
  for (const auto& request : replay::parse_technique_list("noaa,msaa:samples=4"))
    ASSERT_TRUE(replay::add_once(job.options.techniques, replay::complete_technique(request, 4)));
  job.options.repeat = 1;
  job.options.reference_samples = 0;
  std::vector<std::string> reported;
  replay::ReplayEvents events;
  events.progress = [](const std::string& stage, std::uint32_t done, std::uint32_t, const std::string&) {
    if (stage == "replay" && done == 1) throw std::runtime_error("the second technique fails");
  };
  events.result = [&](std::uint32_t, const replay::FrameResult& result) { reported.push_back(result.technique); };
  EXPECT_THROW(replay::run_replay(job, events), std::runtime_error);
  EXPECT_EQ(reported, std::vector<std::string>{"noaa"});
}

TEST_F(ReplayMeasures, AreTheSameWhenOthersAreThereAlready) {
  ASSERT_EQ(run_binary("generate spheres scene.spcap --frames 3 --size 64x36", folder_).code, 0);
  replay::ReplayJob job{folder_ / "scene.spcap", folder_ / "out", folder_ / "cache", {}};
  for (const auto& request : replay::parse_technique_list("noaa,msaa:samples=4")) {
    ASSERT_TRUE(replay::add_once(job.options.techniques, replay::complete_technique(request, 4)));
  }
  job.options.frames = {0, 2};
  job.options.repeat = 1;
  job.options.reference_samples = 16;
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  const auto errors_without = [&](const Pairs& skipped) {
    job.options.skip = skipped;
    std::ofstream(folder_ / "job.json") << replay::to_json(job);
    const Finished run = run_binary("worker --job job.json", folder_);
    EXPECT_EQ(run.code, 0) << run.out << run.error;
    std::map<std::pair<int, int>, json> errors;
    std::istringstream lines(run.out);
    for (std::string line; std::getline(lines, line);) {
      const json message = json::parse(line);
      if (message.at("type") != "result") continue;
      errors[{message.at("result").at("frame"), message.at("ordinal")}] = message.at("result").at("error");
    }
    return errors;
  };
  const auto whole = errors_without({});
  ASSERT_EQ(whole.size(), 6u);
  EXPECT_TRUE(whole.at({1, 1}).at("flicker").is_number()) << whole.at({1, 1});
  for (const Pairs& skipped : {Pairs{{0, 0}, {0, 1}}, Pairs{{0, 0}}, Pairs{{0, 0}, {0, 1}, {1, 0}}}) {
    const auto rest = errors_without(skipped);
    EXPECT_EQ(rest.size(), 6u - skipped.size());
    for (const auto& [place, error] : rest) EXPECT_EQ(error, whole.at(place)) << place.first << "/" << place.second;
  }
}

}  // namespace
}  // namespace subpixel::tests
