// The table of half-plane coverage that decoupled coverage anti-aliasing looks masks up in.
// Wang, Wyman, He and Sen 2015, section 3.1 and figure 3; after Waller et al. 2000.
#pragma once

#include <cstdint>
#include <vector>

namespace subpixel::replay {

struct CoverageTableSize {
  std::uint32_t directions = 256;  // of edges, over the whole turn; a power of two from 8
  std::uint32_t distances = 128;   // of the edge from the pixel's centre, over the pixel's width

  // Every direction has two more entries, for edges that pass the pixel by: nothing and everything.
  std::uint32_t entries() const { return directions * (distances + 2); }
};

// Masks of the `samples` (16, 32 or 64) to the left of an edge, sample i in bit i, by direction and then distance as
// shaders/techniques/dcaa/coverage.glsl finds them. Directions are spaced evenly along the diamond |a| + |b| = 1. Of
// two edges of one line in opposite directions, the table has each sample in exactly one.
std::vector<std::uint64_t> coverage_table(const CoverageTableSize& size, std::uint32_t samples);

// The entry of the half-plane base + a x + b y >= 0 over samples (x, y) in 1/128 pixel from the pixel's centre.
std::uint32_t coverage_table_entry(const CoverageTableSize& size, double base, double a, double b);

}  // namespace subpixel::replay
