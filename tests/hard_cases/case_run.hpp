// The hard cases on the device: scenes and references made once, any technique on them.
#pragma once

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash.hpp"
#include "capture_format/capture.hpp"
#include "capture_format/writer.hpp"
#include "replay/measure/flip.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference_cache.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"

namespace subpixel::replay {

inline capture::Capture make_case(const capture::HardCase& hard) {
  return hard.make({.frames = 1, .width = hard.width, .height = hard.height});
}

struct CaseResult {
  Image radiance, display;              // three channels
  std::vector<float> executions;        // of each pixel
  std::uint32_t samples = 0;            // visibility samples
  std::vector<std::string> pass_names;  // in execution order, each once
  std::uint64_t allocated_bytes = 0;
  double paper_bytes_per_pixel = 0, fitted_bytes_per_pixel = 0;
};

// One frame of a capture, ready for any number of techniques.
class CaseScene {
 public:
  explicit CaseScene(gpu::Device& device, capture::Capture made, const SceneOptions& options = {})
      : capture(std::move(made)), scene(device, capture, options), device_(device), frontend_(device, scene) {
    width = capture.frames[0].width;
    height = capture.frames[0].height;
    scene.set_frame(0, width, height);
  }

  CaseResult run(const Technique& technique, const ParameterValues& given = {}) {
    const TechniqueSetting setting = technique.with(given);
    CaseResult result;
    result.samples = setting.parameters->samples;
    if (prepared_ != result.samples) frontend_.prepare(result.samples);
    prepared_ = result.samples;
    FrameOutputs outputs;
    FrameSetup setup{scene, frontend_, width, height, *setting.parameters, outputs};
    gpu::PassRecorder recorder(device_);
    technique.record(recorder, setup);
    recorder.run();
    result.radiance = colour(*outputs.radiance, Encoding::linear, &result.executions);
    result.display = colour(*outputs.display, Encoding::display, nullptr);
    for (const auto& timing : recorder.timings()) result.pass_names.push_back(timing.name);
    result.allocated_bytes = recorder.allocated_bytes();
    const MemoryLayout layout = technique.layout(setup);
    for (const auto& entry : layout.paper) result.paper_bytes_per_pixel += entry.bits_per_pixel / 8;
    for (const auto& entry : layout.fitted) result.fitted_bytes_per_pixel += entry.bits_per_pixel / 8;
    return result;
  }

  ReferenceImage reference(std::uint32_t samples, const std::filesystem::path& folder) {
    const std::string hash = content_hash_hex(capture::encode_capture(capture, {.zstd_level = 0}));
    return cached_reference(device_, scene, hash, 0, {.samples = samples}, ReferenceCache(folder)).image;
  }

  const capture::Capture capture;  // the scene refers to it
  GpuScene scene;
  std::uint32_t width = 0, height = 0;

 private:
  Image colour(gpu::Image& image, Encoding encoding, std::vector<float>* alpha) {
    const auto bytes = gpu::download(device_, image);
    std::vector<float> texels(bytes.size() / sizeof(float));
    std::memcpy(texels.data(), bytes.data(), bytes.size());
    Image result(width, height, 3, encoding);
    if (alpha) alpha->resize(texels.size() / 4);
    for (std::size_t i = 0; i < texels.size() / 4; ++i) {
      std::copy_n(&texels[4 * i], 3, &result.pixels[3 * i]);
      if (alpha) (*alpha)[i] = texels[4 * i + 3];
    }
    return result;
  }

  gpu::Device& device_;
  Frontend frontend_;
  std::uint32_t prepared_ = 0;
};

}  // namespace subpixel::replay
