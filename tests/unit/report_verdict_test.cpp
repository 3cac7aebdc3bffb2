// The report's verdicts follow the numbers: made-up results on both sides of each kind of claim.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/report/claims.hpp"
#include "bench/report/document.hpp"
#include "bench/report/store.hpp"
#include "bench/report/winners.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;
using replay::ParameterValues;

FrameResult made_up(const std::string& technique, const ParameterValues& given = {}) {
  FrameResult result;
  result.technique = technique;
  result.parameters = replay::find_technique(technique).with(given).values;
  result.samples = result.parameters.at("samples").get<std::uint32_t>();
  result.width = 100;
  result.height = 10;
  result.ms.total_ms = 100;
  result.memory.fitted_bytes_per_pixel = result.memory.paper_bytes_per_pixel = 100;
  result.shading.executions = 1000;
  result.error.mse = 1e-4;
  result.error.flip_mean = 0.01;
  return result;
}

Run sweep(const std::string& scene, std::vector<FrameResult> results) {
  Run run;
  run.plan = {.kind = RunKind::sweep, .scene = scene, .width = 100, .height = 10, .reference_samples = 64, .repeat = 3};
  run.results.head.reference_samples = 64;
  run.results.results = std::move(results);
  return run;
}

std::vector<Comparison> compare(const std::string& title, const Measured& measured) {
  for (const Claim& claim : all_claims())
    if (claim.technique + ": " + claim.title == title) return claim.compare(measured);
  ADD_FAILURE() << "no claim " << title;
  return {};
}

TEST(ReportVerdict, ALimitWithinTheSpreadDecidesNothing) {
  const Interval interval{0.9, 1.0, 1.1};
  EXPECT_EQ(at_most(interval, 1.1), Outcome::held);
  EXPECT_EQ(at_most(interval, 1.05), Outcome::undecided);
  EXPECT_EQ(at_most(interval, 0.9), Outcome::undecided);
  EXPECT_EQ(at_most(interval, 0.89), Outcome::not_held);
  EXPECT_EQ(at_least(interval, 0.9), Outcome::held);
  EXPECT_EQ(at_least(interval, 1.0), Outcome::undecided);
  EXPECT_EQ(at_least(interval, 1.11), Outcome::not_held);
  EXPECT_EQ(equal(96, 96.04, 0.05), Outcome::held);
  EXPECT_EQ(equal(96, 96.06, 0.05), Outcome::not_held);
}

TEST(ReportVerdict, WhatIsNoNumberDoesNotHold) {
  const double none = std::nan("");
  EXPECT_EQ(at_most(exactly(none), 1), Outcome::not_held);
  EXPECT_EQ(at_least(exactly(none), 1), Outcome::not_held);
  EXPECT_EQ(at_most(exactly(1), none), Outcome::not_held);
  EXPECT_EQ(equal(none, 1, 0.1), Outcome::not_held);
}

TEST(ReportVerdict, WordsCountScenes) {
  const Comparison yes{"a", "", "", Outcome::held}, no{"b", "", "", Outcome::not_held},
      open{"c", "", "", Outcome::undecided};
  EXPECT_EQ(words(std::vector<Comparison>{}), "not measured");
  EXPECT_EQ(words({yes, yes}), "held");
  EXPECT_EQ(words({yes, no, no}), "held on 1 of 3");
  EXPECT_EQ(words({no, no}), "not held");
  EXPECT_EQ(words({yes, no, open}), "held on 1 of 3, 1 within the spread");
  EXPECT_EQ(words({no, open}), "not held, 1 within the spread");
  EXPECT_EQ(words({open}), "within the spread");
  EXPECT_EQ(verdict({yes, yes}), Verdict::all);
  EXPECT_EQ(verdict({yes, open}), Verdict::some);
  EXPECT_EQ(verdict({no}), Verdict::none);
  EXPECT_EQ(verdict({open}), Verdict::unknown);
  EXPECT_EQ(verdict({}), Verdict::unknown);
}

TEST(ReportVerdict, NothingMeasuredJudgesNothing) {
  const Measured nothing, bare{{sweep("city", {made_up("noaa")})}};
  for (const Claim& claim : all_claims()) {
    EXPECT_TRUE(claim.compare(nothing).empty()) << claim.title;
    EXPECT_TRUE(claim.compare(bare).empty()) << claim.title;
    // A reason must not need what is missing either.
    EXPECT_TRUE(!claim.reason || !claim.reason(bare).empty()) << claim.title;
  }
}

TEST(ReportVerdict, PublishedBytesHoldToADigit) {
  FrameResult eight = made_up("streaming"), base = made_up("simple_complex");
  eight.memory.paper_bytes_per_pixel = 96;
  base.memory.paper_bytes_per_pixel = 192;
  const char* title = "streaming: memory against `simple_complex`";
  EXPECT_EQ(words(compare(title, {{sweep("city", {eight, base})}})), "held");
  eight.memory.paper_bytes_per_pixel = 96.5;
  EXPECT_EQ(words(compare(title, {{sweep("city", {eight, base})}})), "not held");
  eight.memory.paper_bytes_per_pixel = 96;
  base.memory.paper_bytes_per_pixel = 193;
  EXPECT_EQ(words(compare(title, {{sweep("city", {eight, base})}})), "not held");
}

TEST(ReportVerdict, ExecutionsAreHeldToTheSceneTheyStandFor) {
  FrameResult ours = made_up("streaming"), base = made_up("simple_complex");
  ours.shading.executions = 449;
  const char* title = "streaming: fewer lighting executions than `simple_complex`";
  EXPECT_EQ(words(compare(title, {{sweep("grass", {ours, base})}})), "held");
  for (const std::uint64_t off : {428u, 470u}) {  // two points either way
    ours.shading.executions = off;
    EXPECT_EQ(words(compare(title, {{sweep("grass", {ours, base})}})), "not held") << off;
  }
  EXPECT_EQ(words(compare(title, {{sweep("arcade", {ours, base})}})), "not held");
  ours.shading.executions = 779;
  EXPECT_EQ(words(compare(title, {{sweep("arcade", {ours, base})}})), "held");
  EXPECT_TRUE(compare(title, {{sweep("city", {ours, base})}}).empty());  // stands for none of theirs
}

TEST(ReportVerdict, ErrorsDecideSceneByScene) {
  FrameResult better = made_up("dcaa"), worse = made_up("dcaa");
  better.error.mse = 0.99e-4;
  worse.error.mse = 1.01e-4;
  const Measured measured{{sweep("bamboo", {better, made_up("forward")}), sweep("city", {worse, made_up("forward")}),
                           sweep("grass", {worse})}};
  const auto comparisons = compare("dcaa: less error than 8x MSAA on every scene", measured);
  ASSERT_EQ(comparisons.size(), 2u);  // grass lacks forward
  EXPECT_EQ(comparisons[0].outcome, Outcome::held);
  EXPECT_EQ(comparisons[1].outcome, Outcome::not_held);
  EXPECT_EQ(comparisons[1].scene, "city");
  EXPECT_NEAR(comparisons[1].value, 1.01, 1e-9);
}

TEST(ReportVerdict, AnotherParameterIsAnotherSetting) {
  FrameResult changed = made_up("dcaa", {{"merge_weight", "shown"}});
  const Measured measured{{sweep("city", {changed, made_up("forward")})}};
  EXPECT_TRUE(compare("dcaa: less error than 8x MSAA on every scene", measured).empty());
}

TEST(ReportVerdict, TimesDecideOnlyBeyondTheirSpread) {
  FrameResult ours = made_up("streaming"), base = made_up("simple_complex");
  const char* title = "streaming: 30% less frame time in one figure, on par elsewhere";
  ours.ms.total_ms = 65;
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "held");
  ours.ms.spread_ms = 20;  // 55 to 75
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "held on 1 of 2, 1 within the spread");
  ours.ms.total_ms = 85;  // 75 to 95
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "held on 1 of 2");
  ours.ms.total_ms = 115;
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "not held");
}

TEST(ReportVerdict, SpeedUpsAreOfTheRunWithThePublishedLights) {
  FrameResult ours = made_up("agaa", {{"shading", "blinn_phong"}});
  FrameResult base = made_up("simple_complex", {{"shading", "blinn_phong"}, {"normal_threshold", 1}});
  ours.ms.passes = {{"visibility", 50}, {"shade", 10}};
  base.ms.passes = {{"visibility", 50}, {"shade simple", 10}, {"shade complex", 15.4}, {"resolve", 3}};
  auto run = sweep("city", {ours, base});
  const char* title = "agaa: speed-up of shading";
  EXPECT_TRUE(compare(title, {{run}}).empty());
  run.plan.kind = RunKind::lights;
  run.plan.point_lights = 16;
  EXPECT_EQ(words(compare(title, {{run}})), "held");  // 2.84, as Old City has
  auto renamed = run;
  renamed.results.results[0].ms.passes[1].name = "light";
  EXPECT_EQ(words(compare(title, {{renamed}})), "not measured");
  run.results.results[1].ms.passes[2].median_ms = 15.3;
  EXPECT_EQ(words(compare(title, {{run}})), "not held");
}

TEST(ReportVerdict, ListsAreMeasuredByTheBlocksInUse) {
  FrameResult lists = made_up("linked_list");
  // 64 bytes a pixel are those of 4x MSAA: 32 of depth and 16 / 7 blocks.
  lists.counters["blocks_used"] = 1285;
  const char* title = "linked_list: 8x lists take less memory than 4x MSAA";
  EXPECT_EQ(words(compare(title, {{sweep("city", {lists})}})), "held");
  lists.counters["blocks_used"] = 1287;
  EXPECT_EQ(words(compare(title, {{sweep("city", {lists})}})), "not held");
}

PairError& pair_of(Run& run, const ImagePair& pair) {
  const auto whole = [](const replay::TechniqueRequest& request) {
    return replay::TechniqueRequest{request.technique,
                                    replay::find_technique(request.technique).with(request.parameters).values};
  };
  return run.pairs[pair_name({whole(pair.test), whole(pair.base)})];
}

TEST(ReportVerdict, LookAlikesAreHeldToTheirYardstick) {
  report::Run run = sweep("grass", {made_up("streaming")});
  const char* title = "streaming: three surfaces look like 8x MSAA";
  pair_of(run, {{"streaming", {}}, {"forward", {}}}).flip_mean = 0.02;
  EXPECT_TRUE(compare(title, {{run}}).empty());  // nothing to hold it to
  PairError& yardstick = pair_of(run, {{"simple_complex", {}}, {"forward", {}}});
  yardstick.flip_mean = 0.02;
  EXPECT_EQ(words(compare(title, {{run}})), "held");
  yardstick.flip_mean = 0.019;
  EXPECT_EQ(words(compare(title, {{run}})), "not held");
}

TEST(ReportVerdict, ExecutionsOfAggregatesAreThoseOfGroups) {
  FrameResult ours = made_up("agaa"), base = made_up("simple_complex", {{"normal_threshold", 1}});
  ours.shading.executions = 999;
  ours.shading.group_executions = 250;
  base.shading.group_executions = 1000;
  const char* title = "agaa: executions of Simple/Complex";
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "held");
  ours.shading.group_executions = 251;
  EXPECT_EQ(words(compare(title, {{sweep("city", {ours, base})}})), "not held");
}

TEST(ReportVerdict, TheKneeIsWhereMorePlacesBringLess) {
  FrameResult two = made_up("dcaa", {{"surfaces", 2}}), four = made_up("dcaa"),
              eight = made_up("dcaa", {{"surfaces", 8}});
  two.error.mse = 5e-4;
  four.error.mse = 3e-4;
  eight.error.mse = 1.1e-4;
  const char* title = "dcaa: four surfaces are a sweet spot";
  EXPECT_EQ(words(compare(title, {{sweep("city", {two, four, eight})}})), "held");
  eight.error.mse = 0.9e-4;
  EXPECT_EQ(words(compare(title, {{sweep("city", {two, four, eight})}})), "not held");
}

TEST(ReportVerdict, SteadinessIsTheMeanOverFrames) {
  report::Run run = sweep("city", {});
  run.plan.kind = RunKind::frames;
  const double ours[] = {std::nan(""), 0.1, 0.3}, theirs[] = {std::nan(""), 0.2, 0.21};
  for (int i = 0; i < 3; ++i) {
    run.results.results.push_back(made_up("dcaa"));
    run.results.results.back().error.flicker = ours[i];
    run.results.results.push_back(made_up("forward"));
    run.results.results.back().error.flicker = theirs[i];
  }
  const char* title = "dcaa: steadier over time than 8x MSAA";
  EXPECT_EQ(words(compare(title, {{run}})), "held");
  run.results.results.back().error.flicker = 0.19;
  EXPECT_EQ(words(compare(title, {{run}})), "not held");
}

TEST(ReportVerdict, APublicationIsJudgedAtItsSize) {
  Claim claim = dcaa_claims()[1];
  FrameResult better = made_up("dcaa"), worse = made_up("dcaa");
  better.error.mse = 0.5e-4;
  worse.error.mse = 2e-4;
  report::Run small = sweep("city", {worse, made_up("forward")}), large = sweep("city", {better, made_up("forward")}),
              other = sweep("fur", {worse, made_up("forward")});
  small.plan.width = other.plan.width = 640;
  large.plan.width = 1920;
  large.plan.kind = RunKind::paper;
  const std::string text = make_document({{small, large, other}}, {claim}, "command").markdown;
  EXPECT_NE(
      text.find("| city | 0.64 / 1.32 (Citadel), 0.69 / 2.20 (Villa) | 0.50 / 1.00 | yes | 2.00 / 1.00, **no** |"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find("Held. On scenes that the publication has nothing like, at 640x360: not held"), std::string::npos)
      << text;
}

TEST(ReportWinners, KeepToTheirBudgets) {
  FrameResult msaa = made_up("msaa"), quick = made_up("agaa"), slow = made_up("dcaa"), small = made_up("fxaa");
  quick.error.mse = 0.8e-4;
  quick.ms.total_ms = 99;
  slow.error.mse = 0.5e-4;
  slow.ms.total_ms = 101;
  small.error.mse = 9e-4;
  small.memory.paper_bytes_per_pixel = 17;
  small.ms.total_ms = 20;
  replay::Results results;
  results.results = {msaa, quick, slow, small};
  const auto summaries = summarise(results);
  EXPECT_EQ(lowest_error_in_time(summaries, replay::PlotError::mse)->technique, "agaa");
  EXPECT_EQ(least_memory(summaries, replay::PlotError::mse, 1e-3)->technique, "fxaa");
  EXPECT_EQ(least_memory(summaries, replay::PlotError::mse, 8e-4)->technique, "dcaa");  // of equal bytes the better one
  EXPECT_EQ(least_memory(summaries, replay::PlotError::mse, 1e-5), nullptr);
}

TEST(ReportPlan, NamesSettingsByWhatTellsThemApart) {
  const auto name = [](const std::string& technique, const ParameterValues& given) {
    return setting_name(technique, made_up(technique, given).parameters);
  };
  EXPECT_EQ(name("noaa", {}), "noaa");
  EXPECT_EQ(name("msaa", {}), "msaa 8x");
  EXPECT_EQ(name("streaming", {}), "streaming S=3");
  EXPECT_EQ(name("streaming", {{"samples", 4}, {"occlusion", "depth_test"}}), "streaming S=3 4x occlusion=depth_test");
  EXPECT_EQ(name("agaa", {{"aggregates", 3}, {"samples", 16}}), "agaa c=3 16x");
  EXPECT_EQ(name("linked_list", {{"pool", 0}}), "linked_list 8x pool=0.0");
}

TEST(ReportPlan, SweepsHaveEveryTechnique) {
  const auto plan = make_plan({.scenes = {"city", "grass"}});
  std::map<std::string, int> names;
  for (const RunPlan& run : plan) ++names[run.name()];
  for (const auto& [name, count] : names) EXPECT_EQ(count, 1) << name;  // one file each
  ASSERT_EQ(plan.front().kind, RunKind::sweep);
  for (const replay::Technique* technique : replay::techniques()) {
    EXPECT_TRUE(std::ranges::any_of(plan.front().techniques, [&](const auto& request) {
      return request.technique == technique->name;
    })) << technique->name;
  }
}

TEST(ReportPlan, StoredRunsMustAnswerWhatIsAskedNow) {
  const RunPlan plan = make_plan({.quick = true, .scenes = {"cube"}, .techniques = "noaa,msaa:samples=4|8"}).front();
  replay::Results results;
  results.head.width = plan.width;
  results.head.height = plan.height;
  results.head.repeat = plan.repeat;
  results.head.reference_samples = plan.reference_samples;
  for (const auto& request : plan.techniques) results.results.push_back(made_up(request.technique, request.parameters));
  EXPECT_TRUE(answers(results, plan));
  replay::Results other = results;
  other.head.repeat = 1;
  EXPECT_FALSE(answers(other, plan));
  other = results;
  other.results.back().parameters["samples"] = 16;
  EXPECT_FALSE(answers(other, plan));
  other = results;
  other.results.pop_back();
  EXPECT_FALSE(answers(other, plan));
  // By how many lights points evaluate times differ, and nothing else.
  other = results;
  other.head.every_light = true;
  EXPECT_FALSE(answers(other, plan));
  RunPlan once = plan;
  once.repeat = other.head.repeat = 1;
  EXPECT_TRUE(answers(other, once));
}

TEST(ReportDocument, AReasonStandsOnlyWhereAClaimFails) {
  Claim claim = dcaa_claims()[1];
  claim.reason = [](const Measured& failed) {
    return "Because of " + std::to_string(failed.runs.size()) + " scene, " + failed.runs[0].plan.scene + ".";
  };
  FrameResult better = made_up("dcaa"), worse = made_up("dcaa");
  better.error.mse = 0.5e-4;
  worse.error.mse = 2e-4;
  const auto good = sweep("bamboo", {better, made_up("forward"), made_up("msaa")}),
             bad = sweep("city", {worse, made_up("forward"), made_up("msaa")});
  const std::string held = make_document({{good}}, {claim}, "command").markdown;
  EXPECT_NE(held.find("| 0.50 times the MSE | held |"), std::string::npos) << held;
  EXPECT_EQ(held.find("Because of"), std::string::npos) << held;
  EXPECT_EQ(held.find("Not there yet"), std::string::npos);
  const std::string part = make_document({{good}}, {claim}, "command", {"city_9x9", "fur_9x9"}).markdown;
  EXPECT_NE(part.find("of 3 runs that the command makes, 1 are stored"), std::string::npos) << part;
  EXPECT_NE(part.find("Missing: city_9x9, fur_9x9."), std::string::npos) << part;
  const Document both = make_document({{good, bad}}, {claim}, "command");
  EXPECT_NE(both.markdown.find("| 0.50 to 2.00 times the MSE | **held on 1 of 2** |"), std::string::npos)
      << both.markdown;
  EXPECT_NE(both.markdown.find("Held on 1 of 2. Because of 1 scene, city."), std::string::npos) << both.markdown;
  EXPECT_NE(held.find("Of 1 claims 1 hold wherever they were measured, 0 on some"), std::string::npos) << held;
  EXPECT_NE(both.markdown.find("Of 1 claims 0 hold wherever they were measured, 1 on some"), std::string::npos);
  // Time and memory plots of both scenes, linked where they are written.
  ASSERT_EQ(both.images.size(), 4u);
  for (const auto& [path, svg] : both.images) {
    EXPECT_NE(both.markdown.find("(" + path + ")"), std::string::npos) << path;
    EXPECT_TRUE(svg.starts_with("<svg")) << path;
  }
}

TEST(ReportDocument, SizesStandBesideEachOther) {
  FrameResult ours = made_up("agaa");
  ours.ms.total_ms = 50;
  ours.error.mse = 3e-4;
  const auto small = sweep("city", {made_up("msaa"), ours});
  auto large = small;
  large.plan.kind = RunKind::paper;
  large.plan.width = 200;
  large.results.results[1].ms.total_ms = 25;
  EXPECT_EQ(make_document({{small}}, {}, "command").markdown.find("## Sizes"), std::string::npos);
  const std::string text = make_document({{small, large}}, {}, "command").markdown;
  EXPECT_NE(text.find("| city | 100x10: time | MSE | over `msaa` 8x | ms | 200x10: time"), std::string::npos) << text;
  EXPECT_NE(text.find("| `agaa c=2` | 0.50 | 3.00 | 3.00 | 50 | 0.25 | 3.00 | 3.00 | 25 |"), std::string::npos) << text;
}

}  // namespace
}  // namespace subpixel::report
