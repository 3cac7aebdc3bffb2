// Each gate by itself: what it lets through, and what it stops.
#include "server/nightly/gates.hpp"

#include <gtest/gtest.h>

#include "server/nightly/summaries.hpp"

namespace subpixel::server {
namespace {

NightFrame frame_of(const std::string& technique, std::uint32_t frame, double ms) {
  NightFrame measured;
  replay::FrameResult& result = measured.result;
  result.frame = frame;
  result.technique = technique;
  result.samples = technique == "noaa" ? 1 : 8;
  result.ms.total_ms = ms;
  result.ms.spread_ms = 0.1 * ms;
  result.memory = {.paper_bytes_per_pixel = 160,
                   .paper_bytes = 16000,
                   .fitted_bytes_per_pixel = 96,
                   .fitted_bytes = 9600,
                   .allocated_bytes = 20000};
  result.shading.executions = 800;
  result.counters = {{"triangles", 12}, {"invalid_pixels", 0}};
  result.error.mse = 1e-3;
  result.error.flip_mean = 0.05;
  result.images = {{"image", "i" + technique}, {"hdr", "h" + technique}, {"reference", "r"}};
  return measured;
}

// Times and rounds as a night measures them; each round 1% off the one before or after it.
void time_all(NightRecord& night, std::size_t rounds) {
  for (NightCell& cell : night.cells) {
    cell.time = cell_time(cell, night.cells);
    for (std::size_t i = 0; i < rounds; ++i) {
      TimeRound round{cell.time.own.ms * (1 + 0.01 * static_cast<double>(i % 2)), {}};
      for (const auto& [technique, span] : cell.time.references) round.references[technique] = span.ms;
      cell.time.rounds.push_back(std::move(round));
    }
  }
}

// One capture by noaa, msaa and streaming, two frames each.
NightRecord a_night() {
  NightRecord night;
  night.id = 2;
  night.name = "test";
  night.baseline = "main";
  replay::ResultsHead head;
  head.driver = "llvmpipe";
  head.driver_version = "Mesa 25";
  head.cpu_model = "Xeon";
  head.width = 10;
  night.captures.push_back({"cube", "scene cube", "hash", "", head});
  for (const auto& [technique, ms] : {std::pair{"noaa", 10.0}, {"msaa", 40.0}, {"streaming", 20.0}}) {
    NightCell cell;
    cell.technique = technique;
    cell.frames = {frame_of(technique, 0, ms), frame_of(technique, 1, ms)};
    night.cells.push_back(cell);
  }
  time_all(night, 8);
  return night;
}

const NightCell& streaming(const NightRecord& night) {
  return night.cells.at(2);
}
NightCell& streaming(NightRecord& night) {
  return night.cells.at(2);
}
replay::FrameResult& second(NightRecord& night) {
  return streaming(night).frames.at(1).result;
}

void judge_it(NightRecord& night, const GateOptions& options = {}, double image_mse = 0.01) {
  const NightRecord baseline = a_night();
  judge(night, &baseline, options, [&](NightFrame&, const std::string&) { return ImageDifference{image_mse, 0.5, 3}; });
}

GateOutcome outcome(const NightRecord& night, const std::string& gate) {
  for (const GateResult& result : streaming(night).gates) {
    if (result.gate == gate) return result.outcome;
  }
  ADD_FAILURE() << "no gate " << gate;
  return GateOutcome::skipped;
}
std::string detail(const NightRecord& night, const std::string& gate) {
  for (const GateResult& result : streaming(night).gates) {
    if (result.gate == gate) return result.detail;
  }
  return "";
}

GateOptions error_gate() {
  GateOptions options;
  options.error["mse"] = {std::nullopt, 1e-6, 0.01};
  return options;
}

TEST(NightlyGates, AnUnchangedNightPasses) {
  NightRecord night = a_night();
  judge_it(night, error_gate());
  for (const NightCell& cell : night.cells) {
    EXPECT_EQ(cell.status, CellStatus::passed) << cell.technique;
    EXPECT_GE(cell.gates.size(), 8U);
    for (const GateResult& gate : cell.gates) EXPECT_EQ(gate.outcome, GateOutcome::passed) << gate.gate;
  }
}

TEST(NightlyGates, ExactOnesSeeTheSmallestChange) {
  NightRecord night = a_night();
  second(night).memory.fitted_bytes += 1;
  judge_it(night);
  EXPECT_EQ(outcome(night, "memory"), GateOutcome::failed);
  EXPECT_EQ(detail(night, "memory"), "frame 1: fitted bytes 9601, the baseline has 9600");
  EXPECT_EQ(outcome(night, "shading"), GateOutcome::passed);
  EXPECT_EQ(night.cells[0].status, CellStatus::passed) << "the other cells are not concerned";

  night = a_night();
  second(night).shading.executions -= 1;
  judge_it(night);
  EXPECT_EQ(outcome(night, "shading"), GateOutcome::failed);

  night = a_night();
  second(night).counters["triangles"] = 13;
  second(night).counters["news"] = 5;
  judge_it(night);
  EXPECT_EQ(outcome(night, "counters"), GateOutcome::failed);
  EXPECT_EQ(detail(night, "counters").find("news"), std::string::npos) << "a new counter is no failure";

  night = a_night();
  second(night).images["hdr"] = "other";
  judge_it(night);
  EXPECT_EQ(outcome(night, "images"), GateOutcome::failed);

  night = a_night();
  second(night).images["image"] = "other";
  judge_it(night, {}, 1e-9);
  EXPECT_EQ(outcome(night, "images"), GateOutcome::failed) << "however little it differs";
  EXPECT_NE(detail(night, "images").find("3 pixels differ"), std::string::npos);
}

TEST(NightlyGates, TheClassOfAProcessorDecidesWhatIsExact) {
  const auto on = [](const std::string& device, const std::string& processor) {
    NightRecord night = a_night(), baseline = a_night();
    baseline.captures[0].head->device = "llvmpipe (LLVM 15.0.6, 256 bits)";
    baseline.captures[0].head->cpu_model = "AMD EPYC 9654";
    night.captures[0].head->device = device;
    night.captures[0].head->cpu_model = processor;
    second(night).shading.executions += 1;
    judge(night, &baseline, {}, [](NightFrame&, const std::string&) { return ImageDifference{}; });
    return night;
  };
  const NightRecord narrow = on("llvmpipe (LLVM 15.0.6, 128 bits)", "AMD Ryzen 7");
  EXPECT_EQ(outcome(narrow, "shading"), GateOutcome::failed) << "exact on another model of the vendor's";
  EXPECT_EQ(outcome(narrow, "time"), GateOutcome::skipped) << "but not as fast";
  EXPECT_EQ(outcome(on("llvmpipe (LLVM 19.1.0, 256 bits)", "AMD EPYC 9654"), "shading"), GateOutcome::passed);
  EXPECT_EQ(outcome(on("llvmpipe (LLVM 15.0.6, 256 bits)", "Intel Xeon"), "shading"), GateOutcome::passed);
}

TEST(NightlyGates, AnotherMachineHasTolerances) {
  const auto elsewhere = [] {
    NightRecord night = a_night();
    night.captures[0].head->cpu_model = "EPYC";
    second(night).shading.executions = 803;
    second(night).images["image"] = "other";
    second(night).images["hdr"] = "other";
    return night;
  };
  NightRecord night = elsewhere();
  judge_it(night, {}, 1e-5);
  EXPECT_EQ(streaming(night).status, CellStatus::passed);
  EXPECT_EQ(outcome(night, "machine"), GateOutcome::skipped);
  judge_it(night, {}, 1e-3);
  EXPECT_EQ(outcome(night, "images"), GateOutcome::failed);
  night = elsewhere();
  second(night).counters["triangles"] = 20;
  second(night).error.mse = 1.5e-3;
  judge_it(night, error_gate(), 1e-5);
  EXPECT_EQ(outcome(night, "counters"), GateOutcome::passed) << "a few of few";
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::passed);
  second(night).error.mse = 1.6e-3;
  judge_it(night, error_gate(), 1e-5);
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::failed);
  night = elsewhere();
  second(night).memory.allocated_bytes += 201;
  judge_it(night, {}, 1e-5);
  EXPECT_EQ(outcome(night, "memory"), GateOutcome::failed) << "of 20000 bytes 200";
  night = elsewhere();
  second(night).shading.executions = 820;
  judge_it(night, {}, 1e-5);
  EXPECT_EQ(outcome(night, "shading"), GateOutcome::failed);
}

TEST(NightlyGates, ErrorMayRiseByItsBoundsOnly) {
  NightRecord night = a_night();
  second(night).images["image"] = "other";  // else any difference of the error is one of the metric
  second(night).error.mse = 1.0109e-3;
  judge_it(night, error_gate());
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::passed);
  second(night).error.mse = 1.0111e-3;
  judge_it(night, error_gate());
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::failed);
  second(night).error.mse = 1e-4;
  judge_it(night, error_gate());
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::passed) << "better is no failure of this gate";
  second(night).error.mse = std::nan("");
  judge_it(night, error_gate());
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::failed);
}

TEST(NightlyGates, TheErrorOfEqualImagesIsEqual) {
  NightRecord night = a_night();
  second(night).error.mse = 0.9e-3;
  judge_it(night, error_gate());
  EXPECT_EQ(outcome(night, "metrics"), GateOutcome::failed);
  EXPECT_EQ(outcome(night, "error mse"), GateOutcome::passed);
}

TEST(NightlyGates, LimitsNeedNoBaseline) {
  NightRecord night = a_night();
  GateOptions options;
  options.error["mse"].limit = 1e-3;
  judge(night, nullptr, options, {});
  EXPECT_EQ(streaming(night).status, CellStatus::new_);
  second(night).error.mse = 2e-3;
  judge(night, nullptr, options, {});
  EXPECT_EQ(streaming(night).status, CellStatus::failed);
  night = a_night();
  second(night).counters["invalid_pixels"] = 1;
  judge(night, nullptr, {}, {});
  EXPECT_EQ(outcome(night, "valid"), GateOutcome::failed);
  night = a_night();
  second(night).counters["invalid_reference_pixels"] = 1;
  judge(night, nullptr, {}, {});
  EXPECT_EQ(outcome(night, "valid"), GateOutcome::failed);
}

TEST(NightlyGates, TimeIsARatioWithinARound) {
  const auto with_time = [](double own, double machine, std::size_t rounds = 8) {
    NightRecord night = a_night();
    for (NightCell& cell : night.cells) {
      for (NightFrame& frame : cell.frames) frame.result.ms.total_ms *= machine;
    }
    for (NightFrame& frame : streaming(night).frames) frame.result.ms.total_ms *= own;
    time_all(night, rounds);
    judge_it(night);
    return night;
  };
  EXPECT_EQ(outcome(with_time(1, 3), "time"), GateOutcome::passed) << "a slower machine is no slower technique";
  EXPECT_EQ(outcome(with_time(1.03, 1), "time"), GateOutcome::passed) << "within slower";
  const NightRecord slow = with_time(1.1, 1);
  EXPECT_EQ(outcome(slow, "time"), GateOutcome::failed);
  EXPECT_NE(detail(slow, "time").find("of msaa, before 0.50"), std::string::npos) << detail(slow, "time");
  EXPECT_NE(detail(slow, "time").find("of noaa, before 2.0"), std::string::npos) << detail(slow, "time");
  EXPECT_EQ(slow.cells[0].status, CellStatus::passed);
  // One round of tonight can stand above eight by chance once in nine nights.
  EXPECT_EQ(outcome(with_time(1.1, 1, 1), "time"), GateOutcome::skipped);
  EXPECT_EQ(outcome(with_time(1, 1, 0), "time"), GateOutcome::skipped);
}

TEST(NightlyGates, EarlierNightsThatPassedAreCompared) {
  NightRecord baseline = a_night(), between = a_night();
  baseline.id = 1;
  between.baseline_night = 1;
  judge_it(between);
  ASSERT_EQ(earlier_rounds(baseline, {between, between}).at({"cube", "streaming"}).size(), 16u);
  between.captures[0].head->cpu_model = "EPYC";
  EXPECT_TRUE(earlier_rounds(baseline, {between}).empty()) << "times of another machine";
  between = a_night();
  between.baseline_night = 7;
  judge_it(between);
  EXPECT_TRUE(earlier_rounds(baseline, {between}).empty()) << "another baseline's";
  between.baseline_night = 1;
  for (GateResult& gate : streaming(between).gates)
    if (gate.gate == "time") gate.outcome = GateOutcome::failed;
  EXPECT_EQ(earlier_rounds(baseline, {between}).count({"cube", "streaming"}), 0u) << "a slow night is no measure";
  EXPECT_EQ(earlier_rounds(baseline, {between}).count({"cube", "msaa"}), 1u);
}

TEST(NightlyGates, ASlowReferenceIsNotTheOthersFault) {
  NightRecord night = a_night();
  for (NightFrame& frame : night.cells[0].frames) frame.result.ms.total_ms *= 0.2;  // a faster noaa
  time_all(night, 8);
  judge_it(night);
  EXPECT_EQ(outcome(night, "time"), GateOutcome::passed) << "the ratio to msaa has not changed";
}

TEST(NightlyGates, InstructionsAreJudgedWhereTheyAreCounted) {
  const auto with = [](double before, double now) {
    NightRecord night = a_night(), baseline = a_night();
    streaming(baseline).time.instructions = before;
    streaming(night).time.instructions = now;
    judge(night, &baseline, {}, [](NightFrame&, const std::string&) { return ImageDifference{}; });
    for (const GateResult& gate : streaming(night).gates)
      if (gate.gate == "instructions") return std::string(to_text(gate.outcome));
    return std::string("none");
  };
  EXPECT_EQ(with(1e9, 1.01e9), "passed");
  EXPECT_EQ(with(1e9, 1.03e9), "failed");
  EXPECT_EQ(with(0, 1e9), "none");
  EXPECT_EQ(with(1e9, 0), "none");
}

TEST(NightlyGates, ShortTimesAreNotJudged) {
  NightRecord night = a_night();
  GateOptions options;
  options.time_minimum_ms = 1000;
  judge_it(night, options);
  EXPECT_EQ(outcome(night, "time"), GateOutcome::skipped);
  EXPECT_EQ(streaming(night).status, CellStatus::passed);
}

TEST(NightlyGates, AnotherCaptureOrSizeIsSaidOnce) {
  NightRecord night = a_night();
  night.captures[0].hash = "another";
  judge_it(night);
  EXPECT_EQ(outcome(night, "capture"), GateOutcome::failed);
  EXPECT_EQ(streaming(night).gates.size(), 2U) << "the rest would only repeat it";
  night = a_night();
  night.captures[0].head->width = 20;
  judge_it(night);
  EXPECT_EQ(outcome(night, "capture"), GateOutcome::failed);
}

TEST(NightlyGates, NewMissingAndBroken) {
  NightRecord night = a_night();
  streaming(night).technique = "streaming:surfaces=4";
  judge_it(night);
  EXPECT_EQ(streaming(night).status, CellStatus::new_);
  ASSERT_EQ(night.cells.size(), 4U);
  EXPECT_EQ(night.cells[3].status, CellStatus::missing);
  judge_it(night);
  EXPECT_EQ(night.cells.size(), 4U) << "judged again, it is missing once";

  night = a_night();
  night.captures[0].problem = "the process was ended by signal 11";
  streaming(night).frames.clear();
  judge_it(night);
  EXPECT_EQ(outcome(night, "replay"), GateOutcome::failed);
  EXPECT_EQ(detail(night, "replay"), "the process was ended by signal 11");

  night = a_night();
  streaming(night).frames.pop_back();
  judge_it(night);
  EXPECT_EQ(outcome(night, "frames"), GateOutcome::failed);
}

TEST(NightlySummaries, SayWhatFailed) {
  NightRecord night = a_night();
  night.status = NightStatus::failed;
  night.baseline_night = 1;
  night.started_utc = "2025-01-31T12:00:00.123Z";
  night.captures[0].name = "a<b|\"c\"";
  const NightRecord as_named = night;
  second(night).memory.fitted_bytes += 1;
  judge(night, &as_named, {}, {});
  EXPECT_EQ(headline(night), "night 2 of test failed: 1 of 3 cells failed; compared with main (night 1)");

  const std::string markdown = to_markdown(night);
  EXPECT_NE(markdown.find("| a\\<b\\|\"c\" | streaming | memory | frame 1: fitted bytes 9601"), std::string::npos)
      << markdown;
  EXPECT_NE(markdown.find("| streaming | **FAILED** |"), std::string::npos);

  const std::string junit = to_junit(night);
  EXPECT_NE(junit.find("<testsuite name=\"a&lt;b|&quot;c&quot;\""), std::string::npos) << junit;
  EXPECT_NE(
      junit.find("name=\"streaming memory\"><failure message=\"frame 1: fitted bytes 9601, the baseline has 9600\""),
      std::string::npos);
  EXPECT_NE(junit.find("failures=\"1\""), std::string::npos);
  std::size_t cases = 0;
  for (std::size_t at = 0; (at = junit.find("<testcase", at)) != std::string::npos; ++at) ++cases;
  std::size_t gates = 0;
  for (const NightCell& cell : night.cells) gates += cell.gates.size();
  EXPECT_EQ(cases, gates);

  const nlohmann::json document = to_json(night);
  EXPECT_EQ(document.at("counts").at("failed"), 1);
  EXPECT_EQ(document.at("cells").at(2).at("status"), "failed");
}

}  // namespace
}  // namespace subpixel::server
