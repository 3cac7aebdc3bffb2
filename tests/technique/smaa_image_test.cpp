// SMAA against a transcription that searches by brute force and has no table, its table against areas of polygons, and
// what it must leave alone.
#include <algorithm>

#include "replay/techniques/smaa_areas.hpp"
#include "shaders/techniques/smaa/smaa_interface.h"
#include "tests/technique/smaa_transcription.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

namespace brute = smaa_transcription;

TEST(SmaaAreas, AreThoseOfClippedPolygons) {
  const std::vector<glm::vec2> table = smaa_area_table();
  ASSERT_EQ(table.size(), 16u * 16 * 16 + 16u * 20 * 20);
  const auto end = [](std::uint32_t bits) {
    return brute::End{(bits & SMAA_CROSSED_BEFORE) != 0, (bits & SMAA_CROSSED_AFTER) != 0};
  };
  const auto stair = [](std::uint32_t bits) { return brute::StairEnd{(bits & 2) != 0, (bits & 1) != 0}; };
  std::size_t i = 0;
  for (std::uint32_t pattern = 0; pattern < 16; ++pattern)
    for (int x = 0; x < 16; ++x)
      for (int y = 0; y < 16; ++y, ++i) {
        const glm::dvec2 expected = brute::line_areas(end(pattern / 4), end(pattern % 4), x * x, y * y);
        for (int k = 0; k < 2; ++k)
          ASSERT_NEAR(table[i][k], expected[k], 1e-6) << "pattern " << pattern << ", " << x << " " << y;
      }
  for (std::uint32_t pattern = 0; pattern < 16; ++pattern)
    for (int x = 0; x < 20; ++x)
      for (int y = 0; y < 20; ++y, ++i) {
        const glm::dvec2 expected = brute::diagonal_areas(stair(pattern / 4), stair(pattern % 4), x, y);
        for (int k = 0; k < 2; ++k)
          ASSERT_NEAR(table[i][k], expected[k], 1e-6) << "diagonal " << pattern << ", " << x << " " << y;
      }
}

TEST(SmaaAreas, OfCasesWorkedOutByHand) {
  constexpr SmaaCrossing kAbove = SMAA_CROSSED_BEFORE, kBelow = SMAA_CROSSED_AFTER;
  // A step of one pixel from half a pixel above to half a pixel below: two triangles of 1/2 by 1/2.
  EXPECT_EQ(smaa_line_areas(kAbove, kBelow, {0, 0}), glm::dvec2(0.125, 0.125));
  // A line of two pixels that goes up at its left end: a triangle of 1 by 1/2, in the first pixel alone.
  EXPECT_EQ(smaa_line_areas(kAbove, 0, {0, 1}), glm::dvec2(0, 0.25));
  EXPECT_EQ(smaa_line_areas(kAbove, 0, {1, 0}), glm::dvec2(0, 0));
  // One of ten pixels: the line falls from 1/2 to 0 over five, 0.45 on the first pixel's mean and 0.05 on the fifth's.
  EXPECT_NEAR(smaa_line_areas(0, kBelow, {9, 0}).x, 0.45, 1e-12);
  EXPECT_NEAR(smaa_line_areas(0, kBelow, {5, 4}).x, 0.05, 1e-12);
  // From the inner corner of the first step to that of the last, the diagonal halves every lower pixel.
  EXPECT_EQ(smaa_diagonal_areas(1, 2, {3, 4}), glm::dvec2(0.5, 0));
  // Nothing crosses, or everything does: a straight edge.
  EXPECT_EQ(smaa_line_areas(0, 0, {3, 4}), glm::dvec2(0, 0));
  EXPECT_EQ(smaa_line_areas(kAbove | kBelow, kAbove | kBelow, {3, 4}), glm::dvec2(0, 0));
}

glm::dvec3 tone_mapped(const glm::dvec3& radiance) {
  return radiance * (2.43 * radiance + 0.03) / (radiance * (2.43 * radiance + 0.59) + 0.14);
}

struct SmaaCase {
  const char* name;
  ParameterValues given;
  brute::Settings settings;
};

TEST(Smaa, IsItsTranscription) {
  const SmaaCase cases[] = {
      {"low", {{"quality", "low"}}, {0.15, 2, false, 4, 0, 1}},
      {"medium", {{"quality", "medium"}, {"blend", "radiance"}}, {0.1, 2, false, 8, 0, 1}},
      {"high", {}, {0.1, 2, false, 16, 8, 0.25}},
      {"ultra", {{"quality", "ultra"}, {"edges", "colour"}}, {0.05, 2, true, 32, 16, 0.25}},
      {"own",
       {{"threshold", 0.02}, {"search_steps", 1}, {"diagonal_steps", 20}, {"corner_rounding", 0}, {"adaptation", 4}},
       {0.02, 4, false, 1, 20, 0}},
  };
  for (const char* scene : {"city", "grass", "arcade"}) {
    const int width = 97, height = 61;
    const capture::Capture capture = capture::generate(scene, {1, 97, 61, 1, 0.1});
    ASSERT_EQ(capture.frames[0].exposure, 1.0f);
    const TechniqueRun plain = run_technique(capture, "noaa", {}, width, height);
    brute::Grid<glm::vec3> shown(width, height);
    brute::Grid<glm::dvec3> radiance(width, height), displayed(width, height);
    for (std::size_t i = 0; i < plain.display.size(); ++i) {
      shown.values[i] = glm::vec3(plain.display[i]);
      radiance.values[i] = glm::dvec3(plain.radiance[i]);
      displayed.values[i] = tone_mapped(radiance.values[i]);
    }
    for (const SmaaCase& of : cases) {
      SCOPED_TRACE(std::string(scene) + ", " + of.name);
      const TechniqueRun run = run_technique(capture, "smaa", of.given, width, height);
      expect_valid(run, 1);
      const bool of_radiance = of.given.contains("blend");
      const brute::Edges edges = brute::find_edges(shown, of.settings);
      const brute::Blended expected =
          brute::blend(of_radiance ? radiance : displayed, brute::find_weights(edges, of.settings));
      std::size_t found = 0, others = 0;
      for (std::size_t i = 0; i < run.display.size(); ++i) {
        ASSERT_EQ(run.maps.at("edges")[i], static_cast<std::uint32_t>(edges.north.values[i] + edges.west.values[i]))
            << "pixel " << i;
        found += run.maps.at("edges")[i];
        EXPECT_EQ(run.radiance[i].w, plain.radiance[i].w);
        const glm::dvec3 value = of_radiance ? glm::dvec3(run.radiance[i]) : tone_mapped(glm::dvec3(run.radiance[i]));
        const glm::dvec3 off = glm::abs(value - expected.values.values[i]) / (1.0 + expected.values.values[i]);
        // A weight may be rounded to the other byte where it is half way between two.
        ASSERT_LE(std::max({off.x, off.y, off.z}), 1.01 / 255) << "pixel " << i;
        ASSERT_NEAR(run.maps.at("blended")[i], expected.shares.values[i] * 255, 1.51) << "pixel " << i;
        others += std::max({off.x, off.y, off.z}) <= 2e-6 ? 0 : 1;
      }
      EXPECT_GT(found, 200u);
      EXPECT_LE(others, run.display.size() / 400) << "of " << run.display.size();
    }
  }
}

// White below a line through the image whose height falls by `slope` from side to side; black above.
capture::Capture slanted_edge(float slope) {
  capture::Capture capture = flat_capture(64, 64);
  const auto material = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, {-1, -1, 0, 1, -1, 0, 1, -slope, 0, -1, -1, 0, 1, -slope, 0, -1, slope, 0}, material);
  return capture;
}

double edge_error(const TechniqueRun& run, const TechniqueRun& exact) {
  double sum = 0;
  for (std::size_t i = 0; i < run.radiance.size(); ++i)
    sum += std::pow(static_cast<double>(run.radiance[i].x - exact.radiance[i].x), 2.0);
  return sum / static_cast<double>(run.radiance.size());
}

TEST(Smaa, SmoothsSlantedEdges) {
  // Where in its steps an endless diagonal lies is not to be seen: both candidates' mean leaves half of the error.
  const std::pair<float, double> slopes[] = {{0.03f, 0.35}, {0.1f, 0.35},   {0.2f, 0.35},
                                             {0.45f, 0.35}, {-0.15f, 0.35}, {1.0f, 0.7}};
  for (const auto& [slope, left] : slopes) {
    const capture::Capture capture = slanted_edge(slope);
    const TechniqueRun exact = run_technique(capture, "msaa", {{"samples", 64}}, 64, 64);
    const double before = edge_error(run_technique(capture, "noaa", {}, 64, 64), exact);
    const double after = edge_error(run_technique(capture, "smaa", {{"blend", "radiance"}}, 64, 64), exact);
    EXPECT_LT(after, left * before) << "slope " << slope;
  }
}

TEST(Smaa, LeavesStraightEdgesAndCornersAlone) {
  // A bar on pixel boundaries from border to border has no steps; a square has corners, kept as they are at rounding 0.
  capture::Capture bar = flat_capture(32, 32);
  add_triangles(bar, rectangle(-0.5f, -1, 0.5f, 1, 0), add_emitter(bar, {1, 1, 1}));
  EXPECT_EQ(run_technique(bar, "smaa", {}, 32, 32).radiance, run_technique(bar, "noaa", {}, 32, 32).radiance);
  capture::Capture square = flat_capture(32, 32);
  add_triangles(square, rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 0), add_emitter(square, {1, 1, 1}));
  const TechniqueRun plain = run_technique(square, "noaa", {}, 32, 32);
  const TechniqueRun sharp = run_technique(square, "smaa", {{"corner_rounding", 0}}, 32, 32);
  const TechniqueRun rounded = run_technique(square, "smaa", {{"corner_rounding", 100}}, 32, 32);
  EXPECT_EQ(sharp.radiance, plain.radiance);
  EXPECT_GT(edge_error(rounded, plain), 0);
}

TEST(Smaa, PlainSky) {
  expect_plain_sky("smaa", {});
}
TEST(Smaa, SameOnAllThreads) {
  expect_same_on_all_threads("smaa", {});
}

TEST(Smaa, RefusesParametersOutOfRange) {
  expect_refused("smaa", {{"samples", 4}});
  expect_refused("smaa", {{"search_steps", 113}});
  expect_refused("smaa", {{"diagonal_steps", -2}});
  expect_refused("smaa", {{"threshold", 1.5}});
  expect_refused("smaa", {{"quality", "best"}});
}

}  // namespace
}  // namespace subpixel::replay
