#include "replay/results/results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/error.hpp"
#include "replay/results/summary.hpp"
#include "replay/results/worker_protocol.hpp"

namespace subpixel::replay {
namespace {

FrameResult example(const std::string& technique, std::uint32_t samples, std::uint32_t frame, double ms) {
  FrameResult result;
  result.frame = frame;
  result.technique = technique;
  result.parameters = {{"samples", samples}, {"weight", "equal"}};
  result.samples = samples;
  result.width = 640;
  result.height = 360;
  result.ms.total_ms = ms;
  result.ms.passes = {{"visibility", ms * 0.75}, {"lighting", ms * 0.25}};
  result.ms.spread_ms = 0.5;
  result.ms.cold_ms = 900;
  result.memory = {.paper_bytes_per_pixel = 160,
                   .paper_bytes = 160 * 640 * 360,
                   .fitted_bytes_per_pixel = 128,
                   .fitted_bytes = 128 * 640 * 360,
                   .allocated_bytes = 5'000'000'000};
  result.shading = {.executions = 230400,
                    .per_pixel_mean = 1.0,
                    .histogram = {0, 230400},
                    .group_executions = 230400,
                    .fragments = {{"visibility", 500000}}};
  result.counters = {{"fragments", 123456789012}};
  result.images = {{"image", "0_msaa.png"}};
  return result;
}

Results example_results() {
  Results results;
  results.head.capture_hash = "0123456789abcdef0123456789abcdef";
  results.head.capture_title = "park, \"small\"";
  results.head.driver = "llvmpipe";
  results.head.features = {"textures", "alpha_test"};
  results.head.repeat = 3;
  results.head.reference_samples = 64;
  results.head.wall_s = 200;
  results.head.outside_gpu_s = 25;
  results.head.outside_parts_s = {{"load", 5}, {"measure", 20}};
  for (std::uint32_t frame = 0; frame < 2; ++frame) {
    results.results.push_back(example("noaa", 1, frame, 50 + frame));
    results.results.push_back(example("msaa", 8, frame, 400 + frame));
  }
  results.results[1].error.mse = 1e-3;
  results.results[3].error.mse = 3e-3;
  return results;
}

TEST(Results, JsonFormComesBackUnchanged) {
  const Results results = example_results();
  const nlohmann::json document = to_json(results);
  const Results back = results_from_json(nlohmann::json::parse(document.dump()));
  EXPECT_EQ(to_json(back), document);
  EXPECT_FALSE(back.head.every_light);
  EXPECT_EQ(back.results[1].ms.passes[0].name, "visibility");
  EXPECT_EQ(back.results[1].memory.allocated_bytes, 5'000'000'000U);
  EXPECT_TRUE(std::isnan(back.results[0].error.mse));
  EXPECT_DOUBLE_EQ(back.results[1].error.mse, 1e-3);
}

TEST(Results, BeforeThereWereCellsEveryLightWasEvaluated) {
  nlohmann::json document = to_json(example_results());
  document["head"].erase("every_light");
  EXPECT_TRUE(results_from_json(document).head.every_light);
  document["head"]["every_light"] = "no";
  EXPECT_THROW(results_from_json(document), InputError);
}

TEST(Results, LayoutIsTheContract) {
  const nlohmann::json result = to_json(example_results()).at("results").at(1);
  EXPECT_EQ(result.at("ms").at("passes").at("visibility"), 300);
  EXPECT_EQ(result.at("ms").at("pass_order"), nlohmann::json({"visibility", "lighting"}));
  EXPECT_EQ(result.at("spread"), 0.5);
  EXPECT_EQ(result.at("shading").at("histogram"), nlohmann::json({0, 230400}));
  EXPECT_EQ(result.at("shading").at("fragments").at("visibility"), 500000);
  EXPECT_TRUE(result.at("error").at("flip_mean").is_null());
  for (const char* name : {"mse", "psnr", "flip_mean", "flip_p99", "flip_max", "hdr_rel_mse", "flicker"}) {
    EXPECT_TRUE(result.at("error").contains(name)) << name;
  }
}

TEST(Results, EqualImagesKeepTheirInfinitePsnr) {
  FrameResult result = example("msaa", 8, 0, 1);
  result.error.mse = 0;
  result.error.psnr_db = std::numeric_limits<double>::infinity();
  const nlohmann::json document = to_json(result);
  EXPECT_TRUE(document.at("error").at("psnr").is_null());
  EXPECT_TRUE(std::isinf(frame_result_from_json(document).error.psnr_db));
}

TEST(Results, PassesOfOneNameStaySeparate) {
  FrameResult result = example("msaa", 8, 0, 1);
  result.ms.passes = {{"geometry", 2}, {"geometry", 3}};
  const FrameResult back = frame_result_from_json(to_json(result));
  ASSERT_EQ(back.ms.passes.size(), 2U);
  EXPECT_EQ(back.ms.passes[1].name, "geometry 2");
  EXPECT_EQ(back.ms.passes[1].median_ms, 3);
}

TEST(Results, RefusalsNameTheField) {
  const auto refusal = [](auto change) {
    nlohmann::json document = to_json(example_results());
    change(document);
    try {
      results_from_json(document);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal([](auto& json) { json.erase("head"); }), "results: missing field: head");
  EXPECT_EQ(refusal([](auto& json) { json = 3; }), "results: expected an object: top level");
  EXPECT_EQ(refusal([](auto& json) { json["results"] = 3; }), "results: expected an array: results");
  EXPECT_EQ(refusal([](auto& json) { json["results"][2]["ms"].erase("total"); }),
            "results: missing field: results[2].ms.total");
  EXPECT_EQ(refusal([](auto& json) { json["results"][0]["frame"] = -1; }),
            "results: expected a whole number of 0 or more: results[0].frame");
  EXPECT_EQ(refusal([](auto& json) { json["results"][0]["frame"] = 4294967296; }),
            "results: number above 4294967295: results[0].frame");
  EXPECT_EQ(refusal([](auto& json) { json["results"][0]["error"]["mse"] = "low"; }),
            "results: expected a number: results[0].error.mse");
  EXPECT_EQ(refusal([](auto& json) { json["results"][0]["parameters"]["a"] = nlohmann::json::array(); }),
            "results: expected a number, text or truth value: results[0].parameters.a");
}

TEST(Results, CsvHasOneLineForEachResultAndAllColumns) {
  Results results = example_results();
  results.results[0].technique = "a \"quoted\", name";
  const std::string csv = to_csv(results);
  std::size_t lines = 0;
  for (std::size_t at = csv.find("\r\n"); at != std::string::npos; at = csv.find("\r\n", at + 2)) ++lines;
  EXPECT_EQ(lines, 1 + results.results.size());
  EXPECT_NE(csv.find(",pass_visibility_ms,pass_lighting_ms,pass_visibility_fragments,counter_fragments\r\n"),
            std::string::npos);
  EXPECT_NE(csv.find("\r\n0,\"a \"\"quoted\"\", name\",weight=equal,1,640,360,50,0.5,900,"), std::string::npos);
  EXPECT_NE(csv.find(",0;230400,230400,0.001,,,,,,,300,100,500000,123456789012\r\n"), std::string::npos);
}

TEST(Results, TableAveragesFramesAndStatesRatios) {
  const std::string table = to_table(example_results());
  std::istringstream lines(table);
  std::string line;
  std::vector<std::string> rows;
  while (std::getline(lines, line)) rows.push_back(line);
  ASSERT_EQ(rows.size(), 8U + 1U + 3U) << table;
  EXPECT_NE(rows[0].find("park, \"small\" (0123456789abcdef)"), std::string::npos);
  EXPECT_NE(rows[4].find("64 samples"), std::string::npos);
  EXPECT_NE(rows[5].find("ratios to msaa 8x and noaa 1x"), std::string::npos);
  EXPECT_EQ(rows[6], "run        200 s, of which 12.5 % outside of device passes");
  EXPECT_EQ(rows[7], "all with   weight=equal");
  EXPECT_EQ(rows[9].find("parameters"), std::string::npos);
  EXPECT_NE(rows[10].find("0.13"), std::string::npos);      // 50.5 / 400.5
  EXPECT_NE(rows[11].find("7.93"), std::string::npos);      // 400.5 / 50.5
  EXPECT_NE(rows[11].find("2.00e-03"), std::string::npos);  // mean of 1e-3 and 3e-3
  EXPECT_NE(rows[11].find("26.99"), std::string::npos);     // its PSNR
  EXPECT_TRUE(std::ranges::none_of(rows, [](const std::string& row) { return row.ends_with(' '); }));
}

TEST(Results, TableNamesTheParametersThatDiffer) {
  Results results = example_results();
  results.results.push_back(example("msaa", 8, 0, 400));
  results.results.back().parameters["weight"] = "coverage";
  const std::string table = to_table(results);
  EXPECT_EQ(table.find("all with"), std::string::npos);
  EXPECT_NE(table.find("  weight=equal\n"), std::string::npos);
  EXPECT_NE(table.find("  weight=coverage\n"), std::string::npos);
}

TEST(Results, TableOfNothingStillHasItsHead) {
  const std::string table = to_table(Results{});
  EXPECT_NE(table.find("reference  none"), std::string::npos);
  EXPECT_EQ(table.find("run  "), std::string::npos);
  EXPECT_NE(table.find("none in this run"), std::string::npos);
}

TEST(Summary, PointsAreTechniqueSamplesAndParameters) {
  Results results = example_results();
  results.results.push_back(example("msaa", 4, 0, 200));
  const std::vector<Summary> summaries = summarise(results);
  ASSERT_EQ(summaries.size(), 3U);
  EXPECT_EQ(summaries[1].frames, 2U);
  EXPECT_DOUBLE_EQ(summaries[1].total_ms, 400.5);
  EXPECT_DOUBLE_EQ(summaries[1].error.mse, 2e-3);
  EXPECT_TRUE(std::isnan(summaries[0].error.mse));
  EXPECT_EQ(baseline(summaries, "msaa"), &summaries[1]);
  EXPECT_EQ(baseline(summaries, "agaa"), nullptr);
}

TEST(WorkerJob, JsonFormComesBackUnchanged) {
  ReplayJob job;
  job.capture = "captures/a.spcap";
  job.out_dir = "out";
  job.cache_dir = "cache";
  job.options.techniques = {{"noaa", {}}, {"msaa", {{"samples", 8}, {"exact", true}}}};
  job.options.frames = {{2, 7}};
  job.options.width = 320;
  job.options.height = 180;
  job.options.point_lights = 16;
  job.options.every_light = true;
  job.options.skip = {{2, 0}, {2, 1}};
  const nlohmann::json document = to_json(job);
  const ReplayJob back = replay_job_from_json(nlohmann::json::parse(document.dump()));
  EXPECT_EQ(to_json(back), document);
  EXPECT_EQ(back.options.frames->second, 7U);
  EXPECT_TRUE(back.options.every_light);
  EXPECT_EQ(back.options.skip[1].second, 1U);

  job.options.frames.reset();
  job.options.point_lights.reset();
  job.options.every_light = false;
  const ReplayJob all_frames = replay_job_from_json(to_json(job));
  EXPECT_FALSE(all_frames.options.frames.has_value());
  EXPECT_FALSE(all_frames.options.point_lights.has_value());
  EXPECT_FALSE(all_frames.options.every_light);
}

TEST(WorkerJob, RefusalsNameTheField) {
  nlohmann::json document = to_json(ReplayJob{});
  document["options"]["frames"] = {7, 2};
  try {
    replay_job_from_json(document);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "worker job: range runs backwards: options.frames");
  }
}

}  // namespace
}  // namespace subpixel::replay
