// The measured tables of docs/numerics.md, as Markdown.
//   subpixel_numerics cases      error of every technique on every hard case, and what breaks
//   subpixel_numerics features   bytes and time that specialised shaders and layouts save on each scene
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "replay/frame/run_frame.hpp"
#include "replay/measure/error_bounds.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/measure/percentiles.hpp"
#include "replay/reference/reference_cache.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/import/import.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kReferenceSamples = 256;

void print_cases() {
  gpu::Device device;
  const auto folder = std::filesystem::temp_directory_path() / "subpixel_numerics_references";
  const ErrorBounds bounds(SUBPIXEL_SOURCE_DIR "/tests/hard_cases/bounds.json");
  fmt::print("| case |");
  for (const Technique* technique : techniques()) fmt::print(" {} |", technique->name);
  fmt::print("\n| --- |");
  for (std::size_t i = 0; i < techniques().size(); ++i) fmt::print(" --- |");
  fmt::print("\n");
  std::string breaks;
  for (const capture::HardCase& hard : capture::hard_cases()) {
    FrameScene scene(device, capture::make_case(hard));
    const Image reference =
        cached_reference(device, scene.scene, 0, {.samples = kReferenceSamples}, ReferenceCache(folder)).image.display;
    const double brute = mse(reference, run_frame(scene, find_technique("msaa").with()).display);
    fmt::print("| `{}` |", hard.name);
    for (const Technique* technique : techniques()) {
      const double error = mse(reference, run_frame(scene, technique->with()).display);
      // In 1e-4, as the papers have it; bold: more than twice what 8 shaded samples leave.
      const std::string text = fmt::format("{:.{}f}", error * 1e4, error < 1e-3 ? 2 : 0);
      fmt::print(" {} |", error > 2 * brute + 1e-6 ? "**" + text + "**" : text);
      const ErrorBound bound = bounds.of(hard.name, technique->name);
      if (error > 2 * brute + 1e-6 && technique->with().parameters->samples > 1)
        breaks += fmt::format("| `{}` | `{}` | {:.1f} | {} |\n", hard.name, technique->name,
                              error / std::max(brute, 1e-7), bound.why);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("\n| case | technique | MSE over msaa's | why |\n| --- | --- | --- | --- |\n{}", breaks);
}

// "12.3 | 40%": the general form's, and how much less the fitted one has.
std::string saving(double general, double fitted) {
  return fmt::format("{:.1f} | {:.0f}%", general, 100 * (1 - fitted / general));
}

// General and fitted run in turns, so that what else the machine does falls on both; the brackets have the savings of
// pairs of runs, without the smallest and the largest.
std::string time_saving(RecordedFrame& general, RecordedFrame& fitted) {
  constexpr int kRepeats = 7;
  general.run();
  fitted.run();
  std::vector<double> general_ms, fitted_ms, saved;
  for (int i = 0; i < kRepeats; ++i) {
    general_ms.push_back(general.run());
    fitted_ms.push_back(fitted.run());
    saved.push_back(100 * (1 - fitted_ms.back() / general_ms.back()));
  }
  std::ranges::sort(saved);
  return fmt::format("{} ({:.0f} to {:.0f})", saving(median(general_ms), median(fitted_ms)), saved[1],
                     saved[kRepeats - 2]);
}

void print_features_of(gpu::Device& device, const std::string& name, const capture::Capture& capture) {
  FrameScene fitted(device, capture), general(device, capture, {.forced_features = kAllFeatures});
  std::string features;
  for (const std::string& feature : fitted.scene.features().names())
    features += (features.empty() ? "" : ", ") + feature;
  std::string scene_cells = fmt::format(
      "{} | {} | {}", name, features,
      saving(static_cast<double>(general.scene.bytes()) * 1e-6, static_cast<double>(fitted.scene.bytes()) * 1e-6));
  for (const char* technique : {"msaa", "streaming"}) {
    const TechniqueSetting setting = find_technique(technique).with();
    RecordedFrame with(general, setting), without(fitted, setting);
    const Memory general_memory = with.memory(), fitted_memory = without.memory();
    const auto megabytes = [](const Memory& memory) { return static_cast<double>(memory.allocated_bytes) * 1e-6; };
    fmt::print("| {} | `{}` | {} | {} | {} |\n", scene_cells, technique,
               saving(general_memory.fitted_bytes_per_pixel, fitted_memory.fitted_bytes_per_pixel),
               saving(megabytes(general_memory), megabytes(fitted_memory)), time_saving(with, without));
    std::fflush(stdout);
    scene_cells = " | | | ";
  }
}

void print_features() {
  fmt::print(
      "| scene | features it needs | scene MB, general | saved | technique | bytes/pixel, general | saved | allocated "
      "MB, general | saved | ms, general | saved |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  gpu::Device device;
  for (const char* name : {"cube", "spheres", "grass", "fur", "tubes", "bamboo", "foliage", "city", "arcade"})
    print_features_of(device, name, capture::generate(name, {.frames = 1, .width = 320, .height = 180}));
  try {
    print_features_of(device, "park",
                      capture::import_file(SUBPIXEL_SOURCE_DIR "/scenes/described/park.json",
                                           {.frames = 1, .width = 320, .height = 180}));
  } catch (const InputError& error) {  // its models come from a package of their own
    fmt::print(stderr, "without the park: {}\n", error.what());
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
