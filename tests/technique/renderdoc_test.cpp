// `replay --capture-frame` under a stand-in for RenderDoc, and without one.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>

#include "replay/gpu/renderdoc.hpp"
#include "tests/technique/run_binary.hpp"
#if __has_include(<renderdoc_app.h>)  // Debian: librenderdoc-dev
#include <renderdoc_app.h>
#endif

namespace subpixel::tests {
namespace {

#ifdef RENDERDOC_CC
using Ours = gpu::RenderDocFunctions;
using Theirs = RENDERDOC_API_1_1_2;
#endif

class CaptureFrame : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-renderdoc-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    ASSERT_EQ(run_binary("generate cube cube.spcap --frames 2 --size 32x24", folder_).code, 0);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Finished replay(const std::string& capture, const std::string& environment) const {
    return run_binary("replay cube.spcap --techniques noaa,msaa:samples=4 --reference-samples 0 --repeat 1 --out out" +
                          (capture.empty() ? "" : " --capture-frame " + capture),
                      folder_, environment);
  }
  std::vector<std::string> log() const {
    std::vector<std::string> lines;
    std::ifstream file(folder_ / "log");
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  void expect_refused(const Finished& finished, int code, const std::string& words) const {
    EXPECT_EQ(finished.code, code) << finished.error;
    EXPECT_NE(finished.error.find(words), std::string::npos) << finished.error;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "results.json"));
  }

  std::filesystem::path folder_;
  const std::string under_ = "LD_PRELOAD='" SUBPIXEL_FAKE_RENDERDOC "' FAKE_RENDERDOC_LOG=log";
};

TEST_F(CaptureFrame, HoldsOneRunOfTheTechniquesPasses) {
  const auto plain = replay("", under_);
  ASSERT_EQ(plain.code, 0) << plain.error;
  const auto all = log();
  EXPECT_EQ(std::ranges::count(all, "start"), 0);
  std::filesystem::remove(folder_ / "log");

  const auto finished = replay("1:msaa", under_);
  ASSERT_EQ(finished.code, 0) << finished.error;
  const auto lines = log();
  const auto start = std::ranges::find(lines, "start");
  const std::string path = (folder_ / "out" / "frame0001_01_msaa_frame7.rdc").string();
  const auto end = std::ranges::find(lines, "end " + path);
  ASSERT_NE(start, lines.end());
  ASSERT_NE(end, lines.end());
  EXPECT_EQ(std::ranges::count(lines, "start"), 1);
  EXPECT_GT(end - start, 2);
  EXPECT_EQ(std::count(start + 1, end, "submit"), end - start - 1);
  // A run more than without, and nothing else is different.
  EXPECT_EQ(std::ranges::count(lines, "submit") - std::ranges::count(all, "submit"), end - start - 1);
  EXPECT_NE(finished.error.find(path), std::string::npos) << finished.error;
}

TEST_F(CaptureFrame, RefusesWhatIsNotReplayed) {
  expect_refused(replay("2:noaa", under_), 2, "frame 2 is not within those replayed, 0-1");
  expect_refused(replay("0:dcaa", under_), 2, "'dcaa' is not one of the techniques replayed, noaa, msaa");
  expect_refused(replay("noaa", under_), 2, "'noaa' is not FRAME:TECHNIQUE");
  expect_refused(replay("x:noaa", under_), 2, "'x:noaa' is not FRAME:TECHNIQUE");
  expect_refused(replay(":noaa", under_), 2, "':noaa' is not FRAME:TECHNIQUE");
  expect_refused(replay("0:", under_), 2, "'0:' is not FRAME:TECHNIQUE");
}

TEST_F(CaptureFrame, WithoutRenderDocIsAUsageError) {
  expect_refused(replay("0:noaa", ""), 2, "does not run under RenderDoc");
}

TEST_F(CaptureFrame, ACaptureThatIsNotMadeIsSaid) {
  expect_refused(replay("0:noaa", under_ + " FAKE_RENDERDOC_FAILS=1"), 4, "RenderDoc made none");
}

#ifdef RENDERDOC_CC
TEST(RenderDocFunctions, AreWhereRenderDocsHeaderHasThem) {
  EXPECT_EQ(offsetof(Ours, set_capture_file_path_template), offsetof(Theirs, SetCaptureFilePathTemplate));
  EXPECT_EQ(offsetof(Ours, get_num_captures), offsetof(Theirs, GetNumCaptures));
  EXPECT_EQ(offsetof(Ours, get_capture), offsetof(Theirs, GetCapture));
  EXPECT_EQ(offsetof(Ours, start_frame_capture), offsetof(Theirs, StartFrameCapture));
  EXPECT_EQ(offsetof(Ours, end_frame_capture), offsetof(Theirs, EndFrameCapture));
}
#endif

}  // namespace
}  // namespace subpixel::tests
