// `prepass=false`: full samples stored in submission order, over those that turn out to be hidden. The image is that of
// a depth pass first, to the bit; the map counts what is paid for it.
#include <algorithm>
#include <cstring>
#include <numeric>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

TechniqueRun without_prepass(const capture::Capture& capture, const std::string& technique, ParameterValues given) {
  given["prepass"] = false;
  return run_technique(capture, technique, given, kWidth, kHeight);
}

void expect_same_image(const capture::Capture& capture, const std::string& technique, const ParameterValues& given) {
  const TechniqueRun with = run_technique(capture, technique, given, kWidth, kHeight);
  const TechniqueRun without = without_prepass(capture, technique, given);
  const std::string setting = technique + " " + nlohmann::json(given).dump();
  EXPECT_EQ(std::memcmp(with.radiance.data(), without.radiance.data(), with.radiance.size() * sizeof(glm::vec4)), 0)
      << setting;
  EXPECT_EQ(std::memcmp(with.display.data(), without.display.data(), with.display.size() * sizeof(glm::vec4)), 0)
      << setting;
  if (technique == "simple_complex") {
    EXPECT_EQ(with.maps.at("complex"), without.maps.at("complex")) << setting;
  }
}

TEST(Prepass, WithoutItTheImageIsTheSame) {
  for (const int samples : {4, 8, 16, 32, 64})
    for (const char* technique : {"msaa", "simple_complex"})
      if (samples <= 32 || technique == std::string("msaa"))
        expect_same_image(little_grass(), technique, {{"samples", samples}});
}

TEST(Prepass, WithoutItAlphaAndEqualDepthsAreDecidedAlike) {
  const capture::Capture foliage = capture::generate("foliage", {1, kWidth, kHeight, 1, 0.05});
  for (const char* alpha : {"to_coverage", "test", "per_sample"})
    expect_same_image(foliage, "msaa", {{"alpha", alpha}});
  expect_same_image(foliage, "simple_complex", {});
  for (const char* scene : {"hard_coplanar", "hard_near_plane", "quads"})
    expect_same_image(capture::generate(scene, {1, kWidth, kHeight, 1, 1}), "msaa", {});
}

TEST(Prepass, WithoutItHiddenFragmentsAreStoredToo) {
  for (const int samples : {4, 8, 16}) {
    // `forward` lights every visible fragment once.
    const TechniqueRun forward = run_technique(little_grass(), "forward", {{"samples", samples}}, kWidth, kHeight);
    const auto written = without_prepass(little_grass(), "msaa", {{"samples", samples}}).maps.at("written");
    for (std::size_t i = 0; i < written.size(); ++i)
      ASSERT_GE(static_cast<float>(written[i]), forward.radiance[i].w) << "pixel " << i;
    EXPECT_GT(std::accumulate(written.begin(), written.end(), 0.0), forward.executions());
  }
}

TEST(Prepass, WithoutItTheOrderOfDrawsDecidesWhatIsStored) {
  // One triangle over the screen before another: drawn first or last, the nearer hides the other; only when it comes
  // last has the other been stored before. flat_capture()'s depth grows with z or against it; either way one order
  // pays.
  const auto stored = [](float first, float second) {
    capture::Capture capture = flat_capture(kWidth, kHeight);
    const auto white = add_emitter(capture, {1, 1, 1});
    for (const float z : {first, second}) add_triangles(capture, {-1, -1, z, 3, -1, z, -1, 3, z}, white);
    const auto written = without_prepass(capture, "msaa", {}).maps.at("written");
    for (const std::uint32_t count : written) EXPECT_EQ(count, written[0]);
    return written[0];
  };
  EXPECT_EQ(std::min(stored(0.2f, 0.8f), stored(0.8f, 0.2f)), 1u);
  EXPECT_EQ(std::max(stored(0.2f, 0.8f), stored(0.8f, 0.2f)), 2u);
}

TEST(Prepass, WithoutItTheBitsAreThoseOfAnyNumberOfThreads) {
  expect_same_on_all_threads("msaa", {{"prepass", false}});
  expect_same_on_all_threads("simple_complex", {{"prepass", false}});
}

}  // namespace
}  // namespace subpixel::replay
