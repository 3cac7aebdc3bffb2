// Frames in bands of rows: the same bits as whole ones, whatever the budget of memory, by every technique of the
// registry; and what cannot be drawn within a budget.
#include "replay/frame/banded_frame.hpp"

#include <bit>

#include "base/error.hpp"
#include "replay/techniques/registry.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

// Odd, with a last band that is smaller than the others.
constexpr std::uint32_t kWidth = 61, kHeight = 117;

struct Drawn {
  FrameImages images;
  Memory memory;
  std::map<std::string, std::uint64_t> counters, fragments;
};

class Banded : public testing::TestWithParam<const Technique*> {
 protected:
  void TearDown() override { test_device().ledger().set_budget(std::nullopt); }

  Drawn draw(FrameScene& scene, const ParameterValues& given, std::optional<std::uint64_t> budget) const {
    gpu::MemoryLedger& ledger = test_device().ledger();
    ledger.set_budget(budget);
    Drawn drawn;
    {
      BandedFrame frame(scene, GetParam()->with(given));
      frame.time(1);
      drawn.fragments = frame.fragments();
      drawn.counters = frame.counters();
      drawn.memory = frame.memory();
      drawn.images = frame.images();
    }
    ledger.set_budget(std::nullopt);
    ledger.reset_peak();
    EXPECT_EQ(ledger.peak(), 0u) << "something is held yet";
    return drawn;
  }
};

void expect_same_floats(const std::vector<float>& a, const std::vector<float>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a[i]), std::bit_cast<std::uint32_t>(b[i]))
        << what << " at " << i << ": " << a[i] << ", " << b[i];
}

void expect_same(const Drawn& whole, const Drawn& bands) {
  expect_same_floats(whole.images.radiance.pixels, bands.images.radiance.pixels, "radiance");
  expect_same_floats(whole.images.display.pixels, bands.images.display.pixels, "display");
  expect_same_floats(whole.images.executions, bands.images.executions, "executions");
  ASSERT_EQ(whole.images.maps.size(), bands.images.maps.size());
  for (const auto& [name, values] : whole.images.maps) EXPECT_EQ(values, bands.images.maps.at(name)) << name;
  EXPECT_EQ(whole.counters, bands.counters);
  EXPECT_EQ(whole.fragments, bands.fragments);
  EXPECT_EQ(whole.memory.paper_bytes, bands.memory.paper_bytes);
}

// The bytes that a refusal names as the least budget.
std::uint64_t least_of(const std::string& refusal) {
  const std::string_view before = " needs ";
  EXPECT_NE(refusal.find(before), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--memory"), std::string::npos) << refusal;
  return std::stoull(refusal.substr(refusal.find(before) + before.size()));
}

// Of foliage alpha-tested and deep, of the city with large triangles, some clipped; of two frames for histories. A
// budget that is too small names the least one, which works, and a byte less does not.
TEST_P(Banded, LeavesTheBitsOfTheWholeFrame) {
  for (const std::string name : {"foliage", "city"}) {
    SCOPED_TRACE(name);
    FrameScene scene(test_device(), capture::generate(name, {2, kWidth, kHeight, 1, 0.05}), {}, {1, 0, 0});
    const Drawn whole = draw(scene, {}, std::nullopt);
    EXPECT_EQ(whole.memory.bands, 1u);
    EXPECT_GE(whole.memory.peak_bytes, whole.memory.allocated_bytes);
    std::string refusal;
    try {
      draw(scene, {}, 4096);
    } catch (const UsageError& error) {
      refusal = error.what();
    }
    const std::uint64_t least = least_of(refusal);
    EXPECT_NE(refusal.find(GetParam()->name), std::string::npos) << refusal;
    ASSERT_LT(least, whole.memory.peak_bytes);
    std::uint32_t bands = 1;
    std::vector<std::uint64_t> budgets{(least + whole.memory.peak_bytes) / 2};
    if (name == "foliage") budgets.push_back(least);
    for (const std::uint64_t budget : budgets) {
      SCOPED_TRACE(budget);
      const Drawn banded = draw(scene, {}, budget);
      EXPECT_GT(banded.memory.bands, 1u);
      EXPECT_GE(banded.memory.bands, bands);
      EXPECT_LE(banded.memory.peak_bytes, budget);
      bands = banded.memory.bands;
      expect_same(whole, banded);
    }
    // For histories both of a step are counted at once, so that the named budget may be a little too large.
    const bool keeps_history = std::string_view(GetParam()->name) == "taa";
    if (name == "foliage" && !keeps_history) {
      EXPECT_THROW(draw(scene, {}, least - 1), UsageError);
    }
    expect_same(whole, draw(scene, {}, whole.memory.peak_bytes + (1 << 20)));
  }
}

INSTANTIATE_TEST_SUITE_P(Techniques, Banded,
                         testing::ValuesIn(std::vector<const Technique*>(techniques().begin(), techniques().end())),
                         [](const auto& tested) { return std::string(tested.param->name); });

}  // namespace
}  // namespace subpixel::replay
