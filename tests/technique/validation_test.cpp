// Every technique and the reference under the Khronos validation layer, its checks of synchronization included.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "replay/frame/run_frame.hpp"
#include "replay/gpu/litmus.hpp"
#include "replay/reference/reference.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"
#include "tests/technique/rich_scene.hpp"
#include "tests/technique/validation_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 36;

// The values of a parameter that take other shaders, formats or passes than the default; at most three.
std::vector<nlohmann::json> values_of(const Parameter& parameter) {
  std::vector<nlohmann::json> values{parameter.default_value};
  switch (parameter.kind) {
    case ParameterKind::choice:
      values.assign(parameter.choices.begin(), parameter.choices.end());
      break;
    case ParameterKind::boolean:
      values = {true, false};
      break;
    case ParameterKind::integer:
      if (parameter.allowed.empty())
        values.emplace_back(parameter.minimum);
      else
        values.assign(parameter.allowed.begin(), parameter.allowed.end());
      break;
    case ParameterKind::number:
      break;
  }
  constexpr std::size_t kMost = 3;
  if (values.size() > kMost) values.erase(values.begin() + 2, values.end() - 1);
  return values;
}

// Runs that together take each of those values: run k takes the k-th of every parameter.
std::vector<ParameterValues> runs_of(const Technique& technique) {
  std::size_t count = 1;
  for (const Parameter& parameter : technique.parameters) count = std::max(count, values_of(parameter).size());
  std::vector<ParameterValues> runs(count);
  for (std::size_t k = 0; k < count; ++k)
    for (const Parameter& parameter : technique.parameters) {
      const auto values = values_of(parameter);
      runs[k][std::string(parameter.name)] = values[k % values.size()];
    }
  return runs;
}

capture::Capture two_frames(capture::Capture capture) {
  capture.frames.push_back(capture.frames[0]);
  return capture;
}

TEST_F(Validation, EveryTechniqueAndTheReference) {
  // Alpha test, emission and the sun; the second scene has everything else as well.
  const capture::Capture capture = capture::generate("quads", {2, kWidth, kHeight, 1, 1});
  const auto said = messages([&](gpu::Device& device, std::vector<std::string>& so_far) {
    const auto expect_silence = [&](std::string_view what) {
      for (const auto& message : so_far) ADD_FAILURE() << what << ": " << message;
      so_far.clear();
    };
    gpu::require_ordered_access(device);
    expect_silence("litmus");
    const capture::Capture inputs = two_frames(rich_scene(UvSource::mixed));
    FrameScene plain(device, capture, {.shadow_map_size = 256}, {0, kWidth, kHeight}),
        rich(device, inputs, {.point_lights = 4, .shadow_map_size = 256, .forced_features = kAllFeatures},
             {0, kWidth, kHeight});
    std::uint32_t frame = 0;
    expect_silence("scene");
    Frontend on_device(device, rich.scene, SetupPlace::device);
    on_device.prepare(8);
    gpu::PassRecorder set_up(device);
    on_device.record_setup(set_up);
    set_up.run();
    expect_silence("set-up by the device");
    for (const Technique* technique : techniques()) {
      std::size_t k = 0;
      for (const ParameterValues& given : runs_of(*technique)) {
        FrameScene& scene = k++ % 2 == 0 ? rich : plain;
        scene.set_frame({frame++ % 2, kWidth, kHeight});
        run_frame(scene, technique->with(given), 1);  // once more: what the first run left is used again
        expect_silence(std::string(technique->name) + " " + nlohmann::json(given).dump());
      }
    }
    for (FrameScene* scene : {&plain, &rich})
      for (const bool tone_map : {false, true}) {
        ReferenceOptions options;
        options.samples = 8;
        options.shading_model = tone_map ? 1 : 0;
        options.tone_map_samples = tone_map;
        render_reference(device, scene->scene, options);
        expect_silence("reference");
      }
  });
  for (const auto& message : said) ADD_FAILURE() << "at the end: " << message;
}

// What such a device has not is not used: a shader that needed it would be named.
TEST_F(Validation, DevicesWithoutWhatOnlySomePassesNeed) {
  const capture::Capture capture = capture::generate("quads", {1, kWidth, kHeight, 1, 1});
  std::size_t refused = 0;
  const auto run = [&](gpu::Device& device, std::vector<std::string>&) {
    gpu::require_ordered_access(device);
    FrameScene scene(device, capture, {.shadow_map_size = 256}, {0, kWidth, kHeight});
    for (const Technique* technique : techniques()) {
      try {
        run_frame(scene, technique->with());
      } catch (const DeviceError&) {  // by name (DeviceNeeds)
        ++refused;
      }
    }
    render_reference(device, scene.scene, {.samples = 8});
  };
  const std::vector<std::string> without{gpu::kOrderedAttachments, gpu::kPixelInterlock,    gpu::kDoubles,
                                         gpu::kFragmentStores,     gpu::kFragmentSubgroups, gpu::kEightAttachments};
  for (const auto& message : messages(run, {.without = {without.begin() + 2, without.end()}})) ADD_FAILURE() << message;
  EXPECT_EQ(refused, 3U);
  // Then visibility has no way.
  refused = 0;
  for (const auto& message : messages(run, {.without = without})) ADD_FAILURE() << message;
  EXPECT_GT(refused, 3U);
}

}  // namespace
}  // namespace subpixel::replay
