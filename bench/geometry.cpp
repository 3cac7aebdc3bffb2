// Set-up and the 8x visibility pass over the driver's own 4x depth-only pass, on the grass field or a given capture.
// Ratios within one run: absolute times are this machine's, this minute's.
#include <fmt/format.h>

#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>

#include "capture_format/reading/reader.hpp"
#include "replay/frontend/visibility.hpp"
#include "replay/measure/percentiles.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::replay {
namespace {

struct Cost {
  double wall_ms = 0, cpu_ms = 0;
};

double processor_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e3 * static_cast<double>(usage.ru_utime.tv_sec) + 1e-3 * static_cast<double>(usage.ru_utime.tv_usec);
}

// Warm medians. Processor time of all threads says more than the wall clock when the machine is shared.
Cost measure(gpu::PassRecorder& recorder, int repeats) {
  recorder.run();
  recorder.clear_timings();
  std::vector<double> cpu;
  for (int i = 0; i < repeats; ++i) {
    const double before = processor_ms();
    recorder.run();
    cpu.push_back(processor_ms() - before);
  }
  Cost cost{0, median(cpu)};
  for (const auto& timing : recorder.timings()) {
    cost.wall_ms += median(timing.ms);
    fmt::print("{:20} {:8.2f} ms\n", timing.name, median(timing.ms));
  }
  fmt::print("{:20} {:8.2f} ms of processor time\n", "", cost.cpu_ms);
  return cost;
}

// Draws the scene with lavapipe's rasteriser into a 4x depth image, from the same buffers.
void record_driver_depth(gpu::PassRecorder& recorder, GpuScene& scene, Frontend& frontend, std::uint32_t width,
                         std::uint32_t height, VkSampleCountFlagBits samples) {
  gpu::Image& depth = recorder.image({"depth", VK_FORMAT_D32_SFLOAT, width, height, 1, 1, samples,
                                      VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, false});
  gpu::RasterPass pass;
  pass.name = fmt::format("driver {}x depth", static_cast<int>(samples));
  pass.pipeline.vertex = "tests/plain.vert";
  pass.pipeline.constants = frontend.constants();
  pass.pipeline.targets.samples = samples;
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_GREATER;
  pass.pipeline.depth_write = true;
  pass.depth = &depth;
  pass.bindings = {gpu::uniform(scene.frame_constants)};
  pass.indices_and_indirect = {&scene.indices};
  pass.push = gpu::PushConstants(frontend.hull_push(pass, 0));
  pass.draws = [&scene](gpu::DrawEncoder& encoder) {
    encoder.index_buffer(scene.indices);
    for (const DrawItem& draw : scene.draws())
      encoder.draw_indexed(3 * draw.triangle_count, draw.instance_count, draw.first_index, draw.first_instance);
  };
  recorder.raster(std::move(pass));
}

int run(int argc, char** argv) {
  const capture::Capture capture = argc > 1 && std::string(argv[1]) != "-"
                                       ? capture::read_capture(argv[1])
                                       : capture::generate("grass", {1, 1280, 720, 1, 1.0});
  gpu::Device device;
  GpuScene scene(device, capture, {});
  scene.set_frame(0, 1280, 720);
  Frontend frontend(device, scene);
  frontend.prepare(8);
  fmt::print("{}; {}\n{} triangles, {} hulls, {} clipped\n", device.info().driver_version, device.info().cpu_model,
             scene.triangle_count(), frontend.hull_count(), frontend.clipped_count());
  FrontendFrame frame{frontend, 1280, 720};
  frame.small = choose_small_triangles(frame);
  gpu::PassRecorder ours(device), driver(device), driver1(device);
  frontend.record_setup(ours);
  record_visibility(ours, frame);
  record_driver_depth(driver, scene, frontend, 1280, 720, VK_SAMPLE_COUNT_4_BIT);
  record_driver_depth(driver1, scene, frontend, 1280, 720, VK_SAMPLE_COUNT_1_BIT);
  const int repeats = argc > 2 ? std::atoi(argv[2]) : 9;
  const Cost a = measure(ours, repeats), b = measure(driver, repeats), c = measure(driver1, repeats);
  fmt::print("set-up + 8x visibility over driver 4x depth: {:.3f}, in processor time {:.3f}\n", a.wall_ms / b.wall_ms,
             a.cpu_ms / b.cpu_ms);
  fmt::print("driver 1x over 4x: {:.3f} (wall)\n", c.wall_ms / b.wall_ms);
  return 0;
}

}  // namespace
}  // namespace subpixel::replay

int main(int argc, char** argv) {
  return subpixel::replay::run(argc, argv);
}
