// Reads a pixel's state words (shaders/techniques/streaming/state.glsl) back into the transcription's surfaces.
#pragma once

#include <span>

#include "shaders/techniques/streaming/streaming_interface.h"
#include "tests/technique/streaming_transcription.hpp"

namespace subpixel::streaming_test {

struct WordLayout {
  std::uint32_t samples = 8, surfaces = 3;
  bool varying_roughness = false, emissive = false;
  std::uint32_t surface_words() const {
    return 5 + (samples == 32) + (samples > 8 && varying_roughness) + (emissive ? 1 : 0);
  }
  std::uint32_t quads() const { return (samples + 1 + surfaces * surface_words() + 3) / 4; }
  bool keeps_roughness() const { return samples <= 8 || varying_roughness; }
};

// Surfaces come in the order of the count word; roughness is 0 where the layout has none.
inline Pixel read_state(const WordLayout& layout, std::span<const std::uint32_t> words) {
  Pixel pixel;
  for (std::uint32_t i = 0; i < layout.samples; ++i) pixel.depth_buffer.push_back(std::bit_cast<float>(words[i]));
  const std::uint32_t word = words[layout.samples];
  pixel.discarded = (word >> STREAM_DISCARD_SHIFT & 1u) != 0;
  pixel.merges = word >> STREAM_MERGES_SHIFT & ((1u << STREAM_MERGES_BITS) - 1);
  pixel.dropped_samples = word >> STREAM_DROPPED_SHIFT & ((1u << STREAM_DROPPED_BITS) - 1);
  const std::uint32_t count = word & ((1u << STREAM_COUNT_BITS) - 1);
  for (std::uint32_t place = 0; place < count; ++place) {
    const std::uint32_t slot = word >> (STREAM_ORDER_SHIFT + 2 * place) & 3u;
    const auto w = words.subspan(layout.samples + 1 + slot * layout.surface_words(), layout.surface_words());
    Surface s;
    s.depth = std::bit_cast<float>(w[0]);
    s.slope_x = static_cast<std::uint16_t>(w[1]);
    s.slope_y = static_cast<std::uint16_t>(w[1] >> 16);
    if (layout.samples <= 8) {
      s.coverage = w[2] & 255u;
      s.resolved = w[2] >> 8 & 255u;
      s.roughness = static_cast<std::uint8_t>(w[2] >> 16);
    } else {
      s.coverage = layout.samples == 16 ? w[2] & 0xffffu : w[2];
      s.resolved = layout.samples == 16 ? w[2] >> 16 : w[5];
      if (layout.varying_roughness) s.roughness = static_cast<std::uint8_t>(w[layout.samples == 32 ? 6 : 5]);
    }
    for (std::size_t i = 0; i < 4; ++i) s.albedo[i] = static_cast<std::uint8_t>(w[3] >> (8 * i));
    s.normal = w[4];
    if (layout.emissive) s.emission = w[layout.surface_words() - 1];
    pixel.surfaces.push_back(s);
  }
  return pixel;
}

}  // namespace subpixel::streaming_test
