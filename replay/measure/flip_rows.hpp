// The rows that FLIP works through: an image's colours, their filters, and the features that two images are compared
// by. For the same file as flip_lanes.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "replay/measure/flip_colour.hpp"
#include "replay/measure/flip_filters.hpp"
#include "replay/measure/flip_lanes.hpp"
#include "replay/measure/image.hpp"

namespace subpixel::replay {

// Calls `work(first, end)` for all rows, shared out to threads.
template <class Work>
void in_rows(int height, unsigned wanted_threads, const Work& work) {
  const int threads = std::clamp(static_cast<int>(wanted_threads), 1, std::max(height / 64, 1));
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads; ++i)
    workers.emplace_back([&, i] { work(height * i / threads, height * (i + 1) / threads); });
  work(0, height / threads);
}

// An image's three linear colours, each by itself: what every exposure starts from.
class LinearPlanes {
 public:
  LinearPlanes(const DecodeTable& decode, const Image& image, unsigned threads)
      : width_(static_cast<int>(image.width)), height_(static_cast<int>(image.height)) {
    // The last row is read in whole groups of lanes.
    for (auto& plane : planes_) plane.resize(image.pixels.size() / image.channels + lane_count);
    const bool grey = image.colour_channels() == 1;
    const bool linear = image.encoding == Encoding::linear;
    in_rows(height_, threads, [&](int first, int end) {
      const std::size_t width = image.width;
      for (std::size_t i = first * width; i < end * width; ++i) {
        const float* const pixel = &image.pixels[i * image.channels];
        for (int c = 0; c < 3; ++c) {
          const float stored = pixel[grey ? 0 : c];
          planes_[c][i] = linear ? stored : decode(stored);
        }
      }
    });
  }
  int width() const { return width_; }
  int height() const { return height_; }
  // Of `x` and the following pixels. Those beyond the image have some colour.
  Colour colour(int x, int y) const {
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + x;
    return {load(&planes_[0][at]), load(&planes_[1][at]), load(&planes_[2][at])};
  }

 private:
  int width_, height_;
  std::array<std::vector<float>, 3> planes_;
};

// Y, C_x and C_z (section 4.1.1) of an image's rows, as many as the vertical kernels reach over, newest in place of
// oldest.
class OpponentRows {
 public:
  // `exposure`: a factor on linear values, which then go through the tone curve.
  OpponentRows(const LinearPlanes& image, int radius, std::optional<float> exposure)
      : image_(image), radius_(radius), exposure_(exposure), row_of_slot_(2 * radius + 1, -1) {
    for (auto& plane : planes_) plane.assign(row_of_slot_.size(), PaddedRow(image.width(), 0));
  }

  enum Plane { luminance, red_green, blue_yellow, plane_count };

  // Makes rows `y` - radius to `y` + radius available; `y` grows from call to call.
  void advance(int y) {
    const int last = std::min(y + radius_, image_.height() - 1);
    for (int row = std::max(y - radius_, 0); row <= last; ++row) {
      const std::size_t slot = row % row_of_slot_.size();
      if (row_of_slot_[slot] == row) continue;
      row_of_slot_[slot] = row;
      load_row(row, slot);
    }
  }

  const float* row(Plane plane, int y) const {
    const int inside = std::clamp(y, 0, image_.height() - 1);
    return planes_[plane][inside % row_of_slot_.size()].data();
  }

  int width() const { return image_.width(); }

 private:
  // Y is 0..1 since both of its uses are linear in it.
  void load_row(int y, std::size_t slot) {
    float* const first = planes_[luminance][slot].data();
    float* const second = planes_[red_green][slot].data();
    float* const third = planes_[blue_yellow][slot].data();
    for (int x = 0; x < image_.width(); x += lane_count) {
      Colour rgb = image_.colour(x, y);
      if (exposure_)
        rgb = {tone_mapped(rgb.x, *exposure_), tone_mapped(rgb.y, *exposure_), tone_mapped(rgb.z, *exposure_)};
      const Colour xyz = to_xyz(rgb);
      store(first + x, xyz.y);
      store(second + x, xyz.x - xyz.y);
      store(third + x, xyz.y - xyz.z);
    }
  }

  const LinearPlanes& image_;
  int radius_;
  std::optional<float> exposure_;
  std::array<std::vector<PaddedRow>, plane_count> planes_;
  std::vector<int> row_of_slot_;
};

// One row of an image after the vertical halves of its filters.
struct FilteredRow {
  FilteredRow(std::uint32_t width, int margin)
      : achromatic(width, margin),
        red_green(width, margin),
        wide(width, margin),
        narrow(width, margin),
        smooth(width, margin),
        edge(width, margin),
        point(width, margin) {}
  PaddedRow achromatic, red_green;
  PaddedRow wide, narrow;         // the two Gaussians of blue-yellow
  PaddedRow smooth, edge, point;  // of the feature detectors
};

// The rows around `y` of one plane, from the centre: -radius to radius.
class Neighbours {
 public:
  Neighbours(const OpponentRows& rows, OpponentRows::Plane plane, int y, int radius) : radius_(radius) {
    rows_.resize(2 * radius + 1);
    for (int i = -radius; i <= radius; ++i) rows_[i + radius] = rows.row(plane, y + i);
  }
  Lanes at(std::ptrdiff_t i, int x) const { return load(rows_[i + radius_] + x); }

 private:
  int radius_;
  std::vector<const float*> rows_;
};

inline void filter_columns(const FlipKernels& k, const OpponentRows& rows, int y, FilteredRow& out) {
  const Neighbours luminance(rows, OpponentRows::luminance, y, k.radius);
  const Neighbours red_green(rows, OpponentRows::red_green, y, k.radius);
  const Neighbours blue_yellow(rows, OpponentRows::blue_yellow, y, k.radius);
  // Two groups of lanes at once, so that the rows' addresses are looked up once for both.
  using Pair = std::array<Lanes, 2>;
  for (int x = 0; x < rows.width(); x += 2 * lane_count) {
    // Calls `add(i, g, above, below)` for kernel weights `begin` to `end` of a plane and both groups.
    const auto taps = [x](const Neighbours& plane, std::size_t begin, std::size_t end, auto&& add) {
      for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(begin); i < static_cast<std::ptrdiff_t>(end); ++i) {
        for (int g = 0; g < 2; ++g) add(i, g, plane.at(-i, x + g * lane_count), plane.at(i, x + g * lane_count));
      }
    };
    const auto centre = [x](const Neighbours& plane, float weight) {
      return Pair{weight * plane.at(0, x), weight * plane.at(0, x + lane_count)};
    };
    const auto put = [x](PaddedRow& row, const Pair& value) {
      store(row.data() + x, value[0]);
      store(row.data() + x + lane_count, value[1]);
    };
    Pair achromatic = centre(luminance, k.achromatic[0]), smooth = centre(luminance, k.smooth[0]);
    const Pair twice_centre = centre(luminance, 2);
    Pair edge{}, point{};
    const auto blur = [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) {
      achromatic[g] += k.achromatic[i] * (above + below);
    };
    // The point detector's weights add up to 0, so the centre may be taken off every pixel. Where the image is flat the
    // answer is then 0 and not the rounding of the sum, which the square root at the end would blow up.
    const auto detect = [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) {
      smooth[g] += k.smooth[i] * (above + below);
      edge[g] += k.edge[i] * (below - above);
      point[g] += k.point[i] * ((above + below) - twice_centre[g]);
    };
    const std::size_t shared = std::min(k.achromatic.size(), k.smooth.size());
    taps(luminance, 1, shared, [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) {
      blur(i, g, above, below);
      detect(i, g, above, below);
    });
    taps(luminance, shared, k.achromatic.size(), blur);
    taps(luminance, shared, k.smooth.size(), detect);
    put(out.achromatic, achromatic);
    put(out.smooth, smooth);
    put(out.edge, edge);
    put(out.point, point);

    Pair opponent = centre(red_green, k.red_green[0]);
    taps(red_green, 1, k.red_green.size(),
         [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) { opponent[g] += k.red_green[i] * (above + below); });
    put(out.red_green, opponent);

    Pair wide = centre(blue_yellow, k.blue_yellow_wide[0]), narrow = centre(blue_yellow, k.blue_yellow_narrow[0]);
    const std::size_t short_kernel = k.blue_yellow_narrow.size();  // of the Gaussian that is narrower
    taps(blue_yellow, 1, short_kernel, [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) {
      wide[g] += k.blue_yellow_wide[i] * (above + below);
      narrow[g] += k.blue_yellow_narrow[i] * (above + below);
    });
    taps(blue_yellow, short_kernel, k.blue_yellow_wide.size(), [&](std::ptrdiff_t i, int g, Lanes above, Lanes below) {
      wide[g] += k.blue_yellow_wide[i] * (above + below);
    });
    put(out.wide, wide);
    put(out.narrow, narrow);
  }
  for (PaddedRow* row : {&out.achromatic, &out.red_green, &out.wide, &out.narrow, &out.smooth, &out.edge, &out.point})
    row->extend_border();
}

// What the comparison of two images needs of one of them, for one row.
struct RowFeatures {
  explicit RowFeatures(std::uint32_t width)
      : lightness(width, 0), a(width, 0), b(width, 0), edge(width, 0), point(width, 0) {}
  PaddedRow lightness, a, b;  // L*, a*, b* after the contrast sensitivity filter and the Hunt adjustment
  PaddedRow edge, point;      // squared lengths of the edge and point detectors' answers
};

inline Lanes symmetric(const float* at, const HalfKernel& kernel) {
  Lanes sum = kernel[0] * load(at);
  for (std::size_t k = 1; k < kernel.size(); ++k) sum += kernel[k] * (load(at - k) + load(at + k));
  return sum;
}

inline void compute_features(const FlipKernels& k, const FilteredRow& in, std::uint32_t width, RowFeatures& out) {
  for (std::uint32_t x = 0; x < width; x += lane_count) {
    const Lanes luminance = symmetric(in.achromatic.data() + x, k.achromatic);
    const Lanes cx = symmetric(in.red_green.data() + x, k.red_green);
    const Lanes cz = k.wide_share * symmetric(in.wide.data() + x, k.blue_yellow_wide) +
                     (1 - k.wide_share) * symmetric(in.narrow.data() + x, k.blue_yellow_narrow);
    const Lanes edge_y = symmetric(in.edge.data() + x, k.smooth), point_y = symmetric(in.point.data() + x, k.smooth);
    const float* const smooth = in.smooth.data() + x;
    const Lanes twice_centre = 2.0F * load(smooth);
    Lanes edge_x = all(0), point_x = all(0);
    for (std::size_t i = 1; i < k.edge.size(); ++i) {
      const Lanes left = load(smooth - i), right = load(smooth + i);
      edge_x += k.edge[i] * (right - left);
      point_x += k.point[i] * ((left + right) - twice_centre);
    }
    // Filtered opponent colours can leave the display's gamut; they are clamped to it in linear RGB.
    const Colour rgb = to_rgb({luminance + cx, luminance, luminance - cz});
    const Colour lab = hunt_lab(to_xyz({clamp_to_one(rgb.x), clamp_to_one(rgb.y), clamp_to_one(rgb.z)}));
    store(out.lightness.data() + x, lab.x);
    store(out.a.data() + x, lab.y);
    store(out.b.data() + x, lab.z);
    store(out.edge.data() + x, edge_x * edge_x + edge_y * edge_y);
    store(out.point.data() + x, point_x * point_x + point_y * point_y);
  }
}

}  // namespace subpixel::replay
