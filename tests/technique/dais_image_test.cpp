// `dais`: planes of the triangle buffer against the vertices that they replace, whose interpolation `visibility` has.
#include <numeric>

#include "shaders/techniques/dais/dais_interface.h"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

capture::Capture scene_of(const std::string& name, double density) {
  return capture::generate(name, {1, 61, 37, 1, density});
}

// Large, alpha-tested, clipped and thin triangles; textures, normal maps, emission.
const std::vector<std::pair<std::string, double>> kScenes{
    {"grass", 0.01}, {"city", 0.05},      {"foliage", 0.02},      {"arcade", 0.05},
    {"fur", 0.02},   {"hard_slivers", 1}, {"hard_near_plane", 1}, {"hard_grazing", 1},
};

double sum_of(const std::vector<std::uint32_t>& map) {
  return std::accumulate(map.begin(), map.end(), 0.0);
}

TEST(Dais, PlanesGiveWhatVerticesGive) {
  for (const auto& [name, density] : kScenes) {
    SCOPED_TRACE(name);
    const capture::Capture capture = scene_of(name, density);
    const TechniqueRun planes = run_technique(capture, "dais", {}, 61, 37);
    const TechniqueRun vertices = run_technique(capture, "visibility", {{"point", "visible"}}, 61, 37);
    expect_valid(planes, 8);
    ASSERT_EQ(planes.executions(), vertices.executions());
    EXPECT_LT(mean_squared_difference(planes, vertices), 2e-6);
    EXPECT_EQ(planes.counters.at("stored_triangles"), planes.counters.at("visible_triangles"));
    // Fibres far thinner than a pixel go back to their vertices.
    if (name == "fur") {
      EXPECT_GT(planes.counters.at("triangles_without_planes"), 10u);
      EXPECT_GT(sum_of(planes.maps.at("from_vertices")), 10.0);
    }
  }
}

TEST(Dais, WithoutRoomAllComesFromVertices) {
  for (const auto& [name, density] : kScenes)
    for (const char* point : {"covered", "visible"}) {
      SCOPED_TRACE(name);
      const capture::Capture capture = scene_of(name, density);
      const TechniqueRun none = run_technique(capture, "dais", {{"pool", 0}, {"point", point}}, 61, 37);
      const TechniqueRun vertices = run_technique(capture, "visibility", {{"point", point}}, 61, 37);
      for (std::size_t i = 0; i < none.radiance.size(); ++i) {
        ASSERT_EQ(none.radiance[i], vertices.radiance[i]) << "pixel " << i;
        ASSERT_EQ(static_cast<float>(none.maps.at("from_vertices")[i]), vertices.radiance[i].w) << "pixel " << i;
      }
      EXPECT_EQ(none.counters.at("stored_triangles"), 0u);
    }
}

TEST(Dais, AFullBufferLeavesOutTheLastTriangles) {
  const capture::Capture capture = little_grass();
  const TechniqueRun all = run_technique(capture, "dais", {{"samples", 4}}, 61, 37);
  const auto triangles = all.counters.at("visible_triangles");
  ASSERT_GT(triangles, 400u);
  // As many as hold, counted by the map: nothing but triangles too thin for planes.
  const double thin = sum_of(all.maps.at("from_vertices"));
  EXPECT_EQ(thin > 0, all.counters.at("triangles_without_planes") > 0);
  double before = all.executions();
  for (const double share : {0.25, 0.5, 0.75}) {
    const double pool = share * static_cast<double>(triangles) / (61 * 37);
    const TechniqueRun part = run_technique(capture, "dais", {{"samples", 4}, {"pool", pool}}, 61, 37);
    EXPECT_NEAR(static_cast<double>(part.counters.at("stored_triangles")), share * static_cast<double>(triangles), 1);
    EXPECT_EQ(part.counters.at("visible_triangles"), triangles);
    const double outside = sum_of(part.maps.at("from_vertices"));
    EXPECT_LT(outside, before);
    EXPECT_GT(outside, thin);
    before = outside;
    EXPECT_LT(mean_squared_difference(all, part), 2e-6);
    EXPECT_FALSE(all.radiance == part.radiance);
  }
}

TEST(Dais, ReportsTheTrianglesThatItStores) {
  // Ten words, and three for each scalar of normal and coordinates.
  constexpr double kBytes = 4 * (10 + 3 * (3 + 2));
  const TechniqueRun run = run_technique(little_grass(), "dais", {}, 61, 37);
  EXPECT_NEAR(run.paper_bytes_per_pixel,
              64 + kBytes * static_cast<double>(run.counters.at("stored_triangles")) / (61 * 37), 1e-9);
  EXPECT_EQ(DAIS_WORDS(FEATURE_NORMAL_MAP | FEATURE_SECOND_UV | FEATURE_VERTEX_COLOUR), 10u + 3u * (3 + 2 + 2 + 4 + 4));
  // A triangle over all of the screen is stored once, for all of its pixels.
  const TechniqueRun full = run_technique(scene_of("hard_fullscreen", 1), "dais", {}, 61, 37);
  EXPECT_LE(full.counters.at("stored_triangles"), 2u);
}

TEST(Dais, HoldsToWhatAllTechniquesHoldTo) {
  for (const int samples : {1, 2, 8, 64}) expect_plain_sky("dais", {{"samples", samples}});
  expect_same_on_all_threads("dais", {});
  expect_same_on_all_threads("dais", {{"samples", 32}, {"point", "covered"}, {"pool", 0.2}});
  expect_refused("dais", {{"samples", 3}});
  expect_refused("dais", {{"pool", -1}});
  expect_refused("dais", {{"point", "corner"}});
}

}  // namespace
}  // namespace subpixel::replay
