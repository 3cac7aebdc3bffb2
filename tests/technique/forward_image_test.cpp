// `forward` against `msaa`, which must show the same where shading doesn't vary, and against what it says of itself.
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

TEST(Forward, EmittersLookAsUnderDeferredMsaa) {
  // Two overlapping emitters with slanted edges: every sample's value is one of three constants.
  capture::Capture capture = flat_capture(32, 24);
  capture.frames[0].sky = {0.25f, 0.5f, 0.125f};
  add_triangles(capture, {-0.8f, -0.9f, 0, 0.9f, -0.3f, 0, -0.1f, 0.8f, 0}, add_emitter(capture, {2, 0.5f, 0.25f}));
  add_triangles(capture, {-0.9f, 0.1f, 0.5f, 0.2f, -0.7f, 0.5f, 0.3f, 0.9f, -0.5f},
                add_emitter(capture, {0.125f, 1, 4}));
  for (const int samples : {4, 8, 16, 32, 64}) {
    const TechniqueRun forward = run_technique(capture, "forward", {{"samples", samples}}, 32, 24);
    const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", samples}}, 32, 24);
    expect_valid(forward, static_cast<std::uint32_t>(samples));
    for (std::size_t i = 0; i < msaa.radiance.size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(forward.radiance[i][c], msaa.radiance[i][c], 1e-5f) << samples << " samples, pixel " << i;
  }
}

TEST(Forward, ShadesOnceForEachVisibleTriangleOfAPixel) {
  // A rectangle over the whole image, from corner to corner in 16 x 16 pixels: two triangles show on the diagonal
  // alone. The second rectangle is hidden behind it.
  capture::Capture capture = flat_capture(16, 16);
  const auto material = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.5f), material);
  const TechniqueRun run = run_technique(capture, "forward", {{"samples", 8}}, 16, 16);
  for (std::size_t y = 0; y < 16; ++y)
    for (std::size_t x = 0; x < 16; ++x)
      EXPECT_EQ(run.radiance[16 * y + x].w, x + y == 15 ? 2.0f : 1.0f) << x << " " << y;
}

TEST(Forward, GrassIsCloseToDeferredMsaa) {
  const TechniqueRun forward = run_technique(little_grass(), "forward", {{"samples", 8}}, 61, 37);
  const TechniqueRun msaa = run_technique(little_grass(), "msaa", {{"samples", 8}}, 61, 37);
  expect_valid(forward, 8);
  EXPECT_LT(mean_squared_difference(forward, msaa), 1e-3);
  EXPECT_LT(forward.executions(), msaa.executions());
}

TEST(Forward, MemoryIsDepthAndColourOfEachSample) {
  EXPECT_EQ(run_technique(little_grass(), "forward", {{"samples", 8}}, 61, 37).paper_bytes_per_pixel, 64);
}

TEST(Forward, PlainSky) {
  expect_plain_sky("forward", {});
}
TEST(Forward, SameOnAllThreads) {
  expect_same_on_all_threads("forward", {});
}

TEST(Forward, RefusesParametersOutOfRange) {
  expect_refused("forward", {{"samples", 1}});
  expect_refused("forward", {{"samples", 12}});
  expect_refused("forward", {{"shading", "flat"}});
}

}  // namespace
}  // namespace subpixel::replay
