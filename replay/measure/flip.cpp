#include "replay/measure/flip.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "replay/measure/flip_exposures.hpp"
#include "replay/measure/flip_lanes.hpp"
#include "replay/measure/flip_rows.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/measure/percentiles.hpp"

namespace subpixel::replay {
namespace {

float hyab(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const float da = a[1] - b[1];
  const float db = a[2] - b[2];
  return std::abs(a[0] - b[0]) + std::sqrt(da * da + db * db);
}

constexpr float colour_exponent = 0.7F;   // q_c, section 4.1.3
constexpr float compressed_share = 0.4F;  // p_c: below this share of the largest difference ...
constexpr float compressed_to = 0.95F;    // p_t: ... the scale is spread over this much of 0..1

// Largest colour difference: between green and blue (section 4.1.3).
float largest_colour_difference() {
  const auto first_lane = [](const Colour& c) { return std::array<float, 3>{c.x[0], c.y[0], c.z[0]}; };
  const Colour green = hunt_lab(to_xyz({all(0), all(1), all(0)}));
  const Colour blue = hunt_lab(to_xyz({all(0), all(0), all(1)}));
  return std::pow(hyab(first_lane(green), first_lane(blue)), colour_exponent);
}

struct FlipContext {
  FlipKernels kernels;
  DecodeTable decode;
  float largest_difference = largest_colour_difference();
};

// Equations of sections 4.1.3 (colour), 4.2 (features) and 4.3 (both).
Lanes pixel_errors(const FlipContext& context, const RowFeatures& a, const RowFeatures& b, std::uint32_t x) {
  const auto difference_of = [x](const PaddedRow& p, const PaddedRow& q) {
    return load(p.data() + x) - load(q.data() + x);
  };
  const Lanes da = difference_of(a.a, b.a), db = difference_of(a.b, b.b);
  const Lanes hyab_distance = magnitude(difference_of(a.lightness, b.lightness)) + root(da * da + db * db);
  const Lanes difference = power(hyab_distance, all(colour_exponent));
  const float knee = compressed_share * context.largest_difference;
  const Lanes compressed =
      compressed_to + (difference - knee) / (context.largest_difference - knee) * (1 - compressed_to);
  const Lanes colour_error = difference < knee ? compressed_to / knee * difference : compressed;
  const Lanes edges = magnitude(root(load(a.edge.data() + x)) - root(load(b.edge.data() + x)));
  const Lanes points = magnitude(root(load(a.point.data() + x)) - root(load(b.point.data() + x)));
  const Lanes feature_error = root(std::numbers::sqrt2_v<float> / 2 * (edges > points ? edges : points));
  const Lanes error = power(colour_error, 1 - (feature_error < 1 ? feature_error : all(1)));
  return colour_error > 0 ? (error < 1 ? error : all(1)) : all(0);
}

// One of the images that HDR-FLIP compares.
struct Exposure {
  float factor = 1;
  std::uint16_t number = 0;
};

// The larger of FLIP and what the map holds, and where that is FLIP the exposure's number.
struct ErrorMaps {
  Image& error;
  std::vector<std::uint16_t>* at;
};

// `error` of `count` pixels from index `at`.
inline void keep_larger(Lanes error, const std::optional<Exposure>& exposure, std::size_t at, int count,
                        const ErrorMaps& maps) {
  Lanes before = all(0);
  std::memcpy(&before, &maps.error.pixels[at], count * sizeof(float));
  const LaneBits larger = error > before;
  const Lanes after = larger ? error : before;
  std::memcpy(&maps.error.pixels[at], &after, count * sizeof(float));
  if (!maps.at) return;
  using Numbers = std::uint16_t __attribute__((vector_size(lane_count * sizeof(std::uint16_t))));
  Numbers numbers{};
  std::memcpy(&numbers, &(*maps.at)[at], count * sizeof(std::uint16_t));
  const Numbers mask = (Numbers) __builtin_convertvector(larger, Numbers);
  numbers = (mask & exposure->number) | (~mask & numbers);
  std::memcpy(&(*maps.at)[at], &numbers, count * sizeof(std::uint16_t));
}

inline void flip_rows(const FlipContext& context, const LinearPlanes& reference, const LinearPlanes& test,
                      const std::optional<Exposure>& exposure, int first, int end, const ErrorMaps& maps) {
  const std::optional<float> factor = exposure ? std::optional(exposure->factor) : std::nullopt;
  OpponentRows reference_rows(reference, context.kernels.radius, factor);
  OpponentRows test_rows(test, context.kernels.radius, factor);
  FilteredRow filtered(reference.width(), context.kernels.radius);
  RowFeatures reference_features(reference.width());
  RowFeatures test_features(test.width());
  for (int y = first; y < end; ++y) {
    reference_rows.advance(y);
    test_rows.advance(y);
    filter_columns(context.kernels, reference_rows, y, filtered);
    compute_features(context.kernels, filtered, reference.width(), reference_features);
    filter_columns(context.kernels, test_rows, y, filtered);
    compute_features(context.kernels, filtered, reference.width(), test_features);
    const std::size_t row = std::size_t{static_cast<std::uint32_t>(y)} * reference.width();
    for (int x = 0; x < reference.width(); x += lane_count) {
      const Lanes error = pixel_errors(context, reference_features, test_features, x);
      if (reference.width() - x >= lane_count) {
        keep_larger(error, exposure, row + x, lane_count, maps);
      } else {
        keep_larger(error, exposure, row + x, reference.width() - x, maps);
      }
    }
  }
}

// The same code with the instructions of newer processors: the same operations, so the same bits.
#if defined(__x86_64__)
__attribute__((target("avx2"), flatten)) void flip_rows_avx2(const FlipContext& context, const LinearPlanes& reference,
                                                             const LinearPlanes& test,
                                                             const std::optional<Exposure>& exposure, int first,
                                                             int end, const ErrorMaps& maps) {
  flip_rows(context, reference, test, exposure, first, end, maps);
}
const bool has_avx2 = __builtin_cpu_supports("avx2");
#endif

void flip_rows_here(const FlipContext& context, const LinearPlanes& reference, const LinearPlanes& test,
                    const std::optional<Exposure>& exposure, int first, int end, const ErrorMaps& maps) {
#if defined(__x86_64__)
  if (has_avx2) return flip_rows_avx2(context, reference, test, exposure, first, end, maps);
#endif
  flip_rows(context, reference, test, exposure, first, end, maps);
}

FlipContext make_context(const FlipOptions& options) {
  if (!(options.pixels_per_degree >= 1 && options.pixels_per_degree <= 1000)) {
    throw InputError("FLIP", "pixels per degree " + std::to_string(options.pixels_per_degree) + " is not in 1 to 1000",
                     "viewing conditions");
  }
  return {.kernels = flip_kernels(options.pixels_per_degree), .decode = {}};
}

// Into `maps`.
void compare(const FlipContext& context, const LinearPlanes& reference, const LinearPlanes& test,
             const std::optional<Exposure>& exposure, unsigned threads, const ErrorMaps& maps) {
  in_rows(reference.height(), threads,
          [&](int first, int end) { flip_rows_here(context, reference, test, exposure, first, end, maps); });
}

// The filters pass over pixels that have no value; what they leave there would say "equal".
void mark_not_finite_errors(const Image& reference, const Image& test, Image& map) {
  for (std::size_t i = 0; i < map.pixels.size(); ++i)
    if (!is_finite(reference, i) || !is_finite(test, i)) map.pixels[i] = 1;
}

FlipResult pooled(Image map) {
  FlipResult result;
  result.map = std::move(map);
  const Percentiles percentiles(result.map.pixels);
  result.mean = percentiles.mean();
  result.minimum = percentiles.minimum();
  result.maximum = percentiles.maximum();
  result.p99 = percentiles.at(0.99);
  result.weighted_first_quartile = percentiles.weighted_at(0.25);
  result.weighted_median = percentiles.weighted_at(0.5);
  result.weighted_third_quartile = percentiles.weighted_at(0.75);
  return result;
}

}  // namespace

FlipResult flip(const Image& reference, const Image& test, const FlipOptions& options) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::display && test.encoding == Encoding::display);
  Image map(reference.width, reference.height, 1);
  const FlipContext context = make_context(options);
  compare(context, {context.decode, reference, options.threads}, {context.decode, test, options.threads}, std::nullopt,
          options.threads, {map, nullptr});
  mark_not_finite_errors(reference, test, map);
  return pooled(std::move(map));
}

HdrFlipResult hdr_flip(const Image& reference, const Image& test, const FlipOptions& options) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::linear && test.encoding == Encoding::linear);
  const FlipContext context = make_context(options);
  const LinearPlanes reference_planes(context.decode, reference, options.threads);
  const LinearPlanes test_planes(context.decode, test, options.threads);
  const ExposureRange range = exposure_range(reference);
  HdrFlipResult result{.start = range.start, .stop = range.stop, .exposures = range.count};
  Image map(reference.width, reference.height, 1);
  result.at.assign(map.pixels.size(), 0);
  for (std::uint32_t i = 0; i < range.count; ++i) {
    const double exposure =
        range.count == 1 ? range.start : range.start + i * (range.stop - range.start) / (range.count - 1);
    const Exposure here{static_cast<float>(std::exp2(exposure)), static_cast<std::uint16_t>(i)};
    compare(context, reference_planes, test_planes, here, options.threads, {map, &result.at});
  }
  mark_not_finite_errors(reference, test, map);
  result.error = pooled(std::move(map));
  return result;
}

}  // namespace subpixel::replay
