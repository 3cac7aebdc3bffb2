// What a reference costs and how far it is from its limit: 4096 samples, each of them shaded.
// Usage: subpixel_bench_reference CAPTURE [WIDTH HEIGHT [IMAGE.exr...]]   (default: 640x360)
// Images are linear ones of the same frame and size with 32 lights, as `subpixel replay --lights 32 --out` writes
// references, to be held against the limit, too.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "capture_format/reading/reader.hpp"
#include "replay/measure/image_file.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference.hpp"

namespace subpixel::replay {
namespace {

double processor_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

// Root of the mean over pixels and channels of (test - truth)^2 / (truth^2 + 0.01).
double relative_rms(const Image& truth, const Image& test) {
  return std::sqrt(hdr_relative_mse(truth, test));
}

int run(const std::string& path, std::uint32_t width, std::uint32_t height, const std::vector<std::string>& images) {
  const capture::Capture capture = capture::read_capture(path);
  gpu::Device device;
  GpuScene scene(device, capture, {.point_lights = 32});
  scene.set_frame(0, width, height);
  const auto render = [&](std::uint32_t samples, bool all) {
    return render_reference(device, scene, {.samples = samples, .shade_all_samples = all}).linear;
  };
  const Image truth = render(4096, true);
  fmt::print("{:>7} {:>12} {:>14} {:>12} {:>14}\n", "samples", "error", "processor s", "all shaded", "processor s");
  for (const std::uint32_t samples : {32u, 64u, 128u, 256u, 512u, 1024u}) {
    double error[2], seconds[2];
    for (const bool all : {false, true}) {
      const double before = processor_s();
      const Image image = render(samples, all);
      seconds[all] = processor_s() - before;
      error[all] = relative_rms(truth, image);
    }
    fmt::print("{:>7} {:>12.6f} {:>14.2f} {:>12.6f} {:>14.2f}\n", samples, error[0], seconds[0], error[1], seconds[1]);
  }
  for (const std::string& image : images) fmt::print("{:.6f} {}\n", relative_rms(truth, read_image(image)), image);
  return 0;
}

}  // namespace
}  // namespace subpixel::replay

int main(int argc, char** argv) {
  if (argc < 2 || argc == 3) {
    fmt::print(stderr, "usage: subpixel_bench_reference CAPTURE [WIDTH HEIGHT [IMAGE.exr...]]\n");
    return 2;
  }
  const auto side = [&](int at, std::uint32_t otherwise) {
    return argc > at ? static_cast<std::uint32_t>(std::strtoul(argv[at], nullptr, 10)) : otherwise;
  };
  try {
    return subpixel::replay::run(argv[1], side(2, 640), side(3, 360), {argv + std::min(argc, 4), argv + argc});
  } catch (const subpixel::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
