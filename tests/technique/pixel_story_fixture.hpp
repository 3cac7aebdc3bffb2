// Stories of pixels all over a frame, and what is the same in all of them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "replay/frame/pixel_story.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {

using nlohmann::json;

constexpr std::uint32_t kWidth = 61, kHeight = 37;

inline std::uint64_t mask(const json& text) {
  return std::strtoull(text.get<std::string>().c_str(), nullptr, 16);
}
inline glm::vec3 vector(const json& list) {
  return {list[0].get<float>(), list[1].get<float>(), list[2].get<float>()};
}

inline capture::Capture story_capture(const std::string& scene, std::uint32_t frames = 1) {
  return capture::generate(scene, {frames, kWidth, kHeight, 1, scene == "grass" ? 0.01 : 0.05});
}

// The resolve's mean is the pixel, up to the order in which it is added; what filters make of it comes after.
inline void expect_resolved(const json& told, glm::vec3 radiance) {
  const json& resolve = told["resolve"];
  const int lit = resolve["lit"].get<int>(), sky = resolve["sky"].get<int>();
  EXPECT_EQ(lit + sky + resolve["left_out"].get<int>(), told["samples"].get<int>());
  if (told.contains("filter")) return;
  glm::dvec3 sum = glm::dvec3(vector(told["sky"])) * static_cast<double>(sky);
  int weights = 0;
  for (const json& execution : told["executions"]) {
    weights += execution["weight"].get<int>();
    sum += glm::dvec3(vector(execution["value"])) * execution["weight"].get<double>();
  }
  EXPECT_EQ(weights, lit);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / (lit + sky), radiance[c], 1e-6 * (1 + radiance[c])) << resolve;
}

// Stories of pixels all over the image; `check` gets each, with its pixel, and what the frame has there without a
// story.
template <typename Check>
void each_story(const std::string& scene_name, const std::string& technique, const ParameterValues& given, Check check,
                std::uint32_t frame_number = 0) {
  FrameScene scene(test_device(), story_capture(scene_name, frame_number + 1), {}, {frame_number, kWidth, kHeight});
  const TechniqueSetting setting = find_technique(technique).with(given);
  const TechniqueRun frame = technique_run(run_frame(scene, setting));
  for (std::uint32_t y = 4; y < kHeight; y += 8) {
    for (std::uint32_t x = 3; x < kWidth; x += 13) {
      PixelStory story({x, y});
      RecordedFrame recorded(scene, setting, &story);
      recorded.run();
      json told = recorded.story();
      told["pixel"] = {x, y};
      SCOPED_TRACE(technique + " " + json(given).dump() + " at " + std::to_string(x) + "," + std::to_string(y));
      const glm::vec4 radiance = frame.radiance[std::size_t{y} * kWidth + x];
      ASSERT_EQ(vector(told["result"]["radiance"]), glm::vec3(radiance)) << "a story changes the frame";
      ASSERT_EQ(told["executions"].size(), static_cast<std::size_t>(radiance.w));
      expect_resolved(told, glm::vec3(radiance));
      check(told, glm::vec3(radiance));
    }
  }
}

// What the depth test of each sample leaves, from the fragments' own masks and depths.
inline std::vector<int> owners(const json& told) {
  std::vector<int> owner(told["samples"].get<std::size_t>(), -1);
  std::vector<float> depth(owner.size(), 0.0f);
  for (const json& fragment : told["fragments"]) {
    const std::uint64_t covers = mask(fragment.value("alpha_leaves", fragment["covers"].get<std::string>()));
    std::uint64_t passes = 0;
    for (std::size_t s = 0; s < owner.size(); ++s) {
      const float z = fragment["depths"][s].get<float>();
      if ((covers >> s & 1u) == 0 || !(z > depth[s])) continue;
      depth[s] = z;
      owner[s] = fragment["number"].get<int>();
      passes |= std::uint64_t{1} << s;
    }
    EXPECT_EQ(passes, mask(fragment["passes"]));
  }
  for (std::size_t s = 0; s < owner.size(); ++s) {
    const json& shown = told["pattern"][s]["fragment"];
    EXPECT_EQ(shown.is_null() ? -1 : shown.get<int>(), owner[s]) << "sample " << s;
  }
  return owner;
}

}  // namespace subpixel::replay
