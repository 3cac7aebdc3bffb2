// Which draw each pixel of a frame shows, against the story of single pixels, which finds fragments on the host.
#include <unistd.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture_format/writer.hpp"
#include "replay/frame_view.hpp"
#include "replay/story.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

class FrameViews : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { capture::write_capture(capture::generate(GetParam(), {2, kWidth, kHeight, 1, 0.05}), file_); }
  void TearDown() override { std::filesystem::remove(file_); }

  const std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                      ("subpixel-view-" + std::to_string(::getpid()) + "-" + GetParam() + ".spcap");
};

TEST_P(FrameViews, PixelsShowTheDrawsThatTheirStoriesTell) {
  const FrameView view = view_frame({file_, 1, kWidth, kHeight});
  ASSERT_EQ(view.draws.size(), std::size_t{kWidth} * kHeight);
  EXPECT_EQ(view.picture.width, kWidth);
  EXPECT_EQ(view.picture.height, kHeight);
  int shown = 0;
  for (std::uint32_t y = 3; y < kHeight; y += 17) {
    for (std::uint32_t x = 2; x < kWidth; x += 29) {
      StoryJob job;
      job.capture = file_;
      job.techniques = {{"noaa", {{"alpha", "test"}}}};
      job.frame = 1;
      job.x = x;
      job.y = y;
      job.width = kWidth;
      job.height = kHeight;
      job.reference_samples = 0;
      const nlohmann::json told = tell_pixel(job)["stories"][0];
      const nlohmann::json& fragment = told["pattern"][0]["fragment"];
      const std::uint32_t draw =
          fragment.is_null() ? kNoDraw
                             : told["fragments"][fragment.get<std::size_t>()]["triangle"]["draw"].get<std::uint32_t>();
      EXPECT_EQ(view.draws[std::size_t{y} * kWidth + x], draw) << x << "," << y;
      shown += draw != kNoDraw;
    }
  }
  EXPECT_GT(shown, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, FrameViews, testing::Values("spheres", "grass"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST(RunsOf, CountRepetitions) {
  EXPECT_EQ(runs_of({}), (std::vector<std::uint32_t>{}));
  EXPECT_EQ(runs_of({7, 7, 7, 2, 7}), (std::vector<std::uint32_t>{7, 3, 2, 1, 7, 1}));
}

}  // namespace
}  // namespace subpixel::replay
