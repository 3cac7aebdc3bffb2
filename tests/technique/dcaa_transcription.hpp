// One pixel of Wang, Wyman, He and Sen's decoupled coverage anti-aliasing (High-Performance Graphics 2015), algorithm 1
// and sections 3.2, 3.3 and 4.3, transcribed from the paper into plain sequential code: a vector of surfaces, an
// explicit front-to-back order, no lanes. It shares nothing with the shaders but the meaning of the packed words.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::dcaa_test {

struct Vector {
  float x = 0, y = 0, z = 0;
};
inline float dot(Vector a, Vector b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector unit(Vector v) {
  const float length = std::sqrt(std::max(dot(v, v), 1e-30f));
  return {v.x / length, v.y / length, v.z / length};
}

struct Options {
  std::uint32_t surfaces = 4, samples = 64;
  float cos_normal_angle = 0.98078528f;
  bool second_merge = true, keep_front = true, weight_by_shown = false;
  float depth_reach = 0.5f;
  std::uint32_t normal_format = DCAA_NORMAL_2X16, depth_bits = 24;
  // `hybrid`: mean normals keep their length; what has to go joins the nearest in units of k.
  bool distribution = false, nearest = false, second_moments = false;
  bool shown_part = false;  // fragments lose the samples of surfaces that are in front over the whole pixel
  float inverse_length = 1;
};

inline std::uint32_t to_snorm(float v, int bits) {
  const float largest = static_cast<float>((1 << (bits - 1)) - 1);
  const auto value = static_cast<std::int32_t>(std::nearbyint(std::clamp(v, -1.0f, 1.0f) * largest));
  return static_cast<std::uint32_t>(value) & ((1u << bits) - 1);
}
inline float from_snorm(std::uint32_t word, int bits) {
  const std::int32_t value = static_cast<std::int32_t>(word << (32 - bits)) >> (32 - bits);
  return std::max(static_cast<float>(value) / static_cast<float>((1 << (bits - 1)) - 1), -1.0f);
}

// Octahedral normals (Cigolle et al. 2014) of two components with `bits` bits each.
inline std::uint32_t to_octahedral(Vector n, int bits) {
  const float sum = std::max(std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z), 1e-30f);
  float x = n.x / sum, y = n.y / sum;
  if (n.z < 0) {
    const float folded_x = std::copysign(1.0f - std::fabs(y), x >= 0 ? 1.0f : -1.0f);
    const float folded_y = std::copysign(1.0f - std::fabs(x), y >= 0 ? 1.0f : -1.0f);
    x = folded_x;
    y = folded_y;
  }
  return to_snorm(x, bits) | to_snorm(y, bits) << bits;
}
inline Vector from_octahedral(std::uint32_t word, int bits) {
  float x = from_snorm(word, bits), y = from_snorm(word >> bits, bits);
  const float z = 1.0f - std::fabs(x) - std::fabs(y);
  if (z < 0) {
    x += x >= 0 ? z : -z;
    y += y >= 0 ? z : -z;
  }
  return unit({x, y, z});
}

using Facet = std::array<std::uint32_t, 3>;
inline Facet to_facet(Vector n, std::uint32_t format) {
  const Vector u = unit(n);
  switch (format) {
    case DCAA_NORMAL_3X32:
      return {std::bit_cast<std::uint32_t>(u.x), std::bit_cast<std::uint32_t>(u.y), std::bit_cast<std::uint32_t>(u.z)};
    case DCAA_NORMAL_3X8:
      return {to_snorm(u.x, 8) | to_snorm(u.y, 8) << 8 | to_snorm(u.z, 8) << 16, 0, 0};
    case DCAA_NORMAL_2X8:
      return {to_octahedral(n, 8), 0, 0};
    default:
      return {to_octahedral(n, 16), 0, 0};
  }
}
inline Vector from_facet(const Facet& words, std::uint32_t format) {
  switch (format) {
    case DCAA_NORMAL_3X32:
      return {std::bit_cast<float>(words[0]), std::bit_cast<float>(words[1]), std::bit_cast<float>(words[2])};
    case DCAA_NORMAL_3X8:
      return unit({from_snorm(words[0], 8), from_snorm(words[0] >> 8, 8), from_snorm(words[0] >> 16, 8)});
    case DCAA_NORMAL_2X8:
      return from_octahedral(words[0], 8);
    default:
      return from_octahedral(words[0], 16);
  }
}

// A depth as it is after having been stored: below 32 bits a float of 5 exponent bits that starts at 2^-31.
inline float stored_depth(float z, std::uint32_t bits) {
  z = std::clamp(z, 0.0f, 1.9999f);
  if (bits == 32) return z;
  if (z < 0x1p-31f) return 0x1p-31f;
  const int mantissa_bits = static_cast<int>(bits) - 5, exponent = std::ilogb(z);
  // Halves go up, as they do when a half is added and bits are cut off.
  const double scaled = std::floor(std::ldexp(static_cast<double>(z), mantissa_bits - exponent) + 0.5);
  const double largest = std::ldexp(2.0 - std::ldexp(1.0, -mantissa_bits), 0);
  return static_cast<float>(std::min(std::ldexp(scaled, exponent - mantissa_bits), largest));
}

struct Surface {
  std::uint64_t coverage = 0;
  Facet facet{};
  float depth = 0;  // reversed
  std::array<std::uint8_t, 4> albedo{};
  std::uint32_t normal = 0;
  std::uint8_t roughness = 0;
  std::array<std::uint16_t, 6> moments{};  // of the shading normals: xx, yy, zz from 0 to 1; xy, xz, yz from -1 to 1
  bool operator==(const Surface&) const = default;
};

// A mean normal with its length, where that is kept: 12 bits each for the direction, 8 for the root of 1 - length.
inline std::uint32_t to_shading(Vector n, bool with_length) {
  if (!with_length) return to_octahedral(n, 16);
  const float missing = std::sqrt(std::max(1.0f - std::sqrt(dot(n, n)), 0.0f));
  return to_octahedral(n, 12) | static_cast<std::uint32_t>(std::nearbyint(missing * 255.0f)) << 24;
}
inline Vector from_shading(std::uint32_t word, bool with_length) {
  if (!with_length) return from_octahedral(word, 16);
  const float root = static_cast<float>(word >> 24) / 255.0f, length = 1.0f - root * root;
  const Vector n = from_octahedral(word & 0xffffffu, 12);
  return {n.x * length, n.y * length, n.z * length};
}

inline std::array<std::uint16_t, 6> moments_of(std::uint32_t normal, bool with_length) {
  const Vector n = unit(from_shading(normal, with_length));
  const auto field = [](float value) { return static_cast<std::uint16_t>(std::nearbyint(value * 65535.0f)); };
  const auto product = [&](float a, float b) { return field(a * b * 0.5f + 0.5f); };
  return {field(n.x * n.x),  field(n.y * n.y),  field(n.z * n.z),
          product(n.x, n.y), product(n.x, n.z), product(n.y, n.z)};
}

struct Interval {
  float farthest = 0, nearest = 0;
};

// A camera at a pixel: the view ray and how it differs from those of the next pixels.
struct PixelView {
  Vector ray, dx, dy;
  float rays_differ = 1, scale = 0, most_along = -1e-4f, most_slope = 0.9f;
  float place = 1;  // with perspective: times 1 / (depth + scale), a point's place on the ray
};

struct Counts {
  std::uint32_t first_merges = 0, second_merges = 0, discards = 0;
};

class Pixel {
 public:
  Pixel(const Options& options, const PixelView& view) : options_(options), view_(view) {}

  void add(Surface in) {
    if (options_.shown_part) {
      for (const Surface& s : list_)
        if (in_front_everywhere(s, in)) in.coverage &= ~s.coverage;
      if (in.coverage == 0) return;
    }
    const std::optional<std::size_t> candidate = best_candidate(in);
    if (candidate) {
      list_[*candidate] = merged(list_[*candidate], in);
      ++counts_.first_merges;
    } else if (list_.size() < options_.surfaces) {
      list_.push_back(in);
    } else {
      make_room(in);
    }
  }

  const std::vector<Surface>& surfaces() const { return list_; }
  const Counts& counts() const { return counts_; }

 private:
  Vector normal_of(const Surface& s) const { return from_facet(s.facet, options_.normal_format); }

  // Depth per pixel in x and y of the surface's plane.
  std::array<float, 2> slopes(const Surface& s) const {
    const Vector n = normal_of(s);
    const float along = std::min(dot(n, view_.ray), view_.most_along);
    const float per_slope = s.depth * view_.rays_differ + view_.scale;
    return {per_slope * std::clamp(dot(n, view_.dx) / along, -view_.most_slope, view_.most_slope),
            per_slope * std::clamp(dot(n, view_.dy) / along, -view_.most_slope, view_.most_slope)};
  }

  // The difference of two planes is least at a corner of the pixel.
  bool in_front_everywhere(const Surface& a, const Surface& b) const {
    const auto sa = slopes(a), sb = slopes(b);
    return a.depth - b.depth > 0.5f * (std::fabs(sa[0] - sb[0]) + std::fabs(sa[1] - sb[1]));
  }

  // Section 3.2: the bounding box in depth over the pixel, one unit of the stored depth larger on either side.
  Interval interval(const Surface& s) const {
    const auto [sx, sy] = slopes(s);
    const float stored_unit = std::ldexp(1.0f, 5 - static_cast<int>(std::min(options_.depth_bits, 28u)));
    const float reach = options_.depth_reach * (std::fabs(sx) + std::fabs(sy)) + s.depth * stored_unit;
    return {s.depth - reach, s.depth + reach};
  }

  // The part of the shorter box that both share; nothing when they don't overlap.
  static std::optional<float> overlap(const Interval& a, const Interval& b) {
    const float both = std::min(a.nearest, b.nearest) - std::max(a.farthest, b.farthest);
    if (both < 0) return std::nullopt;
    const float shorter = std::min(a.nearest - a.farthest, b.nearest - b.farthest);
    return std::min(both / std::max(shorter, 1e-30f), 1.0f);
  }

  std::optional<std::size_t> best_candidate(const Surface& in) const {
    std::optional<std::size_t> best;
    float best_score = -1;
    for (std::size_t i = 0; i < list_.size(); ++i) {
      const float cosine = dot(normal_of(in), normal_of(list_[i]));
      const auto shared = overlap(interval(list_[i]), interval(in));
      if (!(cosine > options_.cos_normal_angle) || !shared) continue;
      const float score =
          (cosine - options_.cos_normal_angle) * (1.0f / std::max(1.0f - options_.cos_normal_angle, 1e-6f)) + *shared;
      if (score > best_score) {
        best = i;
        best_score = score;
      }
    }
    return best;
  }

  Surface merged(const Surface& a, const Surface& b) const {
    const bool b_in_front = b.depth > a.depth;
    const auto count = [&](const Surface& s, const Surface& other, bool behind) {
      const std::uint64_t hidden = options_.weight_by_shown && behind ? other.coverage : 0;
      return static_cast<float>(std::popcount(s.coverage & ~hidden));
    };
    const float count_a = count(a, b, b_in_front), count_b = count(b, a, !b_in_front);
    const float wa = count_a / (count_a + count_b), wb = count_b / (count_a + count_b);
    const auto blend = [&](Vector m, Vector n) {
      return Vector{m.x * wa + n.x * wb, m.y * wa + n.y * wb, m.z * wa + n.z * wb};
    };
    const auto byte = [](float v) { return static_cast<std::uint8_t>(std::nearbyint(v)); };
    Surface m;
    m.coverage = a.coverage | b.coverage;
    m.facet = to_facet(blend(normal_of(a), normal_of(b)), options_.normal_format);
    m.depth = stored_depth(a.depth * wa + b.depth * wb, options_.depth_bits);
    for (std::size_t i = 0; i < 3; ++i) {
      const float p = a.albedo[i], q = b.albedo[i];
      m.albedo[i] = byte(std::sqrt(p * p * wa + q * q * wb));
    }
    m.albedo[3] = byte(static_cast<float>(a.albedo[3]) * wa + static_cast<float>(b.albedo[3]) * wb);
    const bool length = options_.distribution;
    m.normal = to_shading(blend(from_shading(a.normal, length), from_shading(b.normal, length)), length);
    for (std::size_t i = 0; i < m.moments.size(); ++i) {
      m.moments[i] = static_cast<std::uint16_t>(
          std::nearbyint(static_cast<float>(a.moments[i]) * wa + static_cast<float>(b.moments[i]) * wb));
    }
    m.roughness = byte(static_cast<float>(a.roughness) * wa + static_cast<float>(b.roughness) * wb);
    return m;
  }

  // Section 3.3.
  void make_room(Surface in) {
    std::vector<Surface*> all;
    for (auto& s : list_) all.push_back(&s);
    all.push_back(&in);
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t i, std::size_t j) { return all[i]->depth > all[j]->depth; });

    // Front to back: what each shows of its samples. The last of the least goes, never the front-most.
    std::size_t gone = order.back();
    int least = 65;
    std::uint64_t in_front = 0, shows = 0;
    for (std::size_t place = 0; place < order.size(); ++place) {
      const std::uint64_t seen = all[order[place]]->coverage & ~in_front;
      const int shown = std::popcount(seen);
      in_front |= all[order[place]]->coverage;
      if (place == 0 && options_.keep_front) continue;
      if (shown <= least) {
        least = shown;
        gone = order[place];
        shows = seen;
      }
    }

    std::optional<std::size_t> partner;
    float most = -1;
    for (std::size_t i = 0; options_.second_merge && !options_.nearest && i < all.size(); ++i) {
      if (i == gone) continue;
      const auto shared = overlap(interval(*all[i]), interval(*all[gone]));
      if (shared && *shared > most) {
        most = *shared;
        partner = i;
      }
    }
    if (options_.nearest) {
      join_nearest(all, gone, shows);
    } else if (partner) {
      *all[*partner] = merged(*all[*partner], *all[gone]);
      ++counts_.second_merges;
    } else {
      ++counts_.discards;
    }
    if (all[gone] != &in) *all[gone] = in;
  }

  // Where on the ray the surface is, in units of k.
  float place_of(const Surface& s) const {
    const float per_ray = std::sqrt(dot(view_.ray, view_.ray)) * options_.inverse_length;
    return (view_.rays_differ != 0 ? view_.place / std::max(s.depth + view_.scale, 1e-30f) : s.depth) * per_ray;
  }

  // Crassin et al. 2016, equation 1, on surfaces of a pixel: what shows of one becomes part of the nearest, which stays
  // where it is. What shows nothing goes.
  void join_nearest(const std::vector<Surface*>& all, std::size_t gone, std::uint64_t shows) {
    if (shows == 0) return;
    Surface* nearest = nullptr;
    float least = 1e30f;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == gone) continue;
      const float away = std::min(std::fabs(place_of(*all[i]) - place_of(*all[gone])), 1e15f);
      const float distance = away * away + (1.0f - dot(normal_of(*all[i]), normal_of(*all[gone]))) * 0.5f;
      if (distance < least) {
        least = distance;
        nearest = all[i];
      }
    }
    Surface part = *all[gone];
    part.coverage = shows;
    const Surface before = *nearest;
    *nearest = merged(before, part);
    nearest->facet = before.facet;
    nearest->depth = before.depth;
    ++counts_.second_merges;
  }

  Options options_;
  PixelView view_;
  std::vector<Surface> list_;
  Counts counts_;
};

}  // namespace subpixel::dcaa_test
