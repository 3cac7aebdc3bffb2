// The grids that items are dealt out to, up to more than one row of workgroups holds.
#include "replay/frontend/list_passes.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace subpixel::replay {
namespace {

TEST(DealtGrid, HoldsAllItemsWithinTheLimits) {
  for (const std::uint64_t items :
       {0ull, 1ull, 64ull, 65ull, 4'194'240ull, 4'194'241ull, 10'000'000ull, 268'435'456ull, 4'000'000'000ull}) {
    const auto [columns, rows, layers] = dealt_grid_of(items);
    EXPECT_GE(std::uint64_t{columns} * rows * 64, items) << items;
    EXPECT_GE(columns, 1u) << items;
    EXPECT_LE(columns, kMostGroups) << items;
    EXPECT_LE(rows, kMostGroups) << items;
    EXPECT_EQ(layers, 1u);
    // No more than a row's rest is idle.
    EXPECT_LT(std::uint64_t{columns} * rows, items / 64 + 1 + rows) << items;
  }
}

}  // namespace
}  // namespace subpixel::replay
