#include "replay/measure/flip.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>
#include <thread>

#include "capture_format/error.hpp"
#include "replay/measure/flip_exposures.hpp"
#include "replay/measure/flip_lanes.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/measure/percentiles.hpp"

namespace subpixel::replay {
namespace {

// Linear sRGB to CIE XYZ over the white point (IEC 61966-2-1 primaries, D65), so that white is (1, 1, 1), and back.
struct Colour {
  Lanes x, y, z;
};

constexpr double xyz_from_rgb[3][3] = {{10135552.0 / 23359437, 8788810.0 / 23359437, 4435075.0 / 23359437},
                                       {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                       {1425312.0 / 80288307, 8788810.0 / 80288307, 70074185.0 / 80288307}};

// Inverse of a 3x3 matrix by cofactors.
constexpr std::array<std::array<float, 3>, 3> inverse(const double (&m)[3][3]) {
  std::array<std::array<float, 3>, 3> out{};
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (j + 1) % 3;
      const int b = (j + 2) % 3;
      const int c = (i + 1) % 3;
      const int d = (i + 2) % 3;
      out[i][j] = static_cast<float>((m[a][c] * m[b][d] - m[a][d] * m[b][c]) / determinant);
    }
  }
  return out;
}

constexpr std::array<std::array<float, 3>, 3> rgb_from_xyz = inverse(xyz_from_rgb);

Colour to_xyz(const Colour& rgb) {
  const auto row = [&](const double(&m)[3]) {
    return static_cast<float>(m[0]) * rgb.x + static_cast<float>(m[1]) * rgb.y + static_cast<float>(m[2]) * rgb.z;
  };
  return {row(xyz_from_rgb[0]), row(xyz_from_rgb[1]), row(xyz_from_rgb[2])};
}

Colour to_rgb(const Colour& xyz) {
  const auto row = [&](const std::array<float, 3>& m) { return m[0] * xyz.x + m[1] * xyz.y + m[2] * xyz.z; };
  return {row(rgb_from_xyz[0]), row(rgb_from_xyz[1]), row(rgb_from_xyz[2])};
}

// CIELAB's companding (CIE 15).
Lanes lab_curve(Lanes value) {
  constexpr float delta = 6.0F / 29.0F;
  const Lanes straight = value * (1.0F / (3.0F * delta * delta)) + 4.0F / 29.0F;
  const LaneBits above = value > delta * delta * delta;
  return above ? cube_root(above ? value : all(1)) : straight;
}

// L*, and a* and b* scaled by lightness: the Hunt effect (section 4.1.2).
Colour hunt_lab(const Colour& xyz) {
  const Lanes x = lab_curve(xyz.x);
  const Lanes y = lab_curve(xyz.y);
  const Lanes z = lab_curve(xyz.z);
  const Lanes lightness = 116.0F * y - 16.0F;
  const Lanes hunt = 0.01F * lightness;
  return {lightness, hunt * (500.0F * (x - y)), hunt * (200.0F * (y - z))};
}

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

// sRGB decoding by linear interpolation between 16 points for each step of an 8-bit value: exact at 8-bit values, and
// within 3e-8 between them.
class DecodeTable {
 public:
  DecodeTable() {
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const double display = static_cast<double>(std::min(i, steps)) / steps;
      const double linear = display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
      table_[i] = static_cast<float>(linear);
    }
  }
  float operator()(float display) const {
    if (!(display > 0)) return 0;
    const float at = std::min(display, 1.0F) * static_cast<float>(steps);
    const auto below = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(below);
    return table_[below] + share * (table_[below + 1] - table_[below]);
  }

 private:
  static constexpr std::size_t steps = 255 * 16;
  std::array<float, steps + 2> table_{};
};

struct FlipContext {
  FlipKernels kernels;
  DecodeTable decode;
  float largest_difference = largest_colour_difference();
};

// Horizontally filtered rows of one image, as many as the vertical kernels reach over, newest in place of oldest.
class FilteredRows {
 public:
  // `exposure`: a factor on linear values, which then go through the tone curve.
  FilteredRows(const FlipContext& context, const Image& image, std::optional<float> exposure)
      : context_(context),
        image_(image),
        exposure_(exposure),
        y_(image.width, context.kernels.radius),
        cx_(image.width, context.kernels.radius),
        cz_(image.width, context.kernels.radius),
        row_of_slot_(2 * context.kernels.radius + 1, -1) {
    for (auto& plane : planes_) plane.assign(row_of_slot_.size(), PaddedRow(image.width, 0));
  }

  enum Plane { achromatic, red_green, blue_yellow_wide, blue_yellow_narrow, smooth, edge, point, plane_count };

  // Makes rows `y` - radius to `y` + radius available; `y` grows from call to call.
  void advance(int y) {
    const int last = std::min(y + context_.kernels.radius, static_cast<int>(image_.height) - 1);
    for (int row = std::max(y - context_.kernels.radius, 0); row <= last; ++row) {
      const std::size_t slot = row % row_of_slot_.size();
      if (row_of_slot_[slot] == row) continue;
      row_of_slot_[slot] = row;
      filter_row(row, slot);
    }
  }

  const float* row(Plane plane, int y) const {
    const int inside = std::clamp(y, 0, static_cast<int>(image_.height) - 1);
    return planes_[plane][inside % row_of_slot_.size()].data();
  }

  std::uint32_t width() const { return image_.width; }

 private:
  // Y, C_x and C_z of a row (section 4.1.1), Y as 0..1 since both of its uses are linear in it.
  void load_row(int y) {
    const float* pixel = &image_.pixels[image_.offset(0, static_cast<std::uint32_t>(y))];
    const bool grey = image_.colour_channels() == 1;
    const bool linear = image_.encoding == Encoding::linear;
    const auto value = [&](float stored) { return linear ? stored : context_.decode(stored); };
    for (std::uint32_t x = 0; x < image_.width; ++x, pixel += image_.channels) {
      const float r = value(pixel[0]);
      y_.data()[x] = r;
      cx_.data()[x] = grey ? r : value(pixel[1]);
      cz_.data()[x] = grey ? r : value(pixel[2]);
    }
    for (std::uint32_t x = 0; x < image_.width; x += lane_count) {
      Colour rgb{load(y_.data() + x), load(cx_.data() + x), load(cz_.data() + x)};
      if (exposure_)
        rgb = {tone_mapped(rgb.x, *exposure_), tone_mapped(rgb.y, *exposure_), tone_mapped(rgb.z, *exposure_)};
      const Colour xyz = to_xyz(rgb);
      store(y_.data() + x, xyz.y);
      store(cx_.data() + x, xyz.x - xyz.y);
      store(cz_.data() + x, xyz.y - xyz.z);
    }
    y_.extend_border();
    cx_.extend_border();
    cz_.extend_border();
  }

  static Lanes symmetric(const float* at, const HalfKernel& kernel) {
    Lanes sum = kernel[0] * load(at);
    for (std::size_t k = 1; k < kernel.size(); ++k) sum += kernel[k] * (load(at - k) + load(at + k));
    return sum;
  }

  void filter_row(int y, std::size_t slot) {
    load_row(y);
    const FlipKernels& k = context_.kernels;
    for (std::uint32_t x = 0; x < image_.width; x += lane_count) {
      const auto put = [&](Plane plane, Lanes value) { store(planes_[plane][slot].data() + x, value); };
      put(achromatic, symmetric(y_.data() + x, k.achromatic));
      put(red_green, symmetric(cx_.data() + x, k.red_green));
      // Two Gaussians of one channel; the narrow one has the shorter kernel.
      const float* const opponent = cz_.data() + x;
      Lanes wide_sum = k.blue_yellow_wide[0] * load(opponent);
      Lanes narrow_sum = k.blue_yellow_narrow[0] * load(opponent);
      for (std::size_t i = 1; i < k.blue_yellow_wide.size(); ++i) {
        const Lanes both = load(opponent - i) + load(opponent + i);
        wide_sum += k.blue_yellow_wide[i] * both;
        if (i < k.blue_yellow_narrow.size()) narrow_sum += k.blue_yellow_narrow[i] * both;
      }
      put(blue_yellow_wide, wide_sum);
      put(blue_yellow_narrow, narrow_sum);
      const float* at = y_.data() + x;
      Lanes smooth_sum = k.smooth[0] * load(at);
      Lanes point_sum = all(0);
      Lanes edge_sum = all(0);
      const Lanes twice_centre = 2.0F * load(at);
      for (std::size_t i = 1; i < k.smooth.size(); ++i) {
        const Lanes left = load(at - i);
        const Lanes right = load(at + i);
        smooth_sum += k.smooth[i] * (left + right);
        point_sum += k.point[i] * ((left + right) - twice_centre);
        edge_sum += k.edge[i] * (right - left);
      }
      put(smooth, smooth_sum);
      put(point, point_sum);
      put(edge, edge_sum);
    }
  }

  const FlipContext& context_;
  const Image& image_;
  std::optional<float> exposure_;
  PaddedRow y_, cx_, cz_;
  std::array<std::vector<PaddedRow>, plane_count> planes_;
  std::vector<int> row_of_slot_;
};

// What the comparison of two images needs of one of them, for one row.
struct RowFeatures {
  explicit RowFeatures(std::uint32_t width)
      : lightness(width, 0), a(width, 0), b(width, 0), edge(width, 0), point(width, 0) {}
  PaddedRow lightness, a, b;  // L*, a*, b* after the contrast sensitivity filter and the Hunt adjustment
  PaddedRow edge, point;      // squared lengths of the edge and point detectors' answers
};

// Vertical filters over the rows around `y`.
class VerticalFilter {
 public:
  VerticalFilter(const FilteredRows& rows, int y, int radius) : radius_(radius) {
    pointers_.resize(FilteredRows::plane_count * (2 * radius + 1));
    for (int plane = 0; plane < FilteredRows::plane_count; ++plane) {
      for (int k = -radius; k <= radius; ++k) {
        pointers_[plane * (2 * radius + 1) + k + radius] = rows.row(static_cast<FilteredRows::Plane>(plane), y + k);
      }
    }
  }

  // Two groups of lanes, from `x` and the next, so that the rows' addresses are looked up once for both.
  using Pair = std::array<Lanes, 2>;

  Pair symmetric(int plane, const HalfKernel& kernel, std::uint32_t x) const {
    const float* const* centre = &pointers_[plane * (2 * radius_ + 1) + radius_];
    Pair sum = {kernel[0] * load(centre[0] + x), kernel[0] * load(centre[0] + x + lane_count)};
    for (std::ptrdiff_t k = 1; k < static_cast<std::ptrdiff_t>(kernel.size()); ++k) {
      const float *above = centre[-k] + x, *below = centre[k] + x;
      sum[0] += kernel[k] * (load(above) + load(below));
      sum[1] += kernel[k] * (load(above + lane_count) + load(below + lane_count));
    }
    return sum;
  }

  struct Detected {
    Pair edge, point;
  };
  // An antisymmetric and a second difference's kernel of one length. The point detector's weights add up to 0, so the
  // centre may be taken off every pixel. Where the image is flat the answer is then 0 and not the rounding of the sum,
  // which the square root at the end would blow up.
  Detected detect(int plane, const HalfKernel& edge, const HalfKernel& point, std::uint32_t x) const {
    const float* const* centre = &pointers_[plane * (2 * radius_ + 1) + radius_];
    Detected sum = {{all(0), all(0)}, {all(0), all(0)}};
    const Pair twice_centre = {2.0F * load(centre[0] + x), 2.0F * load(centre[0] + x + lane_count)};
    for (std::ptrdiff_t k = 1; k < static_cast<std::ptrdiff_t>(edge.size()); ++k) {
      for (int g = 0; g < 2; ++g) {
        const Lanes above = load(centre[-k] + x + g * lane_count), below = load(centre[k] + x + g * lane_count);
        sum.edge[g] += edge[k] * (below - above);
        sum.point[g] += point[k] * ((above + below) - twice_centre[g]);
      }
    }
    return sum;
  }

 private:
  int radius_;
  std::vector<const float*> pointers_;
};

void compute_features(const FlipContext& context, const FilteredRows& rows, int y, RowFeatures& out) {
  using enum FilteredRows::Plane;
  const FlipKernels& k = context.kernels;
  const VerticalFilter filter(rows, y, k.radius);
  // The last pair may go a group beyond the row, where rows have room.
  for (std::uint32_t x = 0; x < rows.width(); x += 2 * lane_count) {
    const auto luminance = filter.symmetric(achromatic, k.achromatic, x);
    const auto cx = filter.symmetric(red_green, k.red_green, x);
    const auto wide = filter.symmetric(blue_yellow_wide, k.blue_yellow_wide, x);
    const auto narrow = filter.symmetric(blue_yellow_narrow, k.blue_yellow_narrow, x);
    const auto edge_x = filter.symmetric(edge, k.smooth, x), point_x = filter.symmetric(point, k.smooth, x);
    const auto along_y = filter.detect(smooth, k.edge, k.point, x);
    for (int g = 0; g < 2; ++g) {
      const std::uint32_t at = x + g * lane_count;
      const Lanes cz = k.wide_share * wide[g] + (1 - k.wide_share) * narrow[g];
      // Filtered opponent colours can leave the display's gamut; they are clamped to it in linear RGB.
      const Colour rgb = to_rgb({luminance[g] + cx[g], luminance[g], luminance[g] - cz});
      const Colour lab = hunt_lab(to_xyz({clamp_to_one(rgb.x), clamp_to_one(rgb.y), clamp_to_one(rgb.z)}));
      store(out.lightness.data() + at, lab.x);
      store(out.a.data() + at, lab.y);
      store(out.b.data() + at, lab.z);
      store(out.edge.data() + at, edge_x[g] * edge_x[g] + along_y.edge[g] * along_y.edge[g]);
      store(out.point.data() + at, point_x[g] * point_x[g] + along_y.point[g] * along_y.point[g]);
    }
  }
}

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

inline void flip_rows(const FlipContext& context, const Image& reference, const Image& test,
                      const std::optional<Exposure>& exposure, int first, int end, const ErrorMaps& maps) {
  const std::optional<float> factor = exposure ? std::optional(exposure->factor) : std::nullopt;
  FilteredRows reference_rows(context, reference, factor);
  FilteredRows test_rows(context, test, factor);
  RowFeatures reference_features(reference.width);
  RowFeatures test_features(test.width);
  PaddedRow errors(reference.width, 0);
  for (int y = first; y < end; ++y) {
    reference_rows.advance(y);
    test_rows.advance(y);
    compute_features(context, reference_rows, y, reference_features);
    compute_features(context, test_rows, y, test_features);
    for (std::uint32_t x = 0; x < reference.width; x += lane_count)
      store(errors.data() + x, pixel_errors(context, reference_features, test_features, x));
    const std::size_t row = maps.error.offset(0, static_cast<std::uint32_t>(y));
    for (std::uint32_t x = 0; x < reference.width; ++x) {
      if (!(errors.data()[x] > maps.error.pixels[row + x])) continue;
      maps.error.pixels[row + x] = errors.data()[x];
      if (maps.at) (*maps.at)[row + x] = exposure->number;
    }
  }
}

// The same code with the instructions of newer processors: the same operations, so the same bits.
#if defined(__x86_64__)
__attribute__((target("avx2"), flatten)) void flip_rows_avx2(const FlipContext& context, const Image& reference,
                                                             const Image& test, const std::optional<Exposure>& exposure,
                                                             int first, int end, const ErrorMaps& maps) {
  flip_rows(context, reference, test, exposure, first, end, maps);
}
const bool has_avx2 = __builtin_cpu_supports("avx2");
#endif

void flip_rows_here(const FlipContext& context, const Image& reference, const Image& test,
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

// Into `maps`, rows shared out to threads.
void compare(const FlipContext& context, const Image& reference, const Image& test,
             const std::optional<Exposure>& exposure, unsigned wanted_threads, const ErrorMaps& maps) {
  const int height = static_cast<int>(reference.height);
  const int threads = std::clamp(static_cast<int>(wanted_threads), 1, std::max(height / 64, 1));
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads; ++i) {
    workers.emplace_back([&, i] {
      flip_rows_here(context, reference, test, exposure, height * i / threads, height * (i + 1) / threads, maps);
    });
  }
  flip_rows_here(context, reference, test, exposure, 0, height / threads, maps);
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
  compare(make_context(options), reference, test, std::nullopt, options.threads, {map, nullptr});
  return pooled(std::move(map));
}

HdrFlipResult hdr_flip(const Image& reference, const Image& test, const FlipOptions& options) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::linear && test.encoding == Encoding::linear);
  const FlipContext context = make_context(options);
  const ExposureRange range = exposure_range(reference);
  HdrFlipResult result{.start = range.start, .stop = range.stop, .exposures = range.count};
  Image map(reference.width, reference.height, 1);
  result.at.assign(map.pixels.size(), 0);
  for (std::uint32_t i = 0; i < range.count; ++i) {
    const double exposure =
        range.count == 1 ? range.start : range.start + i * (range.stop - range.start) / (range.count - 1);
    const Exposure here{static_cast<float>(std::exp2(exposure)), static_cast<std::uint16_t>(i)};
    compare(context, reference, test, here, options.threads, {map, &result.at});
  }
  result.error = pooled(std::move(map));
  return result;
}

}  // namespace subpixel::replay
