// How work is divided among nodes, and what is believed of what they leave in the shared folder.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <map>
#include <set>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "server/engine/shard_folder.hpp"
#include "server/engine/shard_plan.hpp"
#include "server/engine/slurm_commands.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;
using server::ReplayRequest;
using server::Shard;

ReplayRequest request_of(std::size_t techniques, std::vector<double> seconds = {}) {
  ReplayRequest request;
  request.job.options.techniques.assign(techniques, {"noaa", {}});
  request.technique_seconds = std::move(seconds);
  return request;
}

// Every result is in exactly one shard, and what a shard leaves out is the rest.
void expect_cover(const std::vector<Shard>& shards, std::uint32_t first, std::uint32_t last, std::size_t techniques) {
  std::multiset<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const Shard& shard : shards) {
    EXPECT_FALSE(shard.pairs.empty());
    seen.insert(shard.pairs.begin(), shard.pairs.end());
    const auto skip = server::left_out(shard.pairs, first, last, techniques);
    EXPECT_EQ(skip.size() + shard.pairs.size(), (last - first + 1) * techniques);
  }
  EXPECT_EQ(seen.size(), (last - first + 1) * techniques);
  EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), seen.size());
}

TEST(ShardPlan, DividesByMeasuredTimesFramesFirst) {
  // 4 techniques of 10 s a frame, 8 frames: 40 s a frame, so 120 s are 3 frames, which evenly is 3 shards.
  const ReplayRequest even = request_of(4, {80, 80, 80, 80});
  const auto frames = server::plan_shards(even, 7, 2, 9, {120, 16});
  ASSERT_EQ(frames.size(), 3u);
  expect_cover(frames, 2, 9, 4);
  for (const Shard& shard : frames) {
    EXPECT_EQ(shard.request, 7u);
    EXPECT_EQ(shard.pairs.size() % 4, 0u) << "a frame's techniques stay together";
    EXPECT_NEAR(shard.seconds, 10.0 * static_cast<double>(shard.pairs.size()), 1e-9);
  }
  // A frame that takes longer than a shard should is divided by techniques, the dear one alone.
  const auto parts = server::plan_shards(request_of(4, {300, 20, 20, 20}), 0, 0, 0, {120, 16});
  expect_cover(parts, 0, 0, 4);
  ASSERT_GE(parts.size(), 2u);
  EXPECT_EQ(parts[0].pairs.size(), 1u);
}

TEST(ShardPlan, WithoutTimesCountsResults) {
  const auto shards = server::plan_shards(request_of(5), 0, 0, 8, {300, 16});
  ASSERT_EQ(shards.size(), 3u);
  expect_cover(shards, 0, 8, 5);
  EXPECT_EQ(server::plan_shards(request_of(40), 0, 0, 0, {300, 16}).size(), 3u);
  EXPECT_EQ(server::plan_shards(request_of(1), 0, 0, 8, {300, 1}).size(), 9u);
  // Times that make no sense divide as far as it goes and no further.
  for (const double seconds : {0.0, 1e300}) {
    expect_cover(server::plan_shards(request_of(2, {seconds, seconds}), 0, 0, 3, {300, 16}), 0, 3, 2);
  }
}

class ShardFolder : public testing::Test {
 protected:
  ShardFolder() {
    fs::create_directories(results());
    job_.options.techniques = {{"noaa", {}}, {"msaa", {{"samples", 8}}}};
    job_.options.frames = {0, 1};
  }
  fs::path results() const { return folder_.path() / "results"; }
  fs::path blobs() const { return folder_.path() / "blobs"; }
  server::ShardOutcome read() const { return server::read_outcome(results(), job_, {{0, 0}, {0, 1}}); }
  void write(std::uint32_t frame, std::uint32_t ordinal, const std::string& technique) const {
    server::ShardResult result;
    result.ordinal = ordinal;
    result.result = stored_result(frame, technique);
    result.images["image"] = server::write_blob(blobs(), "a.png", stored_image(100, 1));
    server::write_result(results(), result);
  }
  // A file of a name that its content deserves.
  void plant(const std::string& stem, const std::string& text) const {
    const std::string hash = content_hash_hex(std::as_bytes(std::span(text)));
    std::ofstream(results() / (stem + "." + hash + ".json"), std::ios::binary) << text;
  }
  std::string refusal() const {
    const server::ShardOutcome outcome = read();
    EXPECT_TRUE(outcome.results.empty());
    EXPECT_EQ(outcome.refused.size(), 1u);
    EXPECT_TRUE(fs::is_empty(results())) << "what is refused is done again";
    return outcome.refused.empty() ? "" : outcome.refused[0];
  }
  fs::path only_file() const { return fs::directory_iterator(results())->path(); }

  TemporaryFolder folder_;
  replay::ReplayJob job_;
};

TEST_F(ShardFolder, GivesBackWhatWasWritten) {
  write(0, 1, "msaa");
  replay::ResultsHead head;
  head.driver = "none";
  server::ShardEnd written;  // by members: GCC 12 warns of the nested braces
  written.end.head = head;
  written.node = "n1";
  written.seconds = 2.5;
  server::write_end(results(), written);
  const server::ShardOutcome outcome = read();
  ASSERT_EQ(outcome.results.size(), 1u);
  const server::ShardResult& result = outcome.results.at({0, 1});
  EXPECT_EQ(result.result.images.at("image"), "a.png");
  EXPECT_EQ(server::read_blob(blobs(), result.images.at("image")).bytes, stored_image(100, 1).bytes);
  EXPECT_EQ(server::read_blob(blobs(), result.images.at("image")).media_type, "image/png");
  ASSERT_TRUE(outcome.end);
  EXPECT_EQ(outcome.end->node, "n1");
  EXPECT_EQ(outcome.end->end.head.value().driver, "none");
  EXPECT_TRUE(outcome.refused.empty());
}

TEST_F(ShardFolder, HalvesAndForeignFilesDoNotCount) {
  write(0, 0, "noaa");
  fs::resize_file(only_file(), fs::file_size(only_file()) / 2);
  EXPECT_NE(refusal().find("another hash"), std::string::npos);
  write(1, 0, "noaa");
  EXPECT_NE(refusal().find("not of this shard"), std::string::npos);
  write(0, 0, "msaa");
  EXPECT_NE(refusal().find("not of this shard"), std::string::npos);
  write(0, 4'000'000'000, "noaa");
  EXPECT_NE(refusal().find("not of this shard"), std::string::npos);
  plant("0-0", std::string(400'000, '['));
  EXPECT_NE(refusal().find("nested too deeply"), std::string::npos);
  plant("0-0", "{}");
  EXPECT_NE(refusal().find("missing field"), std::string::npos);
  plant("end", R"({"head": null, "problem": 1, "exit": 4, "node": "", "seconds": 0})");
  EXPECT_NE(refusal().find("expected a string"), std::string::npos);
  fs::create_symlink("/etc/passwd", results() / ("0-0." + std::string(32, 'a') + ".json"));
  EXPECT_NE(refusal().find("can't be opened"), std::string::npos);
  const fs::path huge = results() / ("0-0." + std::string(32, 'a') + ".json");
  std::ofstream(huge) << "x";
  fs::resize_file(huge, std::uintmax_t{1} << 40);  // a hole: it takes no room
  EXPECT_NE(refusal().find("too large"), std::string::npos);
  ASSERT_EQ(::mkfifo(huge.c_str(), 0600), 0);
  EXPECT_NE(refusal().find("no file"), std::string::npos) << "and nobody waited for a writer";
  std::ofstream(results() / "0-0.json") << "{}";
  EXPECT_NE(refusal().find("another name"), std::string::npos);
}

TEST_F(ShardFolder, ImagesAreOfTheirHashAndInTheirFolder) {
  write(0, 0, "noaa");
  const server::ImageName image = read().results.at({0, 0}).images.at("image");
  const fs::path blob = blobs() / image.hash.substr(0, 2) / image.hash;
  std::fstream(blob, std::ios::in | std::ios::out) << "X";
  EXPECT_THROW(server::read_blob(blobs(), image), InputError);
  EXPECT_FALSE(fs::exists(blob)) << "a damaged one would be taken for written";
  EXPECT_THROW(server::read_blob(blobs(), image), InputError);
  const std::string text = [&] {
    std::ifstream in(only_file());
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  fs::remove(only_file());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    plant("0-0", changed);
    return refusal();
  };
  EXPECT_NE(with("\"a.png\"", "\"../a.png\"").find("not a plain file name"), std::string::npos);
  EXPECT_NE(with(image.hash, "../../../../etc/passwd").find("no content hash"), std::string::npos);
  EXPECT_NE(with("\"bytes\":101", "\"bytes\":99999999999").find("too large"), std::string::npos);
}

TEST(SlurmWords, AreReadAsFarAsTheyMakeSense) {
  const auto queue = server::parse_squeue(
      "17_3|RUNNING|n1|None\n17_4|PENDING||Resources\n18|RUNNING|n1|None\n\n|||\n17_x|A|b|c\n"
      "17_5\n19_0|PENDING||ReqNodeNotAvail, UnavailableNodes:n[1-2]\n");
  ASSERT_EQ(queue.size(), 3u);
  EXPECT_EQ(queue.at({17, 3}).node, "n1");
  EXPECT_EQ(queue.at({17, 4}).reason, "Resources");
  EXPECT_EQ(queue.at({19, 0}).reason, "ReqNodeNotAvail, UnavailableNodes:n[1-2]");
  const auto ended = server::parse_sacct(
      "17_3|CANCELLED by 0|n1\n17_4|TIMEOUT|n2\n17_5|CANCELLED by 1000|None assigned\n17_[6-9]|PENDING|\n");
  ASSERT_EQ(ended.size(), 3u);
  EXPECT_EQ(ended.at({17, 3}).state, "CANCELLED");
  EXPECT_EQ(ended.at({17, 5}).node, "");
  EXPECT_EQ(ended.at({17, 4}).state, "TIMEOUT");
  const auto job = server::parse_scontrol_job(
      "JobId=5 ArrayJobId=1 ArrayTaskId=3 JobName=JobState=X JobState=NODE_FAIL Reason=NodeDown ReqNodeList=(null) "
      "NodeList=n2 X=1");
  ASSERT_TRUE(job);
  EXPECT_EQ(job->state, "NODE_FAIL");
  EXPECT_EQ(job->node, "n2");
  EXPECT_FALSE(server::parse_scontrol_job("slurm_load_jobs error: Invalid job id specified"));
}

}  // namespace
}  // namespace subpixel::tests
