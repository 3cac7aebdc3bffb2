// `linked_list`: its images beside those of forward shading and of full samples, and the publication's table of memory.
#include <numeric>

#include "shaders/techniques/linked_list/linked_list_interface.h"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

TechniqueRun run_grass(std::string_view technique, const ParameterValues& given) {
  return run_technique(little_grass(), technique, given, kWidth, kHeight);
}

TEST(LinkedList, ShadesEveryVisibleFragmentOnceAsForwardDoes) {
  for (const int samples : {4, 8}) {
    const TechniqueRun lists = run_grass("linked_list", {{"samples", samples}});
    const TechniqueRun forward = run_grass("forward", {{"samples", samples}});
    expect_valid(lists, static_cast<std::uint32_t>(samples));
    for (std::size_t i = 0; i < lists.radiance.size(); ++i)
      ASSERT_EQ(lists.radiance[i].w, forward.radiance[i].w) << "pixel " << i;
    // Positions are those of one sample and not of the middle, attributes are rounded to their bits.
    EXPECT_LT(mean_squared_difference(lists, forward), 1e-4);
    EXPECT_LT(mean_squared_difference(lists, run_grass("msaa", {{"samples", samples}})), 1e-4);
  }
}

TEST(LinkedList, SameImageHoweverBlocksAreGivenOut) {
  for (const int samples : {2, 8}) {
    const TechniqueRun expected = run_grass("linked_list", {{"samples", samples}});
    for (const char* allocation : {"tiles", "atomic"})
      EXPECT_TRUE(expected == run_grass("linked_list", {{"samples", samples}, {"allocation", allocation}}))
          << allocation << " " << samples;
    // The chosen sample decides only where pixels that sample 0 sees through are kept.
    const auto lists = [&](const char* first) {
      return run_grass("linked_list", {{"samples", samples}, {"first_block", first}, {"lighting", "lists"}});
    };
    EXPECT_TRUE(lists("sample") == lists("covered")) << samples;
  }
}

TEST(LinkedList, LightingByBlocksShowsWhatListsShow) {
  for (const double pool : {7.0, 0.3}) {
    const TechniqueRun blocks = run_grass("linked_list", {{"pool", pool}, {"lighting", "blocks"}});
    const TechniqueRun lists = run_grass("linked_list", {{"pool", pool}, {"lighting", "lists"}});
    EXPECT_EQ(blocks.maps, lists.maps);
    bool rounded = false;
    for (std::size_t i = 0; i < lists.radiance.size(); ++i) {
      ASSERT_EQ(blocks.radiance[i].w, lists.radiance[i].w) << "pixel " << i;
      // Lit values are kept with 14 significant bits.
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(blocks.radiance[i][c], lists.radiance[i][c], 0x1p-14f * lists.radiance[i][c] + 1e-6f)
            << "pixel " << i;
        rounded = rounded || blocks.radiance[i][c] != lists.radiance[i][c];
      }
    }
    EXPECT_TRUE(rounded);
  }
}

TEST(LinkedList, ErrorFallsWithThePool) {
  const TechniqueRun all = run_grass("linked_list", {{"lighting", "lists"}});
  const auto blocks = all.maps.at("blocks");
  const double needed = std::accumulate(blocks.begin(), blocks.end(), 0.0) / static_cast<double>(blocks.size());
  for (const char* first : {"sample", "covered"}) {
    double before = 1;
    for (int step = 0; step <= 8; ++step) {
      const TechniqueRun run =
          run_grass("linked_list", {{"pool", needed * step / 8}, {"first_block", first}, {"lighting", "lists"}});
      const double error = mean_squared_difference(run, all);
      EXPECT_LT(error, before) << first << " " << step;
      before = error > 0 ? error : 1e-30;
      if (error == 0) break;
    }
    EXPECT_EQ(before, 1e-30);
  }
  // Without dynamic blocks a pixel shows one surface: in full where the chosen sample is covered, else none.
  const TechniqueRun none = run_grass("linked_list", {{"pool", 0}});
  for (const auto& pixel : none.radiance) ASSERT_LE(pixel.w, 1.0f);
}

// Table 1, at 1920x1080 in MiB. The columns without lists follow from the same block: no pointer, roughness and
// occlusion in a word of their own.
TEST(LinkedList, MemoryIsThatOfThePublicationsTable) {
  FrameScene scene(test_device(), flat_capture(1920, 1080));
  FrameOutputs outputs;
  const auto mib = [&](const ParameterValues& given, bool depth) {
    const TechniqueSetting setting = find_technique("linked_list").with(given);
    const FrameSetup setup = prepare_frame(scene, setting, outputs);
    double bits = 0;
    for (const auto& entry : setting.technique->layout(setup))
      if ((entry.name == "depth") == depth) bits += entry.bits_per_pixel;
    return std::round(bits / 8 * 1920 * 1080 / 1024 / 1024 * 100) / 100;
  };
  EXPECT_EQ(mib({{"pool", 0}, {"samples", 4}}, false), 27.69);
  EXPECT_EQ(mib({{"pool", 0}, {"samples", 8}}, false), 27.69);
  EXPECT_EQ(mib({{"samples", 4}}, false), 110.74);
  EXPECT_EQ(mib({{"samples", 8}}, false), 221.48);
  EXPECT_EQ(mib({{"samples", 4}}, true), 31.64);
  EXPECT_EQ(mib({{"samples", 8}}, true), 63.28);
  EXPECT_EQ(mib({{"samples", 2}}, true), 15.82);
  const auto full_samples_mib = [](int samples) {
    const int bits = (LINK_BLOCK_BITS - LINK_POINTER_BITS + 16) * samples;
    return std::round(bits / 8.0 * 1920 * 1080 / 1024 / 1024 * 100) / 100;
  };
  EXPECT_EQ(full_samples_mib(1), 23.73);
  EXPECT_EQ(full_samples_mib(4), 94.92);
  EXPECT_EQ(full_samples_mib(8), 189.84);
}

TEST(LinkedList, PlainSky) {
  for (const char* allocation : {"largest", "tiles", "atomic"})
    expect_plain_sky("linked_list", {{"allocation", allocation}});
  expect_plain_sky("linked_list", {{"samples", 2}, {"first_block", "covered"}});
}

TEST(LinkedList, SameOnAllThreads) {
  expect_same_on_all_threads("linked_list", {});
  expect_same_on_all_threads("linked_list", {{"allocation", "atomic"}});
  expect_same_on_all_threads("linked_list", {{"lighting", "lists"}});
}

TEST(LinkedList, SameOnAllThreadsWhenThePoolIsTooSmall) {
  expect_same_on_all_threads("linked_list", {{"pool", 0.3}});
  expect_same_on_all_threads("linked_list", {{"pool", 0.3}, {"allocation", "tiles"}});
}

TEST(LinkedList, RefusesParametersOutOfRange) {
  expect_refused("linked_list", {{"samples", 16}});
  expect_refused("linked_list", {{"pool", -1}});
  expect_refused("linked_list", {{"pool_unit", "miles"}});
  expect_refused("linked_list", {{"allocation", "fair"}});
  expect_refused("linked_list", {{"first_block", "last"}});
}

}  // namespace
}  // namespace subpixel::replay
