// Arithmetic on the groups of pixels that FLIP works on. For one file alone, whose compiler options fit
// (CMakeLists.txt).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>

#include "replay/measure/flip_exposures.hpp"
#include "replay/measure/flip_filters.hpp"

namespace subpixel::replay {

using LaneBits = std::int32_t __attribute__((vector_size(32)));

inline Lanes all(float value) {
  return Lanes{value, value, value, value, value, value, value, value};
}

inline Lanes load(const float* from) {
  Lanes value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

inline void store(float* to, Lanes value) {
  std::memcpy(to, &value, sizeof value);
}

inline Lanes clamp_to_one(Lanes value) {
  value = value < 0 ? all(0) : value;
  return value > 1 ? all(1) : value;
}

// Cube root of positive values: a third of the exponent as the first guess, then two of Halley's steps, each of which
// cubes the error (3.5% -> 3e-5 -> below float's).
inline Lanes cube_root(Lanes value) {
  const Lanes third = __builtin_convertvector((LaneBits)value, Lanes) * (1.0F / 3.0F) + 709921077.0F;
  Lanes root = (Lanes) __builtin_convertvector(third, LaneBits);
  for (int step = 0; step < 2; ++step) {
    const Lanes cube = root * root * root;
    root = root * (cube + 2.0F * value) / (2.0F * cube + value);
  }
  return root;
}

// 2 to the power `exponent` of -126 to 126: the nearest whole number into the exponent's bits, a series for the rest.
inline Lanes power_of_two(Lanes exponent) {
  const Lanes shifted = exponent + 12582912.0F;  // 1.5 * 2^23, which leaves the whole number in the low bits
  const Lanes rest = (exponent - (shifted - 12582912.0F)) * std::numbers::ln2_v<float>;
  Lanes sum = all(1.0F / 5040);
  for (const float coefficient : {1.0F / 720, 1.0F / 120, 1.0F / 24, 1.0F / 6, 0.5F, 1.0F, 1.0F})
    sum = sum * rest + coefficient;
  return (Lanes)((LaneBits)sum + ((LaneBits)shifted << 23));
}

// Logarithm to base 2 of positive normal values: the exponent, and the series of artanh for a mantissa around 1.
inline Lanes log_base_two(Lanes value) {
  constexpr std::int32_t kHalfRoot = 0x3f3504f3;  // sqrt(1/2)
  const LaneBits exponent = ((LaneBits)value - kHalfRoot) >> 23;
  const Lanes mantissa = (Lanes)((LaneBits)value - (exponent << 23));
  const Lanes t = (mantissa - 1.0F) / (mantissa + 1.0F), square = t * t;
  Lanes sum = all(1.0F / 9);
  for (const float coefficient : {1.0F / 7, 1.0F / 5, 1.0F / 3, 1.0F}) sum = sum * square + coefficient;
  return __builtin_convertvector(exponent, Lanes) + (2 / std::numbers::ln2_v<float>)*t * sum;
}

// value^exponent for values of 0 to 2^40 and exponents of 0 to 1; 0 for values so small that nobody would see the
// result.
inline Lanes power(Lanes value, Lanes exponent) {
  const LaneBits seen = value > 1e-30F;
  const Lanes result = power_of_two(exponent * log_base_two(seen ? value : all(1)));
  return seen ? result : all(0);
}

inline Lanes magnitude(Lanes value) {
  return value < 0 ? -value : value;
}

inline Lanes root(Lanes value) {
  for (int i = 0; i < lane_count; ++i) value[i] = std::sqrt(value[i]);
  return value;
}

// `stored` times `factor` through the tone curve, clamped to 0..1. Negative values and NaN count as 0.
inline Lanes tone_mapped(Lanes stored, float factor) {
  constexpr ToneCurve curve;
  constexpr auto a = static_cast<float>(curve.a), b = static_cast<float>(curve.b), c = static_cast<float>(curve.c),
                 d = static_cast<float>(curve.d), e = static_cast<float>(curve.e);
  Lanes x = stored > 0 ? stored : all(0);
  x = (x < std::numeric_limits<float>::max() ? x : all(std::numeric_limits<float>::max())) * factor;
  // Beyond 2^40 the curve is flat; its squares stay finite there.
  x = x < 0x1p40F ? x : all(0x1p40F);
  const Lanes value = x * (a * x + b) / (x * (c * x + d) + e);
  return value < 1 ? value : all(1);
}

}  // namespace subpixel::replay
