// The post filter: what it must leave alone, and that it brings edges nearer to their exact coverage.
#include <algorithm>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

// White below a line through the image whose height falls by `slope` from side to side; black above.
capture::Capture slanted_edge(float slope) {
  capture::Capture capture = flat_capture(64, 64);
  const auto material = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, {-1, -1, 0, 1, -1, 0, 1, -slope, 0, -1, -1, 0, 1, -slope, 0, -1, slope, 0}, material);
  return capture;
}

// Mean squared difference of radiance from a 64-sample image: coverage, since the edge is white on black.
double edge_error(const TechniqueRun& run, const TechniqueRun& exact) {
  double sum = 0;
  for (std::size_t i = 0; i < run.radiance.size(); ++i)
    sum += std::pow(static_cast<double>(run.radiance[i].x - exact.radiance[i].x), 2.0);
  return sum / static_cast<double>(run.radiance.size());
}

TEST(Fxaa, SmoothsSlantedEdges) {
  for (const float slope : {0.03f, 0.1f, 0.2f, 0.45f, -0.15f}) {
    const capture::Capture capture = slanted_edge(slope);
    const TechniqueRun exact = run_technique(capture, "msaa", {{"samples", 64}}, 64, 64);
    const double before = edge_error(run_technique(capture, "noaa", {}, 64, 64), exact);
    const double after = edge_error(run_technique(capture, "fxaa", {}, 64, 64), exact);
    EXPECT_LT(after, 0.3 * before) << "slope " << slope;
  }
}

TEST(Fxaa, LeavesStraightEdgesAndPlainAreasAlone) {
  // A bar on pixel boundaries from border to border: noaa shows it exactly, and its edges have no steps.
  capture::Capture capture = flat_capture(32, 32);
  add_triangles(capture, rectangle(-0.5f, -1, 0.5f, 1, 0), add_emitter(capture, {1, 1, 1}));
  const TechniqueRun run = run_technique(capture, "fxaa", {{"blur", 0}}, 32, 32);
  const TechniqueRun plain = run_technique(capture, "noaa", {}, 32, 32);
  EXPECT_EQ(run.radiance, plain.radiance);
}

TEST(Fxaa, TurnedOffItIsNoaa) {
  const capture::Capture capture = little_grass();
  const TechniqueRun plain = run_technique(capture, "noaa", {}, 61, 37);
  const TechniqueRun off = run_technique(capture, "fxaa", {{"blur", 0}, {"search_steps", 0}}, 61, 37);
  const TechniqueRun no_edges = run_technique(capture, "fxaa", {{"least_contrast", 1}}, 61, 37);
  EXPECT_EQ(plain.display, off.display);
  EXPECT_EQ(plain.display, no_edges.display);
  EXPECT_EQ(plain.radiance, off.radiance);
  EXPECT_TRUE(std::ranges::all_of(off.maps.at("changed"), [](auto value) { return value == 0; }));
}

TEST(Fxaa, ChangesWhereTheMapSaysSo) {
  const capture::Capture capture = little_grass();
  const TechniqueRun plain = run_technique(capture, "noaa", {}, 61, 37);
  const TechniqueRun run = run_technique(capture, "fxaa", {}, 61, 37);
  expect_valid(run, 1);
  const auto& changed = run.maps.at("changed");
  EXPECT_TRUE(std::ranges::any_of(changed, [](auto value) { return value == 1; }));
  for (std::size_t i = 0; i < changed.size(); ++i) {
    if (changed[i] == 0) {
      EXPECT_EQ(run.display[i], plain.display[i]) << "pixel " << i;
    }
    EXPECT_EQ(run.radiance[i].w, plain.radiance[i].w);
  }
  EXPECT_EQ(run.paper_bytes_per_pixel, plain.paper_bytes_per_pixel);
}

TEST(Fxaa, PlainSky) {
  expect_plain_sky("fxaa", {});
}
TEST(Fxaa, SameOnAllThreads) {
  expect_same_on_all_threads("fxaa", {});
}

TEST(Fxaa, RefusesParametersOutOfRange) {
  expect_refused("fxaa", {{"samples", 4}});
  expect_refused("fxaa", {{"search_steps", 65}});
  expect_refused("fxaa", {{"search_steps", -1}});
  expect_refused("fxaa", {{"edge_threshold", 1.5}});
  expect_refused("fxaa", {{"blur", "strong"}});
}

}  // namespace
}  // namespace subpixel::replay
