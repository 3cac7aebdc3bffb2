// Sample positions relative to the pixel's centre in 1/128 pixel, x right and y down. Included by host and shaders.
// 1, 2, 4, 8 and 16: the Vulkan specification's standard sample locations. 32 and 64: the digital (0, m, 2)-net of
// Larcher and Pillichshammer (2001), point i at ((i + 0.5) / n, (r(i) + 0.5) / n), which has every elementary interval of
// area 1/n hit once.
#ifndef SUBPIXEL_SAMPLE_PATTERNS_H
#define SUBPIXEL_SAMPLE_PATTERNS_H

#ifdef __cplusplus
#include <cstdint>
namespace subpixel::gpu_types {
struct SampleOffset {
  std::int32_t x, y;
};
#define SUBPIXEL_PATTERN(name, count) inline constexpr SampleOffset name[count] =
#define SUBPIXEL_PATTERN_BEGIN {
#define SUBPIXEL_PATTERN_END }
#define S16(x, y) {(x) * 8 - 64, (y) * 8 - 64}
#else
#define SUBPIXEL_PATTERN(name, count) const ivec2 name[count] = ivec2[count]
#define SUBPIXEL_PATTERN_BEGIN (
#define SUBPIXEL_PATTERN_END )
#define S16(x, y) ivec2((x) * 8 - 64, (y) * 8 - 64)
#endif

// clang-format off
SUBPIXEL_PATTERN(kPattern1, 1) SUBPIXEL_PATTERN_BEGIN S16(8, 8) SUBPIXEL_PATTERN_END;
SUBPIXEL_PATTERN(kPattern2, 2) SUBPIXEL_PATTERN_BEGIN S16(12, 12), S16(4, 4) SUBPIXEL_PATTERN_END;
SUBPIXEL_PATTERN(kPattern4, 4) SUBPIXEL_PATTERN_BEGIN
  S16(6, 2), S16(14, 6), S16(2, 10), S16(10, 14) SUBPIXEL_PATTERN_END;
SUBPIXEL_PATTERN(kPattern8, 8) SUBPIXEL_PATTERN_BEGIN
  S16(9, 5), S16(7, 11), S16(13, 9), S16(5, 3), S16(3, 13), S16(1, 7), S16(11, 15), S16(15, 1) SUBPIXEL_PATTERN_END;
SUBPIXEL_PATTERN(kPattern16, 16) SUBPIXEL_PATTERN_BEGIN
  S16(9, 9), S16(7, 5), S16(5, 10), S16(12, 7), S16(3, 6), S16(10, 13), S16(13, 11), S16(11, 3),
  S16(6, 14), S16(8, 1), S16(4, 2), S16(2, 12), S16(0, 8), S16(15, 4), S16(14, 15), S16(1, 0) SUBPIXEL_PATTERN_END;
// clang-format on

#undef S16
#undef SUBPIXEL_PATTERN
#undef SUBPIXEL_PATTERN_BEGIN
#undef SUBPIXEL_PATTERN_END

#ifdef __cplusplus
// r(i) of Larcher and Pillichshammer, `bits` binary digits.
constexpr std::uint32_t larcher_pillichshammer(std::uint32_t i, std::uint32_t bits) {
  std::uint32_t r = 0;
  for (std::uint32_t v = 1u << 31; i != 0; i >>= 1, v |= v >> 1)
    if (i & 1u) r ^= v;
  return r >> (32 - bits);
}
// Sample `i` of the `n`-sample pattern; n is 1, 2, 4, 8, 16, 32 or 64.
constexpr SampleOffset sample_offset(std::uint32_t n, std::uint32_t i) {
  switch (n) {
    case 1: return kPattern1[i];
    case 2: return kPattern2[i];
    case 4: return kPattern4[i];
    case 8: return kPattern8[i];
    case 16: return kPattern16[i];
    default: {
      const std::uint32_t bits = n == 32 ? 5 : 6;
      const auto scale = static_cast<std::int32_t>(128 / n);
      return {static_cast<std::int32_t>(2 * i + 1) * scale / 2 - 64,
              static_cast<std::int32_t>(2 * larcher_pillichshammer(i, bits) + 1) * scale / 2 - 64};
    }
  }
}
}  // namespace subpixel::gpu_types
#else
uint larcher_pillichshammer(uint i, uint bits) {
  uint r = 0u;
  uint v = 0x80000000u;
  for (uint b = 0u; b < bits; ++b) {
    if (((i >> b) & 1u) != 0u) r ^= v;
    v |= v >> 1u;
  }
  return r >> (32u - bits);
}
// With constant arguments this folds to a constant.
ivec2 sample_offset(uint n, uint i) {
  if (n == 1u) return kPattern1[0];
  if (n == 2u) return kPattern2[i & 1u];
  if (n == 4u) return kPattern4[i & 3u];
  if (n == 8u) return kPattern8[i & 7u];
  if (n == 16u) return kPattern16[i & 15u];
  uint bits = n == 32u ? 5u : 6u;
  int scale = int(128u / n);
  return ivec2(int(2u * i + 1u) * scale / 2 - 64, int(2u * larcher_pillichshammer(i, bits) + 1u) * scale / 2 - 64);
}
#endif
#endif
