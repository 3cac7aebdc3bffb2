// A device without what only some passes need: the others leave the same bits without it, those refuse it in words.
#include "replay/gpu/litmus.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

gpu::Device& bare_device() {
  static gpu::Device device({.without = {gpu::kOrderedAttachments, gpu::kPixelInterlock}});
  return device;
}

void expect_refused_there(std::string_view technique, const ParameterValues& given, const std::string& words) {
  try {
    run_technique(little_grass(), technique, given, 61, 37, bare_device());
    FAIL() << technique << " " << nlohmann::json(given).dump();
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(DeviceNeeds, AreLeftOut) {
  EXPECT_TRUE(test_device().info().ordered_attachments);
  EXPECT_FALSE(bare_device().info().ordered_attachments);
  EXPECT_FALSE(bare_device().info().pixel_interlock);
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
  expect_refused_there("streaming", {{"order", "one_pass"}}, "only lists");
  expect_refused_there("dcaa", {{"order", "one_pass"}}, gpu::kOrderedAttachments);
  expect_refused_there("hybrid", {{"order", "one_pass"}}, gpu::kOrderedAttachments);
  expect_refused_there("msaa", {{"prepass", false}}, gpu::kOrderedAttachments);
}

}  // namespace
}  // namespace subpixel::replay
