// A technique run on one frame of a capture, and what all techniques have to hold to.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "capture_format/capture.hpp"
#include "replay/frame/run_frame.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {

template <typename T>
std::vector<T> texels_of(gpu::Device& device, gpu::Image& image) {
  const auto bytes = gpu::download(device, image);
  std::vector<T> texels(bytes.size() / sizeof(T));
  std::memcpy(texels.data(), bytes.data(), bytes.size());
  return texels;
}

struct TechniqueRun {
  std::vector<glm::vec4> radiance, display;  // radiance.w: lighting executions
  std::map<std::string, std::vector<std::uint32_t>> maps;
  std::map<std::string, std::uint64_t> counters;
  double paper_bytes_per_pixel = 0, fitted_bytes_per_pixel = 0;

  double executions() const {
    double sum = 0;
    for (const auto& pixel : radiance) sum += static_cast<double>(pixel.w);
    return sum;
  }
  bool operator==(const TechniqueRun& other) const {
    const auto same = [](const auto& a, const auto& b) {
      return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
    };
    return same(radiance, other.radiance) && same(display, other.display) && maps == other.maps;
  }
};

// `image` with `alpha`.
inline std::vector<glm::vec4> with_alpha(const Image& image, const std::vector<float>& alpha) {
  std::vector<glm::vec4> pixels;
  for (std::size_t i = 0; i < alpha.size(); ++i)
    pixels.emplace_back(image.pixels[3 * i], image.pixels[3 * i + 1], image.pixels[3 * i + 2], alpha[i]);
  return pixels;
}

inline TechniqueRun technique_run(const FrameImages& images) {
  TechniqueRun run;
  run.radiance = with_alpha(images.radiance, images.executions);
  run.display = with_alpha(images.display, std::vector<float>(images.executions.size(), 1));
  run.maps = images.maps;
  return run;
}

inline TechniqueRun run_technique(const capture::Capture& capture, std::string_view name, const ParameterValues& given,
                                  std::uint32_t width, std::uint32_t height, gpu::Device& device = test_device()) {
  FrameScene scene(device, capture, {}, {0, width, height});
  const FrameRun frame = run_frame(scene, find_technique(name).with(given));
  TechniqueRun run = technique_run(frame);
  run.counters = frame.counters;
  run.paper_bytes_per_pixel = frame.memory.paper_bytes_per_pixel;
  run.fitted_bytes_per_pixel = frame.memory.fitted_bytes_per_pixel;
  return run;
}

// A field of grass small enough for a test.
inline capture::Capture little_grass() {
  return capture::generate("grass", {1, 61, 37, 1, 0.01});
}

inline double mean_squared_difference(const TechniqueRun& a, const TechniqueRun& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.display.size(); ++i)
    for (int c = 0; c < 3; ++c) sum += std::pow(static_cast<double>(a.display[i][c] - b.display[i][c]), 2.0);
  return sum / static_cast<double>(3 * a.display.size());
}

inline void expect_valid(const TechniqueRun& run, std::uint32_t most_executions) {
  for (std::size_t i = 0; i < run.radiance.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(run.radiance[i][c]) && run.radiance[i][c] >= 0) << "radiance of pixel " << i;
      ASSERT_TRUE(run.display[i][c] >= 0 && run.display[i][c] <= 1) << "display value of pixel " << i;
    }
    ASSERT_EQ(run.radiance[i].w, std::floor(run.radiance[i].w)) << "pixel " << i;
    ASSERT_LE(run.radiance[i].w, static_cast<float>(most_executions)) << "pixel " << i;
  }
}

// Lists of fragments and ordered passes leave the same bits: on scenes of small and large, alpha-tested, clipped and
// coinciding triangles, for each of `settings`. At least `least_listed` of the runs have to be by lists; leaves are too
// deep for some.
inline void expect_lists_as_ordered(std::string_view technique, const std::vector<ParameterValues>& settings,
                                    std::size_t least_listed) {
  const std::vector<std::pair<std::string, double>> scenes{{"grass", 0.01},      {"city", 0.05},
                                                           {"foliage", 0.02},    {"arcade", 0.05},
                                                           {"hard_coplanar", 1}, {"hard_near_plane", 1}};
  std::size_t listed = 0;
  for (const auto& [name, density] : scenes) {
    const capture::Capture capture = capture::generate(name, {1, 61, 37, 1, density});
    for (ParameterValues given : settings) {
      given["order"] = "lists";
      const TechniqueRun lists = run_technique(capture, technique, given, 61, 37);
      listed += lists.counters.count("listed_fragments");
      given["order"] = "one_pass";
      TechniqueRun one_pass = run_technique(capture, technique, given, 61, 37);
      // How it came about, not what: lists are merged in registers.
      for (const char* map : {"words_loaded", "words_stored"}) one_pass.maps.erase(map);
      EXPECT_TRUE(lists == one_pass) << name << " " << nlohmann::json(given).dump();
    }
  }
  EXPECT_GE(listed, least_listed);
}

// Empty frames and frames whose geometry is all out of view show the sky, unlit and everywhere the same.
inline void expect_plain_sky(std::string_view technique, const ParameterValues& given) {
  capture::Capture empty = flat_capture(19, 13);
  empty.frames[0].sky = {0.2f, 0.4f, 0.8f};
  capture::Capture out_of_view = empty;
  add_triangles(out_of_view, rectangle(5, 5, 6, 6, 0), add_emitter(out_of_view, {1, 1, 1}));
  for (const capture::Capture& capture : {empty, out_of_view}) {
    const TechniqueRun run = run_technique(capture, technique, given, 19, 13);
    EXPECT_EQ(run.executions(), 0);
    for (const auto& pixel : run.radiance)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(pixel[c], empty.frames[0].sky[static_cast<std::size_t>(c)], 1e-5f);
    for (const auto& pixel : run.display) ASSERT_EQ(pixel, run.display[0]);
    for (const auto& [name, values] : run.maps)
      for (const auto value : values) ASSERT_EQ(value, 0u) << name;
  }
}

// The same bits from any number of threads, and from run to run.
inline void expect_same_on_all_threads(std::string_view technique, const ParameterValues& given) {
  const capture::Capture capture = little_grass();
  const char* const before = std::getenv("LP_NUM_THREADS");
  const std::string restored = before ? before : "";
  const TechniqueRun expected = run_technique(capture, technique, given, 61, 37);
  for (const char* threads : {"1", "2", "8"}) {
    setenv("LP_NUM_THREADS", threads, 1);
    gpu::Device device;
    EXPECT_TRUE(expected == run_technique(capture, technique, given, 61, 37, device)) << threads << " threads";
  }
  if (before)
    setenv("LP_NUM_THREADS", restored.c_str(), 1);
  else
    unsetenv("LP_NUM_THREADS");
}

inline void expect_refused(std::string_view technique, const ParameterValues& given) {
  EXPECT_THROW(find_technique(technique).with(given), UsageError) << nlohmann::json(given).dump();
}

}  // namespace subpixel::replay
