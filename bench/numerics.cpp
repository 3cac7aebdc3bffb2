// The measured tables of docs/numerics.md, as Markdown.
//   subpixel_numerics cases      error of every technique on every hard case, and what breaks
//   subpixel_numerics features   bytes and time that specialised shaders and layouts save on each scene
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "capture_format/error.hpp"
#include "capture_format/generate/generate.hpp"
#include "tests/hard_cases/bounds.hpp"
#include "tests/hard_cases/case_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kReferenceSamples = 256;

void print_cases() {
  gpu::Device device;
  const auto folder = std::filesystem::temp_directory_path() / "subpixel_numerics_references";
  const ErrorBounds bounds;
  fmt::print("| case |");
  for (const Technique* technique : techniques()) fmt::print(" {} |", technique->name);
  fmt::print("\n| --- |");
  for (std::size_t i = 0; i < techniques().size(); ++i) fmt::print(" --- |");
  fmt::print("\n");
  std::string breaks;
  for (const capture::HardCase& hard : capture::hard_cases()) {
    CaseScene scene(device, make_case(hard));
    const Image reference = scene.reference(kReferenceSamples, folder).display;
    const double brute = mse(reference, scene.run(find_technique("msaa")).display);
    fmt::print("| `{}` |", hard.name);
    for (const Technique* technique : techniques()) {
      const double error = mse(reference, scene.run(*technique).display);
      // In 1e-4, as the papers have it; bold: more than twice what 8 shaded samples leave.
      const std::string text = fmt::format("{:.{}f}", error * 1e4, error < 1e-3 ? 2 : 0);
      fmt::print(" {} |", error > 2 * brute + 1e-6 ? "**" + text + "**" : text);
      const ErrorBound bound = bounds.of(hard.name, technique->name);
      if (error > 2 * brute + 1e-6 && technique->name != "noaa" && technique->name != "fxaa")
        breaks += fmt::format("| `{}` | `{}` | {:.1f} | {} |\n", hard.name, technique->name,
                              error / std::max(brute, 1e-7), bound.why);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("\n| case | technique | MSE over msaa's | why |\n| --- | --- | --- | --- |\n{}", breaks);
}

struct Cost {
  double ms = 0;
  std::uint64_t bytes = 0;
  double fitted = 0;
};

Cost cost_of(gpu::Device& device, CaseScene& scene, Frontend& frontend, const Technique& technique) {
  constexpr int kRepeats = 5;
  const ParameterValues parameters = check_parameters(technique.name, technique.parameters, {});
  const auto samples = parameters.at("samples").get<std::uint32_t>();
  frontend.prepare(samples);
  FrameOutputs outputs;
  FrameSetup setup{scene.scene, frontend, scene.width, scene.height, samples, parameters, outputs};
  gpu::PassRecorder recorder(device);
  technique.record(recorder, setup);
  recorder.run();
  recorder.clear_timings();
  for (int i = 0; i < kRepeats; ++i) recorder.run();
  Cost cost;
  for (const auto& timing : recorder.timings()) {
    std::vector<double> ms = timing.ms;
    std::nth_element(ms.begin(), ms.begin() + kRepeats / 2, ms.end());
    cost.ms += ms[kRepeats / 2];
  }
  cost.bytes = recorder.allocated_bytes();
  for (const auto& entry : technique.layout(setup).fitted) cost.fitted += entry.bits_per_pixel / 8;
  return cost;
}

void print_features() {
  fmt::print(
      "| scene | features it needs | scene MB, general | saved | technique | ms, general | saved | bytes/pixel, "
      "general | saved |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  gpu::Device device;
  for (const char* name : {"cube", "spheres", "grass", "city", "tubes", "bamboo", "foliage", "arcade"}) {
    const capture::Capture capture = capture::generate(name, {.frames = 1, .width = 320, .height = 180});
    CaseScene fitted(device, capture), general(device, capture, {.forced_features = kAllFeatures});
    Frontend fitted_frontend(device, fitted.scene), general_frontend(device, general.scene);
    for (const char* technique : {"msaa", "streaming"}) {
      const Cost with = cost_of(device, general, general_frontend, find_technique(technique));
      const Cost without = cost_of(device, fitted, fitted_frontend, find_technique(technique));
      const auto saved = [](double more, double less) { return fmt::format("{:.0f}%", 100 * (1 - less / more)); };
      std::string features;
      for (const std::string& feature : fitted.scene.features().names())
        features += (features.empty() ? "" : ", ") + feature;
      fmt::print("| {} | {} | {:.1f} | {} | {} | {:.1f} | {} | {:.0f} | {} |\n", name, features,
                 static_cast<double>(general.scene.bytes()) * 1e-6,
                 saved(static_cast<double>(general.scene.bytes()), static_cast<double>(fitted.scene.bytes())),
                 technique, with.ms, saved(with.ms, without.ms), with.fitted, saved(with.fitted, without.fitted));
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace subpixel::replay

int main(int argc, char** argv) {
  const std::string what = argc == 2 ? argv[1] : "";
  if (what == "cases") {
    subpixel::replay::print_cases();
  } else if (what == "features") {
    subpixel::replay::print_features();
  } else {
    fmt::print(stderr, "usage: subpixel_numerics cases|features\n");
    return 2;
  }
  return 0;
}
