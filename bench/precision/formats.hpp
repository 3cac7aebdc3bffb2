// Numbers as formats store them: rounded to nearest, in float64.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace subpixel::precision {

inline double to_float(double value) {
  return static_cast<double>(static_cast<float>(value));
}

// `mantissa` bits beside the leading one, exponents of half: 2^-14 to 2^15, smaller values in steps of
// 2^(-14-mantissa).
inline double to_small_float(double value, int mantissa) {
  const double largest = std::ldexp(2 - std::ldexp(1, -mantissa), 15);
  if (!(std::abs(value) > 0)) return 0;
  const int exponent = std::max(std::ilogb(value), -14);
  const double step = std::ldexp(1, exponent - mantissa);
  return std::clamp(std::nearbyint(value / step) * step, -largest, largest);
}
inline double to_half(double value) {
  return to_small_float(value, 10);
}

inline double to_unorm(double value, int bits) {
  const double most = std::ldexp(1, bits) - 1;
  return std::floor(std::clamp(value, 0.0, 1.0) * most + 0.5) / most;
}
inline double to_snorm(double value, int bits) {
  const double most = std::ldexp(1, bits - 1) - 1;
  return std::nearbyint(std::clamp(value, -1.0, 1.0) * most) / most;
}

inline glm::dvec3 octahedral(const glm::dvec3& n, int bits) {
  glm::dvec2 p = glm::dvec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  const auto fold = [](const glm::dvec2& q) {
    return glm::dvec2((1 - std::abs(q.y)) * (q.x >= 0 ? 1 : -1), (1 - std::abs(q.x)) * (q.y >= 0 ? 1 : -1));
  };
  if (n.z < 0) p = fold(p);
  p = {to_snorm(p.x, bits), to_snorm(p.y, bits)};
  const double z = 1 - std::abs(p.x) - std::abs(p.y);
  if (z < 0) p = fold(p);
  return glm::normalize(glm::dvec3(p, z));
}

inline glm::dvec3 spherical(const glm::dvec3& n, int bits) {
  constexpr double kPi = std::numbers::pi;
  const double steps = std::ldexp(1, bits);
  const double polar = to_unorm(std::acos(std::clamp(n.z, -1.0, 1.0)) / kPi, bits) * kPi;
  const double turn = std::nearbyint((std::atan2(n.y, n.x) / (2 * kPi)) * steps) / steps * 2 * kPi;
  return {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
}

inline glm::dvec3 three_bytes(const glm::dvec3& n) {
  return glm::normalize(glm::dvec3(to_snorm(n.x, 8), to_snorm(n.y, 8), to_snorm(n.z, 8)));
}

// EXT_texture_shared_exponent.
inline glm::dvec3 shared_exponent(const glm::dvec3& colour) {
  const double largest = std::max({colour.r, colour.g, colour.b});
  if (!(largest > 0)) return glm::dvec3(0);
  int exponent = std::max(-16, std::ilogb(largest)) + 1;
  if (std::floor(largest / std::ldexp(1, exponent - 9) + 0.5) == 512) ++exponent;
  const double step = std::ldexp(1, exponent - 9);
  return {std::floor(colour.r / step + 0.5) * step, std::floor(colour.g / step + 0.5) * step,
          std::floor(colour.b / step + 0.5) * step};
}

}  // namespace subpixel::precision
