// Pixels' streams through the transcription, and the state words that the shaders left for the same pixels.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "shaders/tests/streaming_test_interface.h"
#include "tests/technique/streaming_words.hpp"

namespace subpixel::streaming_test {

struct StreamFragment {
  DepthBufferPlane plane;
  Surface surface;
};

// `slopes`: as half2. What the layout does not keep is 0.
inline StreamFragment stream_fragment(const gpu_types::StreamTestFragment& f, std::uint32_t slopes,
                                      const WordLayout& layout) {
  Surface s;
  s.depth = f.depth.x;
  s.slope_x = static_cast<std::uint16_t>(slopes);
  s.slope_y = static_cast<std::uint16_t>(slopes >> 16);
  s.coverage = f.words.x;
  for (std::size_t c = 0; c < 4; ++c) s.albedo[c] = static_cast<std::uint8_t>(f.words.y >> (8 * c));
  s.normal = f.words.z;
  s.roughness = layout.keeps_roughness() ? static_cast<std::uint8_t>(f.words.w) : 0;
  s.emission = layout.emissive ? f.more.x : 0;
  return {{f.plane.x, f.plane.y, f.plane.z, f.plane.w, f.depth.w}, s};
}

// Fragments pixel after pixel, each pixel's in submission order.
struct PixelStreams {
  std::vector<StreamFragment> fragments;
  std::vector<std::size_t> ends;  // of each pixel
};

// What the transcription made of streams.
struct Totals {
  std::uint64_t pixels = 0, fragments = 0;  // fragments that cover a sample
  std::uint64_t several = 0;                // pixels of more than one of those
  std::uint64_t merges = 0, dropped = 0, flags = 0, full = 0;
  Totals& operator+=(const Totals& more) {
    pixels += more.pixels;
    fragments += more.fragments;
    several += more.several;
    merges += more.merges;
    dropped += more.dropped;
    flags += more.flags;
    full += more.full;
    return *this;
  }
};

// The counters of the count word stop at their largest value.
inline Pixel as_counted(Pixel pixel) {
  pixel.merges = std::min(pixel.merges, (1u << STREAM_MERGES_BITS) - 1);
  pixel.dropped_samples = std::min(pixel.dropped_samples, (1u << STREAM_DROPPED_BITS) - 1);
  return pixel;
}

// Bit for bit: every surface, the depth buffer, order, flag and counts of every pixel. `words`: the pixels' states.
inline Totals expect_same_surfaces(const Options& options, const WordLayout& layout, const PixelStreams& streams,
                                   std::span<const std::uint32_t> words) {
  Totals totals;
  std::uint32_t wrong = 0;
  const std::size_t stride = layout.quads() * 4;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < streams.ends.size(); begin = streams.ends[i++]) {
    Compressor paper(options);
    std::uint32_t covering = 0;
    for (std::size_t k = begin; k < streams.ends[i]; ++k) {
      paper.add(streams.fragments[k].plane, streams.fragments[k].surface);
      covering += streams.fragments[k].surface.coverage != 0;
    }
    const Pixel expected = as_counted(paper.pixel());
    const Pixel device = read_state(layout, words.subspan(i * stride, stride));
    if (device != expected && ++wrong == 1)
      std::printf("first difference: pixel %zu of %u fragments: %zu and %zu surfaces\n", i, covering,
                  device.surfaces.size(), expected.surfaces.size());
    ++totals.pixels;
    totals.fragments += covering;
    totals.several += covering > 1;
    totals.merges += expected.merges;
    totals.dropped += expected.dropped_samples;
    totals.flags += expected.discarded;
    totals.full += expected.surfaces.size() == options.surfaces;
  }
  EXPECT_EQ(wrong, 0u) << "of " << totals.pixels << " pixels";
  return totals;
}

}  // namespace subpixel::streaming_test
