// `linked_list`: what the pool holds after the passes, at every size of it, against the fragments that visibility
// shows.
#include <fmt/format.h>

#include <numeric>
#include <random>

#include "tests/technique/linked_list_fixture.hpp"

namespace subpixel::replay {
namespace {

// Emitters of exactly storable radiance, overlapping at random, with holes through which the black sky shows; nothing
// else lights them, so a pixel's radiance is the mean of its samples' emissions.
capture::Capture emitters(std::uint32_t width, std::uint32_t height, int triangles) {
  capture::Capture capture = flat_capture(width, height);
  capture.frames[0].ambient = {0, 0, 0};
  std::mt19937 random(7);
  const auto unit = [&] { return static_cast<float>(random() % 10000) / 10000; };
  for (int i = 0; i < triangles; ++i) {
    const capture::Float3 radiance{static_cast<float>(random() % 8) / 8, static_cast<float>(random() % 8) / 8, 1};
    const float x = 2 * unit() - 1, y = 2 * unit() - 1, z = 2 * unit() - 1;
    add_triangles(capture,
                  {x, y, z, x + 0.1f + 0.4f * unit(), y + 0.3f * (unit() - 0.5f), z, x + 0.3f * (unit() - 0.5f),
                   y + 0.1f + 0.4f * unit(), z},
                  add_emitter(capture, radiance));
  }
  return capture;
}

struct Kind {
  const char* allocation;
  const char* first_block;
  int samples;
  // Lists leave the attributes in the blocks; lighting by blocks puts lit values there.
  const char* lighting = "lists";
};

class LinkedListPool : public testing::TestWithParam<Kind> {
 protected:
  ParameterValues parameters() const {
    return {{"allocation", GetParam().allocation},
            {"first_block", GetParam().first_block},
            {"samples", GetParam().samples},
            {"lighting", GetParam().lighting}};
  }
  bool first_covered() const { return std::string(GetParam().first_block) == "covered"; }
  bool attributes() const { return std::string(GetParam().lighting) == "lists"; }
  bool atomic() const { return std::string(GetParam().allocation) == "atomic"; }
};

// Of scenes whose blocks differ: without metal, with metal and varying roughness, and with emission besides.
TEST_P(LinkedListPool, HoldsEveryVisibleFragmentOnce) {
  for (const std::string_view name : {"grass", "tubes", "city"}) {
    SCOPED_TRACE(name);
    ListScene scene(name == "grass" ? little_grass() : capture::generate(name, {1, 61, 37, 1, 0.3}), 61, 37);
    const FragmentOracle oracle(scene, static_cast<std::uint32_t>(GetParam().samples));
    const std::uint64_t wanted = oracle.wanted_blocks(first_covered());
    ASSERT_GT(wanted, 200u);
    // More than enough, exactly enough, and half.
    for (const std::uint64_t blocks : {wanted + 1000, wanted, wanted / 2}) {
      SCOPED_TRACE(testing::Message() << blocks << " of " << wanted << " blocks");
      expect_consistent(scene.run(parameters(), blocks), oracle, first_covered(), !atomic(), attributes());
      if (HasFailure()) return;
    }
  }
}

// Radiance of a pixel whose samples show what the lists say.
glm::dvec3 expected_radiance(const FragmentOracle& oracle, const StoredFragments& stored, std::size_t pixel,
                             bool first_covered) {
  const auto emission = [](const VisibleFragment& f) {
    const std::uint32_t e = f.attributes.emission;
    return glm::dvec3(e & 511u, e >> 9 & 511u, e >> 18 & 511u) * std::exp2(static_cast<int>(e >> 27) - 24);
  };
  const VisibleFragment* const own = oracle.own(pixel, first_covered);
  glm::dvec3 sum(0);
  for (const VisibleFragment& f : oracle.fragments(pixel)) {
    const bool has_block = &f == own || stored.contains({pixel, static_cast<std::uint32_t>(std::countr_zero(f.mask))});
    if (has_block || own) sum += static_cast<double>(f.count()) * (has_block ? emission(f) : emission(*own));
  }
  return sum / static_cast<double>(oracle.samples());
}

std::uint64_t total(const std::vector<std::uint32_t>& map) {
  return std::accumulate(map.begin(), map.end(), std::uint64_t{0});
}

TEST_P(LinkedListPool, EverySizeFromNothingUp) {
  ListScene scene(emitters(21, 13, 30), 21, 13);
  const FragmentOracle oracle(scene, static_cast<std::uint32_t>(GetParam().samples));
  const std::uint64_t wanted = oracle.wanted_blocks(first_covered());
  ASSERT_GT(wanted, 15u);
  const ListRun all = scene.run(parameters(), wanted);
  StoredFragments before;
  std::uint64_t overflow_before = ~std::uint64_t{0}, wrong_before = ~std::uint64_t{0};
  for (std::uint64_t blocks = 0; blocks <= wanted + 2; ++blocks) {
    SCOPED_TRACE(testing::Message() << blocks << " of " << wanted << " blocks");
    const ListRun run = scene.run(parameters(), blocks);
    const StoredFragments stored = expect_consistent(run, oracle, first_covered(), !atomic(), attributes());
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < oracle.pixels(); ++i) {
      if (oracle.samples() > 2) {
        const glm::dvec3 expected = expected_radiance(oracle, stored, i, first_covered());
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(run.run.radiance[i][c], expected[c], 1e-5) << "pixel " << i;
      }
      const bool same = std::memcmp(&run.run.radiance[i], &all.run.radiance[i], sizeof(glm::vec4)) == 0;
      ASSERT_TRUE(same || run.run.maps.at("overflow")[i] != 0) << "pixel " << i;
      wrong += same ? 0 : 1;
    }
    // Degrades monotonically: what had a block keeps it when there are more. Which fragments those are is the
    // counter's secret, so for it the totals alone are compared, and they are exact all the same.
    if (!atomic()) {
      const std::uint64_t overflow = total(run.run.maps.at("overflow"));
      ASSERT_TRUE(std::ranges::includes(stored, before));
      ASSERT_TRUE(overflow < overflow_before || blocks > wanted) << overflow;
      ASSERT_LE(wrong, wrong_before);
      overflow_before = overflow;
    }
    wrong_before = wrong;
    before = stored;
    if (HasFailure()) return;
  }
  EXPECT_EQ(wrong_before, 0u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, LinkedListPool,
                         testing::Values(Kind{"largest", "sample", 2}, Kind{"largest", "sample", 4},
                                         Kind{"largest", "sample", 8}, Kind{"largest", "covered", 8},
                                         Kind{"tiles", "sample", 8}, Kind{"tiles", "covered", 4},
                                         Kind{"atomic", "sample", 8}, Kind{"atomic", "covered", 4},
                                         Kind{"atomic", "sample", 2}, Kind{"largest", "sample", 8, "blocks"},
                                         Kind{"atomic", "covered", 4, "blocks"}),
                         [](const auto& kind) {
                           return fmt::format("{}_{}_{}_{}", kind.param.allocation, kind.param.first_block,
                                              kind.param.samples, kind.param.lighting);
                         });

TEST(LinkedListAllocation, TheLargestFragmentsComeFirst) {
  ListScene scene(little_grass(), 61, 37);
  const FragmentOracle oracle(scene, 8);
  std::vector<std::uint32_t> counts;
  for (std::size_t i = 0; i < oracle.pixels(); ++i)
    for (const auto& f : oracle.fragments(i))
      if (&f != oracle.own(i, false)) counts.push_back(f.count());
  std::ranges::sort(counts, std::greater<>());
  std::uint64_t largest_lost = 0, tiles_lost = 0;
  for (const std::size_t blocks : {std::size_t{0}, counts.size() / 5, counts.size() / 2, counts.size() - 3}) {
    // No choice of as many fragments leaves fewer samples without theirs.
    const std::uint64_t least =
        std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(blocks), counts.end(), std::uint64_t{0});
    const ListRun largest = scene.run({{"allocation", "largest"}}, blocks);
    EXPECT_EQ(total(largest.run.maps.at("overflow")), least);
    largest_lost += least;
    tiles_lost += total(scene.run({{"allocation", "tiles"}}, blocks).run.maps.at("overflow"));
  }
  EXPECT_GT(tiles_lost, largest_lost);
}

TEST(LinkedListAllocation, BudgetsInEveryUnit) {
  const auto dynamic = [](const ParameterValues& given) {
    FrameScene scene(test_device(), flat_capture(100, 50));
    FrameOutputs outputs;
    const TechniqueSetting setting = find_technique("linked_list").with(given);
    return linked_list_dynamic_blocks(LinkedListSetup(prepare_frame(scene, setting, outputs)));
  };
  EXPECT_EQ(dynamic({}), 7u * 5000);
  EXPECT_EQ(dynamic({{"samples", 4}}), 3u * 5000);
  EXPECT_EQ(dynamic({{"samples", 2}}), 5000u);
  EXPECT_EQ(dynamic({{"pool", 0}}), 0u);
  EXPECT_EQ(dynamic({{"pool", 0.25}}), 1250u);
  EXPECT_EQ(dynamic({{"pool", 17}, {"pool_unit", "blocks"}}), 17u);
  EXPECT_EQ(dynamic({{"pool", 17.9}, {"pool_unit", "blocks"}}), 17u);
  // 12 bytes a block of a scene without metal.
  EXPECT_EQ(dynamic({{"pool", 0.1}, {"pool_unit", "mib"}}), 8738u);
  EXPECT_EQ(dynamic({{"pool", 1e9}, {"pool_unit", "mib"}}), 7u * 5000);
}

}  // namespace
}  // namespace subpixel::replay
