// Set-up and the 8x visibility pass over the driver's own 4x depth-only pass, on the grass field or a given capture.
// Ratios within one run: absolute times are this machine's, this minute's.
#include <fmt/format.h>

#include <algorithm>

#include "capture_format/generate/generate.hpp"
#include "capture_format/reader.hpp"
#include "replay/frontend/visibility.hpp"

namespace subpixel::replay {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Draws the scene with lavapipe's rasteriser into a 4x depth image, from the same buffers.
void record_driver_depth(gpu::PassRecorder& recorder, GpuScene& scene, gpu::Buffer& clip_matrices, std::uint32_t width,
                         std::uint32_t height, VkSampleCountFlagBits samples) {
  gpu::Image& depth = recorder.image({"depth", VK_FORMAT_D32_SFLOAT, width, height, 1, 1, samples,
                                      VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, false});
  gpu::RasterPass pass;
  pass.name = fmt::format("driver {}x depth", static_cast<int>(samples));
  pass.pipeline.vertex = "bench/plain.vert";
  pass.pipeline.targets.depth = VK_FORMAT_D32_SFLOAT;
  pass.pipeline.targets.samples = samples;
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_GREATER;
  pass.pipeline.depth_write = true;
  pass.depth = &depth;
  pass.bindings = {gpu::uniform(scene.frame_constants)};
  pass.indices_and_indirect = {&scene.indices};
  HullPush push{};
  push.positions = scene.positions.address();
  push.clip_matrices = clip_matrices.address();
  pass.push = gpu::PushConstants(push);
  pass.draws = [&scene](gpu::DrawEncoder& encoder) {
    encoder.index_buffer(scene.indices);
    for (const DrawItem& draw : scene.draws())
      encoder.draw_indexed(3 * draw.triangle_count, draw.instance_count, draw.first_index, draw.first_instance);
  };
  recorder.raster(std::move(pass));
}

int run(int argc, char** argv) {
  const capture::Capture capture = argc > 1 ? capture::read_capture(argv[1]) : capture::generate("grass", {1, 1280, 720, 1, 1.0});
  gpu::Device device;
  GpuScene scene(device, capture, {});
  scene.set_frame(0, 1280, 720);
  Frontend frontend(device, scene);
  frontend.prepare(8);
  fmt::print("{}; {}\n{} triangles, {} hulls, {} clipped\n", device.info().driver_version, device.info().cpu_model,
             scene.triangle_count(), frontend.hull_count(), frontend.clipped_count());
  const ParameterValues parameters{{"alpha", "to_coverage"}, {"resolve", "linear"}, {"shading", "ggx"}};
  FrameOutputs outputs;
  const FrameSetup setup{scene, frontend, 1280, 720, 8, parameters, outputs};
  gpu::PassRecorder recorder(device);
  frontend.record_setup(recorder);
  record_visibility(recorder, setup);
  record_driver_depth(recorder, scene, frontend.clip_matrices(), 1280, 720, VK_SAMPLE_COUNT_4_BIT);
  record_driver_depth(recorder, scene, frontend.clip_matrices(), 1280, 720, VK_SAMPLE_COUNT_1_BIT);
  recorder.run();
  recorder.clear_timings();
  for (int i = 0; i < 9; ++i) recorder.run();
  double ours = 0, driver = 0;
  for (const auto& timing : recorder.timings()) {
    const double ms = median(timing.ms);
    fmt::print("{:20} {:8.2f} ms\n", timing.name, ms);
    if (timing.name == "setup" || timing.name == "visibility") ours += ms;
    if (timing.name == "driver 4x depth") driver = ms;
  }
  fmt::print("set-up + 8x visibility over driver 4x depth: {:.3f}\n", ours / driver);
  return 0;
}

}  // namespace
}  // namespace subpixel::replay

int main(int argc, char** argv) { return subpixel::replay::run(argc, argv); }
