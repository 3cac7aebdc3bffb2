// A device without what only some passes need: the others leave the same bits without it, those refuse it in words.
#include <map>
#include <memory>
#include <set>

#include "replay/gpu/litmus.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

// Beside the order of attachments and the interlock, which have tests of their own.
const std::vector<std::string> kInPart{gpu::kDoubles, gpu::kFragmentStores, gpu::kFragmentSubgroups,
                                       gpu::kEightAttachments};

// A device without one of them.
gpu::Device& device_without(const std::string& need) {
  static std::map<std::string, std::unique_ptr<gpu::Device>> devices;
  auto& device = devices[need];
  if (!device) device = std::make_unique<gpu::Device>(gpu::DeviceOptions{.without = {need}});
  return *device;
}

// Without any order of fragments.
gpu::Device& bare_device() {
  static gpu::Device device({.without = {gpu::kOrderedAttachments, gpu::kPixelInterlock}});
  return device;
}

void expect_refused_on(gpu::Device& device, std::string_view technique, const ParameterValues& given,
                       const std::string& words) {
  try {
    run_technique(little_grass(), technique, given, 61, 37, device);
    FAIL() << technique << " " << nlohmann::json(given).dump();
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(DeviceNeeds, AreLeftOut) {
  EXPECT_TRUE(test_device().info().ordered_attachments);
  EXPECT_FALSE(bare_device().info().ordered_attachments);
  EXPECT_FALSE(bare_device().info().pixel_interlock);
  EXPECT_TRUE(test_device().info().doubles);
  EXPECT_FALSE(device_without(gpu::kDoubles).info().doubles);
  EXPECT_TRUE(test_device().info().fragment_stores);
  EXPECT_FALSE(device_without(gpu::kFragmentStores).info().fragment_stores);
  EXPECT_TRUE(test_device().info().fragment_subgroups);
  EXPECT_FALSE(device_without(gpu::kFragmentSubgroups).info().fragment_subgroups);
  EXPECT_TRUE(test_device().info().eight_attachments);
  EXPECT_FALSE(device_without(gpu::kEightAttachments).info().eight_attachments);
  for (const std::string& need : kInPart) EXPECT_NO_THROW(gpu::require_ordered_access(device_without(need))) << need;
  EXPECT_NO_THROW(gpu::require_ordered_access(bare_device()));
}

// Small and large, alpha-tested, clipped and coinciding triangles.
TEST(DeviceNeeds, EveryTechniqueLeavesTheSameBitsWithoutOrderedAttachments) {
  const std::vector<std::pair<std::string, double>> scenes{
      {"grass", 0.01}, {"foliage", 0.02}, {"arcade", 0.05}, {"hard_coplanar", 1}, {"hard_near_plane", 1}};
  for (const auto& [name, density] : scenes) {
    const capture::Capture capture = capture::generate(name, {1, 61, 37, 1, density});
    for (const Technique* technique : techniques()) {
      const TechniqueRun expected = run_technique(capture, technique->name, {}, 61, 37);
      const TechniqueRun run = run_technique(capture, technique->name, {}, 61, 37, bare_device());
      EXPECT_TRUE(expected == run) << name << " " << technique->name;
    }
  }
}

TEST(DeviceNeeds, EveryTechniqueLeavesTheSameBitsOrRefusesEachByName) {
  std::map<std::string, std::set<std::string>> refused;
  for (const auto& [scene, density] : std::vector<std::pair<std::string, double>>{{"grass", 0.01}, {"foliage", 0.02}}) {
    const capture::Capture capture = capture::generate(scene, {1, 61, 37, 1, density});
    for (const Technique* technique : techniques()) {
      const TechniqueRun expected = run_technique(capture, technique->name, {}, 61, 37);
      for (const std::string& need : kInPart) {
        SCOPED_TRACE(testing::Message() << scene << " " << technique->name << " without " << need);
        try {
          EXPECT_TRUE(expected == run_technique(capture, technique->name, {}, 61, 37, device_without(need)));
        } catch (const DeviceError& error) {
          EXPECT_NE(std::string(error.what()).find(need), std::string::npos) << error.what();
          refused[need].emplace(technique->name);
        }
      }
    }
  }
  // Those by lists, which the rasteriser fills for triangles that are not small.
  const std::map<std::string, std::set<std::string>> expected{{gpu::kFragmentStores, {"streaming", "dcaa", "hybrid"}}};
  EXPECT_EQ(refused, expected);
}

TEST(DeviceNeeds, EverySampleCountLeavesTheSameBitsWithoutOrderedAttachments) {
  const capture::Capture capture = capture::generate("foliage", {1, 61, 37, 1, 0.02});
  for (const int samples : {4, 8, 16, 32, 64}) {
    for (const char* alpha : {"to_coverage", "per_sample"}) {
      const ParameterValues given{{"samples", samples}, {"alpha", alpha}};
      EXPECT_TRUE(run_technique(capture, "forward", given, 61, 37) ==
                  run_technique(capture, "forward", given, 61, 37, bare_device()))
          << samples << " " << alpha;
    }
  }
}

TEST(DeviceNeeds, OrderedPassesRefuseADeviceWithoutAnOrder) {
  expect_refused_on(bare_device(), "streaming", {{"order", "one_pass"}}, "only lists");
  expect_refused_on(bare_device(), "dcaa", {{"order", "one_pass"}}, gpu::kOrderedAttachments);
  expect_refused_on(bare_device(), "hybrid", {{"order", "one_pass"}}, gpu::kOrderedAttachments);
  expect_refused_on(bare_device(), "msaa", {{"prepass", false}}, gpu::kOrderedAttachments);
}

}  // namespace
}  // namespace subpixel::replay
