// A pixel's story, replayed by plain code on the host: what it tells has to add up to the bits of the frame, which is
// run without it.
#include <fmt/format.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <set>

#include "capture_format/writer.hpp"
#include "replay/story.hpp"
#include "replay/techniques/streaming_story.hpp"
#include "tests/technique/pixel_story_fixture.hpp"
#include "tests/technique/streaming_transcription.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

TEST(PixelStory, EverySampleOfMsaaAddsUpToTheFrame) {
  std::size_t lit = 0, sky = 0;
  for (const double samples : {1.0, 8.0, 16.0}) {
    const std::string technique = samples == 1 ? "noaa" : "msaa";
    each_story("grass", technique, {{"samples", samples}}, [&](const json& told, glm::vec3 radiance) {
      const std::vector<int> owner = owners(told);
      const std::size_t group = std::min<std::size_t>(owner.size(), 8);
      glm::vec3 sum(0);
      std::size_t next = 0;
      for (std::size_t first = 0; first < owner.size(); first += group) {
        glm::vec3 part(0);
        for (std::size_t s = first; s < first + group; ++s) {
          if (owner[s] < 0) {
            part += vector(told["sky"]);
            ++sky;
            continue;
          }
          const json& execution = told["executions"].at(next++);
          ASSERT_EQ(execution["of"].get<std::size_t>(), s);
          ASSERT_EQ(mask(execution["samples"]), std::uint64_t{1} << s);
          part += vector(execution["value"]);
          ++lit;
        }
        sum += part;
      }
      ASSERT_EQ(next, told["executions"].size());
      EXPECT_EQ(sum / static_cast<float>(owner.size()), radiance);
    });
  }
  EXPECT_GT(lit, 100u);
  EXPECT_GT(sky, 20u);
}

TEST(PixelStory, EachVisibleTriangleIsLitOnceForItsSamples) {
  std::size_t several = 0;
  for (const char* technique : {"forward", "visibility", "dais"}) {
    each_story("grass", technique, {{"samples", 8.0}}, [&](const json& told, glm::vec3 radiance) {
      const std::vector<int> owner = owners(told);
      int covered = 0;
      for (const int one : owner) covered += one >= 0;
      glm::vec3 sum = vector(told["sky"]) * static_cast<float>(8 - covered);
      for (const json& execution : told["executions"]) {
        int shows = 0;
        for (std::size_t s = 0; s < owner.size(); ++s) {
          const bool own = owner[s] == execution["of"].get<int>();
          shows += own;
          ASSERT_EQ(own, (mask(execution["samples"]) >> s & 1u) != 0);
        }
        ASSERT_EQ(shows, execution["weight"].get<int>());
        sum += vector(execution["value"]) * static_cast<float>(shows);
      }
      EXPECT_EQ(sum / 8.0f, radiance);
      several += told["executions"].size() > 1;
    });
  }
  EXPECT_GT(several, 5u);
}

TEST(PixelStory, SimplePixelsAreLitByOneSample) {
  std::set<std::uint32_t> kinds;
  each_story("grass", "simple_complex", {{"samples", 8.0}}, [&](const json& told, glm::vec3 radiance) {
    const std::vector<int> owner = owners(told);
    const auto complex = told["maps"]["complex"].get<std::uint32_t>();
    kinds.insert(complex);
    glm::vec3 sum(0);
    std::size_t next = 0;
    for (const int one : owner) {
      const glm::vec3 value = one < 0 ? vector(told["sky"]) : vector(told["executions"].at(next)["value"]);
      if (complex != 0) next += one >= 0;
      sum = complex != 0 ? sum + value : value * 8.0f;
      if (complex == 0) break;
    }
    EXPECT_EQ(sum / 8.0f, radiance);
  });
  EXPECT_EQ(kinds.size(), 2u);
}

// Eight words of a step's surface as the transcription has it.
streaming_test::Surface surface_of(const json& words) {
  streaming_test::Surface s;
  s.depth = std::bit_cast<float>(words[0].get<std::uint32_t>());
  s.slope_x = static_cast<std::uint16_t>(words[1].get<std::uint32_t>());
  s.slope_y = static_cast<std::uint16_t>(words[1].get<std::uint32_t>() >> 16);
  s.coverage = words[2].get<std::uint32_t>();
  s.resolved = words[3].get<std::uint32_t>();
  for (std::size_t c = 0; c < 4; ++c) s.albedo[c] = static_cast<std::uint8_t>(words[4].get<std::uint32_t>() >> (8 * c));
  s.normal = words[5].get<std::uint32_t>();
  s.roughness = static_cast<std::uint8_t>(words[6].get<std::uint32_t>());
  s.emission = words[7].get<std::uint32_t>();
  return s;
}

// Samples that each surface of the transcription shows (section 3.3), and the mean of what the story says they are
// worth.
glm::vec3 resolved(const json& told, const streaming_test::Pixel& pixel, const std::vector<std::uint32_t>& slots) {
  const auto samples = told["samples"].get<std::uint32_t>();
  std::vector<std::uint32_t> shows(pixel.surfaces.size(), 0);
  for (std::uint32_t s = 0; s < samples; ++s) {
    const auto [x, y] = gpu_types::sample_offset(samples, s);
    float nearest = 3e38f;
    std::size_t owner = shows.size();
    for (std::size_t i = 0; i < pixel.surfaces.size(); ++i) {
      const streaming_test::Surface& surface = pixel.surfaces[i];
      const float depth = surface.depth + streaming_test::from_half(surface.slope_x) * static_cast<float>(x) / 128 +
                          streaming_test::from_half(surface.slope_y) * static_cast<float>(y) / 128;
      if ((surface.coverage >> s & 1u) == 0 || !(depth < nearest)) continue;
      nearest = depth;
      owner = i;
    }
    if (owner < shows.size()) shows[owner] |= 1u << s;
  }
  glm::vec3 sum(0);
  int covered = 0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < shows.size(); ++i) {
    if (shows[i] == 0) continue;
    const json& execution = told["executions"].at(next++);
    EXPECT_EQ(execution["of"].get<std::uint32_t>(), slots[i]);
    EXPECT_EQ(mask(execution["samples"]), shows[i]);
    sum += static_cast<float>(std::popcount(shows[i])) * vector(execution["value"]);
    covered += std::popcount(shows[i]);
  }
  EXPECT_EQ(next, told["executions"].size());
  if (pixel.discarded && covered > 0) return sum / static_cast<float>(covered);
  return (sum + vector(told["sky"]) * static_cast<float>(samples - static_cast<std::uint32_t>(covered))) /
         static_cast<float>(samples);
}

TEST(PixelStory, StreamingReplayedByTheTranscriptionIsTheFrame) {
  std::map<std::string, std::size_t> kinds;
  for (const auto& [scene, surfaces, samples] :
       {std::tuple{"grass", 3.0, 8.0}, std::tuple{"grass", 1.0, 16.0}, std::tuple{"foliage", 2.0, 8.0}}) {
    const ParameterValues given{{"surfaces", surfaces}, {"samples", samples}};
    streaming_test::Options options;
    options.surfaces = static_cast<std::uint32_t>(surfaces);
    options.samples = static_cast<std::uint32_t>(samples);
    each_story(scene, "streaming", given, [&](const json& told, glm::vec3 radiance) {
      owners(told);
      streaming_test::Compressor compressor(options);
      std::map<int, const json*> steps;
      for (const json& step : told["steps"]) steps[step["fragment"].get<int>()] = &step;
      const json* last = nullptr;
      std::uint32_t merges = 0, lost = 0;
      for (const json& fragment : told["fragments"]) {
        const json& plane = fragment["plane"];
        const auto covers =
            static_cast<std::uint32_t>(mask(fragment.value("alpha_leaves", fragment["covers"].get<std::string>())));
        const auto found = steps.find(fragment["number"].get<int>());
        const bool told_of = found != steps.end() && found->second->contains("fragment_words");
        streaming_test::Surface surface;
        surface.coverage = covers;
        if (told_of) {
          surface = surface_of((*found->second)["fragment_words"]);
          ASSERT_EQ(surface.coverage, covers);
          last = found->second;
          ++kinds[(*last)["kind"]];
          merges += (*last)["kind"] == "merged";
          EXPECT_EQ((*last)["what"].get<std::string>().find("against the parameters"), std::string::npos)
              << (*last)["what"];
          lost += last->value("left", 0u);
        } else if (covers != 0) {
          ++kinds["hidden"];
        }
        const streaming_test::Pixel before = compressor.pixel();
        compressor.add({plane["depth"], plane["dx"], plane["dy"], plane["smallest"], plane["largest"]}, surface);
        ASSERT_EQ(told_of, !(before == compressor.pixel())) << "fragment " << fragment["number"];
      }
      const streaming_test::Pixel& pixel = compressor.pixel();
      EXPECT_EQ(told["maps"]["merges"].get<std::uint32_t>(), merges);
      EXPECT_EQ(told["maps"]["discards"].get<std::uint32_t>(), lost);
      EXPECT_EQ(pixel.merges, merges);
      ASSERT_EQ(told["surfaces"].size(), pixel.surfaces.size());
      std::vector<std::uint32_t> slots;
      for (std::size_t i = 0; i < pixel.surfaces.size(); ++i) {
        slots.push_back(told["surfaces"][i]["slot"].get<std::uint32_t>());
        EXPECT_EQ(surface_of((*last)["surface_words"][slots.back()]), pixel.surfaces[i]);
      }
      EXPECT_EQ(resolved(told, pixel, slots), radiance);
    });
  }
  for (const char* kind : {"stored", "merged", "replaced", "dropped", "hidden"}) EXPECT_GT(kinds[kind], 0u) << kind;
}

// Where the shaders that run do not do what the parameters say, as in docs/tour.md, the story does.
TEST(PixelStory, MergesThatTheParametersForbidAreSaidToBeAgainstThem) {
  FrameScene scene(test_device(), story_capture("grass"), {}, {0, kWidth, kHeight});
  PixelStory story({29, 20});
  const RecordedFrame recorded(scene, find_technique("streaming").with({}), &story);
  ASSERT_GE(story.fragments().size(), 2u);
  // The second fragment merges into the surface that the first left at depths of 1 to 2.
  const auto merge = [&](const StreamingParameters& parameters, glm::vec4 compared, glm::vec2 interval) {
    gpu_types::StreamStep steps[2]{};
    steps[0].head = {0, 1, 1, 0};
    steps[1].head = {1, 1, 1, 1};
    steps[1].compared[0] = compared;
    steps[1].interval = glm::vec4(interval, 0, 0);
    const json told = streaming_steps(story, parameters, steps);
    EXPECT_EQ(told[1]["kind"], "merged");
    const std::string what = told[1]["what"];
    const auto at = what.find("; against the parameters: ");
    return at == std::string::npos ? std::string() : what.substr(at + 26);
  };
  StreamingParameters parameters;
  EXPECT_EQ(merge(parameters, {1, 1, 2, 0}, {1.5, 2.5}), "");
  EXPECT_EQ(merge(parameters, {1, 1, 2, 0}, {3, 4}), "depths 1 to 2 apart from its 3 to 4");
  EXPECT_EQ(merge(parameters, {1, 1, 2, 2}, {1.5, 2.5}), "2 samples shared");
  EXPECT_EQ(merge(parameters, {0.5, 1, 2, 0}, {1.5, 2.5}), "cosine of normals 0.5000, not above 0.7071");
  EXPECT_EQ(merge(parameters, {0.5, 1, 2, 2}, {3, 4}),
            "2 samples shared, cosine of normals 0.5000, not above 0.7071, depths 1 to 2 apart from its 3 to 4");
  parameters.merge_depth = parameters.merge_normals = parameters.merge_coverage = false;
  EXPECT_EQ(merge(parameters, {0.5, 1, 2, 2}, {3, 4}), "");
}

TEST(PixelStory, DecoupledCoverageToldIsTheFrame) {
  std::map<std::string, std::size_t> kinds;
  for (const auto& [technique, surfaces] : {std::pair{"dcaa", 4.0}, std::pair{"dcaa", 1.0}, std::pair{"hybrid", 2.0}}) {
    each_story("grass", technique, {{"surfaces", surfaces}, {"samples", 16.0}},
               [&](const json& told, glm::vec3 radiance) {
                 owners(told);
                 std::uint32_t first = 0, second = 0, discards = 0;
                 for (const json& step : told["steps"]) {
                   const std::string kind = step["kind"];
                   ++kinds[kind];
                   first += kind == "merged";
                   second += kind == "second merge";
                   discards += kind == "replaced" || kind == "dropped";
                 }
                 // The maps are those of the frame's own state.
                 EXPECT_EQ(told["maps"]["first_merges"].get<std::uint32_t>(), first);
                 EXPECT_EQ(told["maps"]["second_merges"].get<std::uint32_t>(), second);
                 EXPECT_EQ(told["maps"]["surfaces"].get<std::size_t>(), told["surfaces"].size());
                 EXPECT_EQ(told["maps"]["discards"].get<std::uint32_t>(), discards);
                 glm::vec3 sum(0);
                 int covered = 0;
                 std::uint64_t seen = 0;
                 for (const json& execution : told["executions"]) {
                   const std::uint64_t samples = mask(execution["samples"]);
                   EXPECT_EQ(samples & seen, 0u);
                   seen |= samples;
                   sum += static_cast<float>(std::popcount(samples)) * vector(execution["value"]);
                   covered += std::popcount(samples);
                 }
                 EXPECT_EQ((sum + vector(told["sky"]) * static_cast<float>(16 - covered)) * (1.0f / 16.0f), radiance);
               });
  }
  for (const char* kind : {"stored", "merged", "second merge", "hidden"}) EXPECT_GT(kinds[kind], 0u) << kind;
}

// The whole document of a file, and what is wrong to ask.
class PixelStoryOfFile : public testing::Test {
 protected:
  PixelStoryOfFile()
      : path_(std::filesystem::path(testing::TempDir()) / fmt::format("pixel_story_{}.spcap", ::getpid())) {
    capture::write_capture(little_grass(), path_);
    job_.capture = path_;
    job_.techniques = parse_technique_list("streaming");
    job_.x = 29;
    job_.y = 20;
  }
  ~PixelStoryOfFile() override { std::filesystem::remove(path_); }

  std::filesystem::path path_;
  StoryJob job_;
};

TEST_F(PixelStoryOfFile, ReferenceIsTheMeanOfItsShadings) {
  job_.reference_samples = 64;
  const json told = tell_pixel(job_);
  ASSERT_EQ(told["stories"].size(), 2u);
  EXPECT_EQ(told["stories"][1]["technique"], "msaa");
  glm::dvec3 sum(0);
  int seen = 0;
  for (const json& one : told["reference"]["shadings"]) {
    sum += glm::dvec3(vector(one["radiance"])) * one["samples"].get<double>();
    seen += one["samples"].get<int>();
  }
  ASSERT_LE(seen, 64);
  ASSERT_GT(seen, 0);
  const glm::dvec3 mean = (sum + glm::dvec3(vector(told["stories"][0]["sky"])) * (64.0 - seen)) / 64.0;
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(vector(told["reference"]["result"]["radiance"])[c], mean[c], 1e-5 * mean[c] + 1e-7);
  const std::string text = story_text(told);
  for (const char* part : {"pixel 29,20", "streaming", "msaa", "reference, 64 samples", "what was done with each"})
    EXPECT_NE(text.find(part), std::string::npos) << part << text;
}

// A run with lights of its own shows another frame than the capture's.
TEST_F(PixelStoryOfFile, IsOfTheRunsLights) {
  job_.reference_samples = 4;
  const json recorded = tell_pixel(job_);
  job_.point_lights = 6;
  const json lit = tell_pixel(job_);
  EXPECT_EQ(lit["stories"][0]["fragments"].size(), recorded["stories"][0]["fragments"].size());
  EXPECT_NE(lit["stories"][0]["result"]["radiance"], recorded["stories"][0]["result"]["radiance"]);
  EXPECT_NE(lit["reference"]["result"]["radiance"], recorded["reference"]["result"]["radiance"]);
  job_.point_lights = 2000;
  EXPECT_THROW(tell_pixel(job_), UsageError);
}

TEST_F(PixelStoryOfFile, WhatIsNotThereIsRefused) {
  StoryJob outside = job_, frame = job_, none = job_;
  outside.x = kWidth;
  frame.frame = 1;
  none.techniques.clear();
  EXPECT_THROW(tell_pixel(outside), UsageError);
  EXPECT_THROW(tell_pixel(frame), UsageError);
  EXPECT_THROW(tell_pixel(none), UsageError);
  job_.techniques = parse_technique_list("nothing");
  EXPECT_THROW(tell_pixel(job_), UsageError);
}

}  // namespace
}  // namespace subpixel::replay
