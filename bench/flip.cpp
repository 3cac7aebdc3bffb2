// FLIP of a captured frame's images over the frame of `noaa` that made one of them, at 1280x720.
// Usage: subpixel_bench_flip CAPTURE
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>

#include "replay/measure/flip.hpp"
#include "replay/measure/image_file.hpp"
#include "replay/measure/percentiles.hpp"
#include "replay/replay.hpp"

namespace subpixel::replay {
namespace {

double median_ms(const std::function<void()>& work) {
  std::vector<double> ms;
  for (int i = 0; i < 5; ++i) {
    const auto before = std::chrono::steady_clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count());
  }
  return median(std::move(ms));
}

int run(const std::filesystem::path& capture) {
  const auto folder = std::filesystem::temp_directory_path() / "subpixel_bench_flip";
  ReplayJob job;
  job.capture = capture;
  job.out_dir = folder;
  job.cache_dir = folder / "cache";
  job.options.techniques = {{"noaa", {}}, {"msaa", {}}};
  job.options.width = 1280;
  job.options.height = 720;
  job.options.frames = {{0, 0}};
  job.options.reference_samples = 0;
  job.options.repeat = 5;
  job.options.point_lights = 32;  // as in every other comparison of times
  const Results results = run_replay(job, {});
  std::vector<Image> display, linear;
  for (const FrameResult& result : results.results) {
    display.push_back(read_image(folder / result.images.at("image")));
    linear.push_back(read_image(folder / result.images.at("hdr")));
  }
  const double frame = results.results[0].ms.total_ms;
  double mean = 0, hdr_mean = 0;
  const double ldr = median_ms([&] { mean = flip(display[1], display[0]).mean; });
  const double hdr = median_ms([&] { hdr_mean = hdr_flip(linear[1], linear[0]).error.mean; });
  std::filesystem::remove_all(folder);
  fmt::print("over a frame of noaa: FLIP {:.2f} (mean {:.4f}), HDR-FLIP {:.2f} (mean {:.4f})\n", ldr / frame, mean,
             hdr / frame, hdr_mean);
  return 0;
}

}  // namespace
}  // namespace subpixel::replay

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: subpixel_bench_flip CAPTURE\n");
    return 2;
  }
  return subpixel::replay::run(argv[1]);
}
