#include "replay/frame_view.hpp"

#include <cstring>

#include "replay/frame/run_frame.hpp"
#include "replay/frontend/pixel_fragments.hpp"
#include "replay/frontend/visibility.hpp"
#include "replay/gpu/litmus.hpp"
#include "replay/single_frame.hpp"
#include "replay/techniques/complete_technique.hpp"

namespace subpixel::replay {
namespace {

// The draw at each pixel's centre, after alpha tests.
std::vector<std::uint32_t> draws_seen(FrameScene& scene) {
  scene.prepare(1);
  const FrontendFrame frame = scene.frontend_frame(AlphaDecision::test);
  gpu::PassRecorder recorder(scene.frontend.device());
  frame.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, frame);
  recorder.run();
  const std::vector<std::byte> bytes = gpu::download(scene.frontend.device(), visibility);
  std::vector<glm::uvec4> texels(bytes.size() / sizeof(glm::uvec4));
  std::memcpy(texels.data(), bytes.data(), bytes.size());
  const auto records = scene.frontend.records().as<gpu_types::TriangleRecord>();
  std::vector<std::uint32_t> draws;
  draws.reserve(texels.size());
  for (const glm::uvec4& texel : texels) {  // depth, then the triangle's record
    if (texel.y == SUBPIXEL_NO_TRIANGLE) {
      draws.push_back(kNoDraw);
      continue;
    }
    const glm::uvec4 id = records[texel.y].hull2_id;
    draws.push_back(triangle_source(scene.scene, id.z, id.w).draw);
  }
  return draws;
}

}  // namespace

FrameView view_frame(const FrameViewJob& job, const std::string& device_name) {
  capture::Capture capture = load_frame(job.capture, job.frame);
  gpu::DeviceOptions options;
  options.device = device_name;
  gpu::Device device(options);
  const FrameChoice choice = choose_size(capture, job.frame, job.width, job.height, device.info().max_image_dimension);
  FrameScene scene(device, std::move(capture), {}, choice);
  FrameView view;
  view.device = device.info().device;
  view.picture = run_frame(scene, complete_technique({"noaa", {}}, 1)).display;
  view.draws = draws_seen(scene);
  return view;
}

std::vector<std::uint32_t> runs_of(const std::vector<std::uint32_t>& values) {
  std::vector<std::uint32_t> runs;
  for (const std::uint32_t value : values) {
    if (runs.empty() || runs[runs.size() - 2] != value) runs.insert(runs.end(), {value, 0});
    ++runs.back();
  }
  return runs;
}

}  // namespace subpixel::replay
