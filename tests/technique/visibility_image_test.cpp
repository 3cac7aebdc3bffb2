// `visibility` and `forward`: the bits of fragments that are lit as they are drawn, and their lists against the samples
// of the visibility image, counted on the host.
#include <map>

#include "replay/techniques/deferred.hpp"

#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

capture::Capture scene_of(const std::string& name, double density) {
  return capture::generate(name, {1, 61, 37, 1, density});
}

// Forward shading as the device's rasteriser does it: each fragment is lit where it is drawn and blended into its
// pixel.
TechniqueRun drawn(const capture::Capture& capture, const ParameterValues& given) {
  FrameScene scene(test_device(), capture, {}, {0, 61, 37});
  const TechniqueSetting setting = find_technique("forward").with(given);
  FrameOutputs outputs;
  const FrameSetup setup = prepare_frame(scene, setting, outputs);
  gpu::PassRecorder recorder(test_device());
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, setup);
  gpu::Image& sum = sum_image(recorder, setup);

  gpu::RasterPass background = lighting_pass(setup, "background", "tests/forward_background.frag");
  background.pipeline.targets.clear = true;
  background.colours = {{sum}};
  background.clear_colours = {{}};
  background.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  recorder.raster(std::move(background));

  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  geometry.fragment_opaque = "tests/forward.frag";
  geometry.pass.name = "forward";
  geometry.pass.pipeline.constants = common_constants(setup);
  geometry.pass.pipeline.additive = true;
  geometry.pass.colours = {{sum}};
  geometry.pass.bindings = light_bindings(setup);
  geometry.pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  setup.frontend.record_geometry(recorder, std::move(geometry));
  record_resolve(recorder, setup, sum);
  recorder.run();
  return technique_run(download_images(test_device(), outputs));
}

TEST(Visibility, LeavesTheBitsOfForwardShading) {
  for (const int samples : {4, 8, 16, 32, 64}) {
    const TechniqueRun run = run_technique(little_grass(), "visibility", {{"samples", samples}}, 61, 37);
    expect_valid(run, static_cast<std::uint32_t>(samples));
    EXPECT_TRUE(run == drawn(little_grass(), {{"samples", samples}})) << samples;
    EXPECT_TRUE(run == run_technique(little_grass(), "forward", {{"samples", samples}}, 61, 37)) << samples;
  }
  // Large, alpha-tested, clipped and coinciding triangles, textures and emission.
  for (const auto& [name, density] : std::vector<std::pair<std::string, double>>{
           {"city", 0.05}, {"foliage", 0.02}, {"arcade", 0.05}, {"hard_coplanar", 1}, {"hard_near_plane", 1}})
    for (const char* resolve : {"linear", "tone_mapped"}) {
      const capture::Capture capture = scene_of(name, density);
      EXPECT_TRUE(run_technique(capture, "visibility", {{"resolve", resolve}}, 61, 37) ==
                  drawn(capture, {{"resolve", resolve}}))
          << name << " " << resolve;
    }
}

// A triangle and the samples of a pixel that show it, in bits.
using Shown = std::map<std::uint32_t, std::uint64_t>;

TEST(Visibility, ListsEachTriangleOfAPixelOnceWithItsSamples) {
  for (const std::uint32_t samples : {1u, 2u, 4u, 8u, 16u, 32u, 64u}) {
    SCOPED_TRACE(samples);
    FrontendRun run(test_device(), scene_of("city", 0.05), 61, 37, samples);
    const FragmentListSizes sizes = measure_visible_fragments(run.setup());
    run.frontend.record_setup(run.recorder);
    const FragmentLists lists = record_visible_fragments(run.recorder, run.setup(), *run.visibility, sizes, "list");
    run.run();
    std::vector<Shown> expected(61 * 37);
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (std::uint32_t s = 0; s < samples; ++s)
        if (const std::uint32_t triangle = run.seen()[i * samples + s].triangle; triangle != SUBPIXEL_NO_TRIANGLE)
          expected[i][triangle] |= std::uint64_t{1} << s;
      count += expected[i].size();
    }
    ASSERT_GT(count, 1000u);
    ASSERT_EQ(sizes.count, count);
    const auto fragments = lists.fragments->as<glm::uvec4>();
    const auto numbers = lists.numbers->as<std::uint32_t>();
    const auto ends = lists.ends->as<std::uint32_t>();
    std::vector<bool> listed(count);
    for (std::uint32_t i = 0; i < expected.size(); ++i) {
      Shown found;
      for (std::uint32_t k = i == 0 ? 0 : ends[i - 1]; k < ends[i]; ++k) {
        ASSERT_LT(numbers[k], count);
        ASSERT_FALSE(listed[numbers[k]]) << "pixel " << i;
        listed[numbers[k]] = true;
        const glm::uvec4 fragment = fragments[numbers[k]];
        ASSERT_EQ(fragment.y, i % 61 | i / 61 << 16);
        found[fragment.x] |= fragment.z | std::uint64_t{fragment.w} << 32;
      }
      ASSERT_EQ(found, expected[i]) << "pixel " << i;
    }
    // Whole batches: each fragment is of the batch's material.
    std::uint64_t last = 0;
    for (const FragmentLists::Batch& batch : sizes.batches) {
      ASSERT_EQ(batch.first, last);
      last = batch.last;
      for (std::uint64_t i = batch.first; i < batch.last; ++i)
        ASSERT_EQ(
            run.frontend.records().as<gpu_types::TriangleRecord>()[fragments[i].x].v2_ref.w >> RECORD_MATERIAL_SHIFT,
            batch.material);
    }
    EXPECT_EQ(last, count);
  }
}

TEST(Visibility, LightsWhereSamplesShow) {
  const capture::Capture capture = little_grass();
  const TechniqueRun covered = run_technique(capture, "visibility", {}, 61, 37);
  const TechniqueRun visible = run_technique(capture, "visibility", {{"point", "visible"}}, 61, 37);
  expect_valid(visible, 8);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < covered.radiance.size(); ++i) {
    ASSERT_EQ(covered.radiance[i].w, visible.radiance[i].w) << "pixel " << i;
    moved += covered.radiance[i] != visible.radiance[i] ? 1 : 0;
  }
  EXPECT_GT(moved, 100u);
  EXPECT_LT(mean_squared_difference(covered, visible), 1e-4);
  // One triangle over all samples is lit at the pixel's centre either way.
  const capture::Capture full = scene_of("hard_fullscreen", 1);
  EXPECT_TRUE(run_technique(full, "visibility", {}, 61, 37) ==
              run_technique(full, "visibility", {{"point", "visible"}}, 61, 37));
}

TEST(Visibility, ReportsEightBytesASample) {
  for (const int samples : {1, 4, 8, 64})
    EXPECT_EQ(run_technique(little_grass(), "visibility", {{"samples", samples}}, 61, 37).paper_bytes_per_pixel,
              8.0 * samples);
}

TEST(Visibility, HoldsToWhatAllTechniquesHoldTo) {
  for (const int samples : {1, 2, 8, 64}) expect_plain_sky("visibility", {{"samples", samples}});
  expect_same_on_all_threads("visibility", {});
  expect_same_on_all_threads("visibility", {{"samples", 32}, {"point", "visible"}});
  expect_refused("visibility", {{"samples", 3}});
  expect_refused("visibility", {{"point", "corner"}});
}

}  // namespace
}  // namespace subpixel::replay
