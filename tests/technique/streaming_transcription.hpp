// One pixel of Kerzner and Salvi's streaming compression (High-Performance Graphics 2014, sections 3.1 and 3.2),
// transcribed from the paper into plain sequential code: a list kept in front-to-back order, no slots, no masks of
// lanes. It shares nothing with the shaders but the meaning of the packed words.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "shaders/frontend/sample_patterns.h"

namespace subpixel::streaming_test {

// IEEE binary16, rounded to nearest even. What rounds to zero loses its sign, as slopes do in the shader.
inline std::uint16_t to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto sign = static_cast<std::uint16_t>((bits >> 16) & 0x8000u);
  const float magnitude = std::fabs(value);
  if (magnitude >= 65520.0f) return static_cast<std::uint16_t>(sign | 0x7c00u);
  if (magnitude < 0x1p-14f) {
    const auto units = static_cast<int>(std::nearbyint(magnitude * 0x1p24f));
    return units == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(sign | units);
  }
  const int exponent = std::ilogb(magnitude);
  const auto mantissa = static_cast<int>(std::nearbyint(std::ldexp(magnitude, 10 - exponent)));  // 1024 .. 2048
  return static_cast<std::uint16_t>(sign | (((exponent + 15) << 10) + mantissa - 1024));
}

inline float from_half(std::uint16_t half) {
  const int exponent = (half >> 10) & 31, mantissa = half & 1023;
  const float magnitude = exponent == 0 ? std::ldexp(static_cast<float>(mantissa), -24)
                                        : std::ldexp(static_cast<float>(1024 + mantissa), exponent - 25);
  return (half & 0x8000u) != 0 ? -magnitude : magnitude;
}

struct Vector {
  float x, y, z;
};

// Octahedral normals in 2 x 16 signed normalised bits (Cigolle et al. 2014).
inline Vector decode_normal(std::uint32_t word) {
  const auto component = [](std::uint32_t bits) {
    return std::clamp(static_cast<float>(static_cast<std::int16_t>(bits & 0xffffu)) / 32767.0f, -1.0f, 1.0f);
  };
  float x = component(word), y = component(word >> 16);
  const float z = 1.0f - std::fabs(x) - std::fabs(y);
  if (z < 0) {
    x += x >= 0 ? z : -z;
    y += y >= 0 ? z : -z;
  }
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

inline std::uint32_t encode_normal(Vector n) {
  const float sum = std::max(std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z), 1e-20f);
  float x = n.x / sum, y = n.y / sum;
  if (n.z < 0) {
    const float folded_x = (1.0f - std::fabs(y)) * (x >= 0 ? 1.0f : -1.0f);
    const float folded_y = (1.0f - std::fabs(x)) * (y >= 0 ? 1.0f : -1.0f);
    x = folded_x;
    y = folded_y;
  }
  const auto component = [](float v) {
    return static_cast<std::uint16_t>(static_cast<std::int16_t>(std::nearbyint(std::clamp(v, -1.0f, 1.0f) * 32767.0f)));
  };
  return component(x) | std::uint32_t{component(y)} << 16;
}

// Red, green and blue with 9 bits each and one exponent of 5 (EXT_texture_shared_exponent).
inline Vector decode_emission(std::uint32_t word) {
  const int exponent = static_cast<int>(word >> 27) - 24;
  const auto component = [&](std::uint32_t bits) { return std::ldexp(static_cast<float>(bits & 511u), exponent); };
  return {component(word), component(word >> 9), component(word >> 18)};
}

inline std::uint32_t encode_emission(Vector c) {
  const auto range = [](float v) { return std::clamp(v, 0.0f, 65408.0f); };
  const float largest = std::max({range(c.x), range(c.y), range(c.z)});
  int exponent = largest > 0 ? std::max(-16, std::ilogb(largest)) + 16 : 0;
  const auto component = [&](float v) {
    return static_cast<std::uint32_t>(std::floor(std::ldexp(range(v), 24 - exponent) + 0.5f));
  };
  if (component(largest) == 512) ++exponent;
  return component(c.x) | component(c.y) << 9 | component(c.z) << 18 | static_cast<std::uint32_t>(exponent) << 27;
}

struct Surface {
  float depth = 0;  // grows away from the eye
  std::uint16_t slope_x = 0, slope_y = 0;
  std::uint32_t coverage = 0, resolved = 0;
  std::array<std::uint8_t, 4> albedo{};  // square roots of red, green and blue; metallic
  std::uint32_t normal = 0;
  std::uint8_t roughness = 0;
  std::uint32_t emission = 0;
  auto operator<=>(const Surface&) const = default;

  float nearest() const { return depth - (std::fabs(from_half(slope_x)) + std::fabs(from_half(slope_y))); }
  float farthest() const { return depth + (std::fabs(from_half(slope_x)) + std::fabs(from_half(slope_y))); }
};

// The depth buffer's part of a fragment: a plane of reversed depth, kept within the triangle's own range.
struct DepthBufferPlane {
  float centre = 0, dx = 0, dy = 0, smallest = 0, largest = 1;
};

struct Options {
  std::uint32_t surfaces = 3, samples = 8;
  float cos_normal_angle = 0.70710678f;
  bool merge_normals = true, merge_depth = true, merge_coverage = true;
  bool weight_by_coverage = false;
  bool depth_tested = false;         // not in the paper: see `add`
  bool discard_by_resolved = false;  // counts stored masks, not what nothing nearer covers
};

struct Pixel {
  std::vector<float> depth_buffer;
  std::vector<Surface> surfaces;  // front to back
  bool discarded = false;
  std::uint32_t merges = 0, dropped_samples = 0;
  bool operator==(const Pixel&) const = default;
};

class Compressor {
 public:
  explicit Compressor(const Options& options) : options_(options) { pixel_.depth_buffer.assign(options.samples, 0.0f); }

  void add(const DepthBufferPlane& plane, const Surface& given) {
    const std::uint32_t passed = depth_test(plane, given.coverage);
    if (passed == 0) return;
    Surface fragment = given;
    fragment.resolved = fragment.coverage;
    if (options_.depth_tested) {
      // What passes the depth test is in front of everything, and what fails is hidden.
      fragment.resolved = passed;
      for (Surface& surface : pixel_.surfaces) surface.resolved &= ~passed;
    }
    const auto mate = std::find_if(pixel_.surfaces.begin(), pixel_.surfaces.end(),
                                   [&](const Surface& surface) { return may_merge(surface, fragment); });
    if (mate != pixel_.surfaces.end()) {
      fragment = merged(*mate, fragment);
      pixel_.surfaces.erase(mate);
      ++pixel_.merges;
      insert(fragment);
      return;
    }
    insert(fragment);
    if (pixel_.surfaces.size() > options_.surfaces) {
      const std::vector<int> shown = fuse_occluders();
      discard_one(shown);
    }
  }

  const Pixel& pixel() const { return pixel_; }

 private:
  // The samples that pass.
  std::uint32_t depth_test(const DepthBufferPlane& plane, std::uint32_t coverage) {
    std::uint32_t passed = 0;
    for (std::uint32_t i = 0; i < options_.samples; ++i) {
      if ((coverage >> i & 1u) == 0) continue;
      const auto [x, y] = gpu_types::sample_offset(options_.samples, i);
      const float ox = static_cast<float>(x) / 128, oy = static_cast<float>(y) / 128;
      const float z = std::clamp(plane.dx * ox + (plane.dy * oy + plane.centre), plane.smallest, plane.largest);
      if (z > pixel_.depth_buffer[i]) {
        pixel_.depth_buffer[i] = z;
        passed |= 1u << i;
      }
    }
    return passed;
  }

  bool may_merge(const Surface& a, const Surface& b) const {
    const Vector n = decode_normal(a.normal), m = decode_normal(b.normal);
    const bool aligned = n.x * m.x + n.y * m.y + n.z * m.z > options_.cos_normal_angle;
    const bool overlap = a.nearest() <= b.farthest() && b.nearest() <= a.farthest();
    const bool exclusive = (a.coverage & b.coverage) == 0;
    return (aligned || !options_.merge_normals) && (overlap || !options_.merge_depth) &&
           (exclusive || !options_.merge_coverage);
  }

  Surface merged(const Surface& a, const Surface& b) const {
    float wa = 0.5f, wb = 0.5f;
    if (options_.weight_by_coverage) {
      const auto ca = static_cast<float>(std::popcount(a.coverage)), cb = static_cast<float>(std::popcount(b.coverage));
      wa = ca / (ca + cb);
      wb = cb / (ca + cb);
    }
    Surface m;
    m.depth = std::min(a.depth, b.depth);
    m.slope_x = to_half(from_half(a.slope_x) * wa + from_half(b.slope_x) * wb);
    m.slope_y = to_half(from_half(a.slope_y) * wa + from_half(b.slope_y) * wb);
    m.coverage = a.coverage | b.coverage;
    m.resolved = a.resolved | b.resolved;
    const auto mean = [&](float x, float y) { return static_cast<std::uint8_t>(std::nearbyint(x * wa + y * wb)); };
    for (std::size_t i = 0; i < 3; ++i) {
      const float x = a.albedo[i], y = b.albedo[i];
      m.albedo[i] = static_cast<std::uint8_t>(std::nearbyint(std::sqrt(x * x * wa + y * y * wb)));
    }
    m.albedo[3] = mean(a.albedo[3], b.albedo[3]);
    const Vector n = decode_normal(a.normal), k = decode_normal(b.normal);
    m.normal = encode_normal({n.x * wa + k.x * wb, n.y * wa + k.y * wb, n.z * wa + k.z * wb});
    m.roughness = mean(a.roughness, b.roughness);
    const Vector e = decode_emission(a.emission), g = decode_emission(b.emission);
    m.emission = encode_emission({e.x * wa + g.x * wb, e.y * wa + g.y * wb, e.z * wa + g.z * wb});
    return m;
  }

  void insert(const Surface& surface) {
    const auto behind = std::find_if(pixel_.surfaces.begin(), pixel_.surfaces.end(),
                                     [&](const Surface& other) { return other.depth > surface.depth; });
    pixel_.surfaces.insert(behind, surface);
  }

  // Front to back: the occluder so far, fused of all in front, takes its samples off one that lies wholly behind it.
  // Returns how many samples each surface shows, for the choice of the one to discard.
  std::vector<int> fuse_occluders() {
    auto& list = pixel_.surfaces;
    std::vector<int> shown = {std::popcount(list[0].resolved)};
    std::uint32_t samples = list[0].coverage;
    float farthest = list[0].farthest();
    for (std::size_t i = 1; i < list.size(); ++i) {
      const bool disjoint = list[i].nearest() > farthest;
      const std::uint32_t uncovered = list[i].resolved & ~samples;
      if (disjoint) list[i].resolved = uncovered;
      shown.push_back(std::popcount(options_.discard_by_resolved ? list[i].resolved : uncovered));
      samples |= list[i].coverage;
      farthest = std::max(farthest, list[i].farthest());
    }
    return shown;
  }

  void discard_one(const std::vector<int>& shown) {
    auto& list = pixel_.surfaces;
    std::size_t least = 0;
    for (std::size_t i = 1; i < list.size(); ++i)
      if (shown[i] <= shown[least]) least = i;
    const auto lost = static_cast<std::uint32_t>(shown[least]);
    pixel_.discarded = pixel_.discarded || lost > 0;
    pixel_.dropped_samples += lost;
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(least));
  }

  Options options_;
  Pixel pixel_;
};

}  // namespace subpixel::streaming_test
