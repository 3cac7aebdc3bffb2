// Temporal anti-aliasing: what it accumulates against frames that are rendered one by one, where it takes history from
// against projected points, and what becomes of things that move.
#include <algorithm>
#include <random>

#include "capture_format/streams.hpp"
#include "replay/scene/camera.hpp"
#include "replay/scene/motion.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

TEST(TaaJitter, IsHaltonsSequenceInTurns) {
  const glm::dvec2 first[] = {{0, -1.0 / 6}, {-0.25, 1.0 / 6}, {0.25, -0.5 + 1.0 / 9}, {-0.375, -0.5 + 4.0 / 9}};
  for (int time = 0; time < 4; ++time)
    EXPECT_LT(glm::distance(jitter_of(time, 8), first[time]), 1e-12) << "time " << time;
  for (int time = -20; time < 20; ++time) {
    EXPECT_EQ(jitter_of(time, 8), jitter_of(time + 8, 8));
    EXPECT_EQ(jitter_of(time, 1), glm::dvec2(0, 0));
  }
}

// Pixels from the centre of the image's first pixel.
glm::dvec2 on_screen(const glm::dmat4& view_projection, const glm::dvec4& world, const glm::dvec2& size) {
  const glm::dvec4 clip = view_projection * world;
  return (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
}

// For points of draws in view: where `difference` says that they were, against where they project to.
void expect_projected(const capture::Capture& capture, std::uint32_t frame) {
  const glm::dvec2 size(640, 360), jitter(0.25, -0.4);
  const FrameMotion motion = frame_motion(capture, frame, frame - 1, jitter, size);
  const Camera camera = camera_of(capture.frames[frame], frame), past = camera_of(capture.frames[frame - 1], 0);
  const glm::dmat4 jittered = moved_image(-jitter, size) * camera.view_projection;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1, 1);
  std::size_t instance = 0, compared = 0;
  double farthest = 0;
  ASSERT_EQ(capture.frames[frame].draws.size(), capture.frames[frame - 1].draws.size());
  for (std::size_t d = 0; d < capture.frames[frame].draws.size(); ++d) {
    const auto now = capture::world_transforms(capture, capture.frames[frame].draws[d]);
    const auto before = capture::world_transforms(capture, capture.frames[frame - 1].draws[d]);
    for (std::size_t i = 0; i < now.size(); ++i, ++instance) {
      for (int k = 0; k < 4; ++k) {
        const glm::dvec4 point(place(random), place(random), place(random), 1);
        const glm::dvec4 clip = jittered * matrix(now[i]) * point;
        if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) continue;
        // As the shader does, in floats.
        const glm::vec4 ndc(glm::dvec4(glm::dvec3(clip) / clip.w, 1));
        const glm::vec4 change = motion.differences.at(instance) * ndc;
        const glm::vec2 centre = glm::vec2(ndc) + motion.unjitter;
        const glm::vec2 step = (glm::vec2(change) - centre * change.w) / (1 + change.w) * 0.5f * glm::vec2(size);
        const glm::dvec2 sought = on_screen(past.view_projection, matrix(before[i]) * point, size) -
                                  on_screen(camera.view_projection, matrix(now[i]) * point, size);
        if (glm::length(sought) > 100) continue;
        ASSERT_LT(glm::distance(glm::dvec2(step), sought), 2e-3) << "draw " << d << ", instance " << i;
        farthest = std::max(farthest, glm::length(sought));
        ++compared;
      }
    }
  }
  EXPECT_EQ(instance + 1, motion.differences.size());
  EXPECT_EQ(motion.unmatched, 0u);
  EXPECT_GT(compared, 20u);
  EXPECT_GT(farthest, 0.5);
}

TEST(TaaMotion, IsThatOfProjectedPoints) {
  for (const char* scene : {"city", "grass", "arcade"}) {
    SCOPED_TRACE(scene);
    capture::Capture capture = capture::generate(scene, {3, 64, 36, 1, 0.05});
    expect_projected(capture, 2);
    // And of draws that move by themselves.
    for (std::size_t d = 0; d < capture.frames[2].draws.size(); ++d)
      capture.frames[2].draws[d].transform[12 + d % 3] += 0.05f;
    expect_projected(capture, 2);
  }
}

TEST(TaaMotion, MatchesDrawsByNameAndOrder) {
  capture::Capture capture = flat_capture(8, 8);
  const auto material = add_emitter(capture, {1, 1, 1});
  for (const char* name : {"a", "b", "a"}) add_triangles(capture, rectangle(0, 0, 1, 1, 0), material).name = name;
  capture.frames.push_back(capture.frames[0]);
  auto& draws = capture.frames[1].draws;
  std::swap(draws[0], draws[1]);  // b, a, a
  draws[0].transform[12] = 0.5f;
  draws[2].transform[12] = 0.25f;
  FrameMotion motion = frame_motion(capture, 1, 0, {0, 0}, {8, 8});
  EXPECT_EQ(motion.unmatched, 0u);
  EXPECT_EQ(motion.differences[0][3][0], -0.5f);
  EXPECT_EQ(motion.differences[1], glm::mat4(0));
  EXPECT_EQ(motion.differences[2][3][0], -0.25f);
  EXPECT_EQ(motion.differences[3], glm::mat4(0));
  draws[0].name = "new";
  draws[2].index_count = 3;
  motion = frame_motion(capture, 1, 0, {0, 0}, {8, 8});
  EXPECT_EQ(motion.unmatched, 2u);
  EXPECT_EQ(motion.differences[0], glm::mat4(0));
}

// What the frames before and the frame itself show with their jitter, oldest first.
std::vector<TechniqueRun> jittered_frames(const capture::Capture& capture, int history, std::uint32_t jitter) {
  FrameScene scene(test_device(), capture, {}, {0, 61, 37});
  std::vector<TechniqueRun> frames;
  for (int time = -history; time <= 0; ++time) {
    scene.set_jitter(jitter_of(time, jitter));
    frames.push_back(technique_run(run_frame(scene, find_technique("noaa").with())));
  }
  return frames;
}

TEST(Taa, AStillCameraAveragesItsFrames) {
  const capture::Capture capture = little_grass();
  for (const int history : {0, 1, 7}) {
    const std::vector<TechniqueRun> frames = jittered_frames(capture, history, 8);
    for (const double alpha : {0.0, 0.1}) {
      for (const char* filter : {"bilinear", "catmull_rom"}) {
        const bool progressive = alpha == 0;
        const TechniqueRun run = run_technique(capture, "taa",
                                               {{"history", history},
                                                {"alpha_new", alpha},
                                                {"progressive", progressive},
                                                {"bounds", "none"},
                                                {"filter", filter},
                                                {"luma_weights", false},
                                                {"depth_test", false}},
                                               61, 37);
        expect_valid(run, 1);
        for (std::size_t i = 0; i < run.radiance.size(); ++i) {
          glm::dvec3 sum(0);
          for (std::size_t k = 0; k < frames.size(); ++k) {
            const double share = progressive ? 1 / static_cast<double>(k + 1) : k == 0 ? 1.0 : alpha;
            sum += share * (glm::dvec3(frames[k].radiance[i]) - sum);
          }
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(run.radiance[i][c], sum[c], 2e-6 * (1 + sum[c])) << "pixel " << i << ", history " << history;
          ASSERT_EQ(run.radiance[i].w, frames.back().radiance[i].w);
          ASSERT_EQ(run.maps.at("rejected")[i], 0u);
          ASSERT_EQ(run.maps.at("clipped")[i], 0u);
        }
      }
    }
  }
}

TEST(Taa, ComesNearManySamples) {
  const capture::Capture capture = little_grass();
  const TechniqueRun exact = run_technique(capture, "msaa", {{"samples", 64}}, 61, 37);
  const double before = mean_squared_difference(run_technique(capture, "noaa", {}, 61, 37), exact);
  const double after = mean_squared_difference(
      run_technique(capture, "taa", {{"bounds", "none"}, {"luma_weights", false}}, 61, 37), exact);
  EXPECT_LT(after, 0.2 * before);
}

// Stripes of several colours on black, which move by `step` pixels to the right from frame to frame.
capture::Capture moving_stripes(int frames, int step, bool same_name) {
  capture::Capture capture = flat_capture(48, 24);
  std::vector<std::uint32_t> materials;
  materials.reserve(3);
  for (int m = 0; m < 3; ++m)
    materials.push_back(add_emitter(capture, {0.2f + 0.3f * static_cast<float>(m), 0.5f, m == 1 ? 0.9f : 0.1f}));
  for (int k = 0; k < 8; ++k) {
    const float x0 = -1 + static_cast<float>(k) / 12;
    add_triangles(capture, rectangle(x0, -0.5f, x0 + 1.0f / 12, 0.5f, 0), materials[static_cast<std::size_t>(k) % 3])
        .name = "stripe";
  }
  for (int f = 1; f < frames; ++f) {
    capture.frames.push_back(capture.frames[0]);
    for (capture::Draw& draw : capture.frames.back().draws) {
      draw.transform[12] = static_cast<float>(f * step) / 24;
      if (!same_name) draw.name += std::to_string(f);
    }
  }
  return capture;
}

TechniqueRun run_at(const capture::Capture& capture, std::uint32_t frame, std::string_view name,
                    const ParameterValues& given) {
  FrameScene scene(test_device(), capture, {}, {frame, 48, 24});
  return technique_run(run_frame(scene, find_technique(name).with(given)));
}

TEST(Taa, HistoryFollowsWhatMoves) {
  const ParameterValues given{{"history", 4}, {"jitter", 1}, {"bounds", "none"}, {"luma_weights", false}};
  const capture::Capture named = moving_stripes(5, 2, true);
  const TechniqueRun plain = run_at(named, 4, "noaa", {});
  // By whole pixels nothing is lost on the way, up to a pixel from the outline, where what is beside counts as open.
  const TechniqueRun run = run_at(named, 4, "taa", given);
  for (std::size_t y = 7; y < 17; ++y)
    for (std::size_t x = 9; x < 39; ++x)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(run.radiance[y * 48 + x][c], plain.radiance[y * 48 + x][c], 1e-5f) << "pixel " << x << ", " << y;
  // Without its counterpart it counts as still and leaves ghosts, which bounds make fainter.
  const capture::Capture unnamed = moving_stripes(5, 2, false);
  const TechniqueRun ghosts = run_at(unnamed, 4, "taa", given);
  ParameterValues bounded = given;
  const double free = mean_squared_difference(ghosts, plain);
  EXPECT_GT(free, 1e-3);
  for (const char* bounds : {"clamp", "clip", "variance"}) {
    bounded["bounds"] = bounds;
    const TechniqueRun with = run_at(unnamed, 4, "taa", bounded);
    EXPECT_LT(mean_squared_difference(with, plain), 0.5 * free) << bounds;
    EXPECT_TRUE(std::ranges::any_of(with.maps.at("clipped"), [](auto value) { return value > 0; })) << bounds;
  }
}

TEST(Taa, WhatWasHiddenHasNoHistory) {
  // A black card in front leaves a bright wall behind: nothing of it was to be seen there.
  capture::Capture capture = flat_capture(48, 24);
  const auto wall = add_emitter(capture, {0.8f, 0.6f, 0.4f}), card = add_emitter(capture, {0, 0, 0});
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.8f), wall).name = "wall";
  add_triangles(capture, rectangle(-0.5f, -1, 0.5f, 1, 0.5f), card).name = "card";
  for (auto& frame : capture.frames) frame.view[14] = -1;
  capture.frames[0].projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0.25f, 0, 0, 0, 1, 1};
  capture.frames.push_back(capture.frames[0]);
  capture.frames[1].draws[1].transform[12] = 0.5f;  // 12 pixels
  const ParameterValues given{{"history", 1}, {"jitter", 1}, {"bounds", "none"}};
  const TechniqueRun plain = run_at(capture, 1, "noaa", {}), run = run_at(capture, 1, "taa", given);
  for (std::size_t i = 0; i < run.radiance.size(); ++i) {
    if (i % 48 == 12) continue;  // beside what was open before
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(run.radiance[i][c], plain.radiance[i][c], 5e-3f) << "pixel " << i;
  }
  std::size_t rejected = 0;
  for (const auto value : run.maps.at("rejected")) rejected += value;
  EXPECT_GE(rejected, 10u * 24);
  EXPECT_LE(rejected, 12u * 24);
  ParameterValues untested = given;
  untested["depth_test"] = false;
  EXPECT_GT(mean_squared_difference(run_at(capture, 1, "taa", untested), plain), 0.005);
}

TEST(Taa, AFrameIsTheSameWhateverWasRunBefore) {
  const capture::Capture capture = capture::generate("city", {4, 48, 24, 1, 0.1});
  const TechniqueSetting taa = find_technique("taa").with({{"history", 2}}), noaa = find_technique("noaa").with({});
  FrameScene scene(test_device(), capture, {}, {0, 48, 24});
  const TechniqueRun plain = technique_run(run_frame(scene, noaa));
  std::vector<TechniqueRun> in_order;
  for (std::uint32_t frame = 0; frame < 4; ++frame) {
    scene.set_frame({frame, 48, 24});
    in_order.push_back(technique_run(run_frame(scene, taa)));
    EXPECT_EQ(scene.frame(), frame);
  }
  for (const std::uint32_t frame : {3u, 1u, 0u})
    EXPECT_TRUE(run_at(capture, frame, "taa", {{"history", 2}}) == in_order[frame]);
  // And leaves the scene as it was.
  scene.set_frame({0, 48, 24});
  run_frame(scene, taa);
  EXPECT_TRUE(technique_run(run_frame(scene, noaa)) == plain);
}

TEST(Taa, PlainSky) {
  expect_plain_sky("taa", {});
}
TEST(Taa, SameOnAllThreads) {
  expect_same_on_all_threads("taa", {{"history", 5}});
}

TEST(Taa, RefusesParametersOutOfRange) {
  expect_refused("taa", {{"samples", 4}});
  expect_refused("taa", {{"jitter", 3}});
  expect_refused("taa", {{"history", 257}});
  expect_refused("taa", {{"bounds", "box"}});
}

}  // namespace
}  // namespace subpixel::replay
