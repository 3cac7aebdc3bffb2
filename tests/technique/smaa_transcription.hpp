// SMAA 1x on the CPU: edges followed one at a time, areas by clipping polygons. It shares no table and no code with the
// technique. Jimenez, Echevarria, Sousa and Gutierrez 2012, and the authors' code for which line a pattern stands for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace subpixel::replay::smaa_transcription {

using Polygon = std::vector<glm::dvec2>;

// The part of a convex polygon where a x + b y + c >= 0.
inline Polygon clipped(const Polygon& polygon, double a, double b, double c) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    const double at_p = a * p.x + b * p.y + c, at_q = a * q.x + b * q.y + c;
    if (at_p >= 0) result.push_back(p);
    if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) result.push_back(p + (q - p) * (at_p / (at_p - at_q)));
  }
  return result;
}

// On this side of the directed line from `p` to `q`: its right.
inline Polygon right_of(const Polygon& polygon, glm::dvec2 p, glm::dvec2 q) {
  const glm::dvec2 d = q - p;
  return clipped(polygon, d.y, -d.x, d.x * p.y - d.y * p.x);
}

inline double area(const Polygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    sum += p.x * q.y - p.y * q.x;
  }
  return std::abs(sum) / 2;
}

inline Polygon box(double x, double y) {
  return {{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
}

// Between the axis y = 0 and the segment p-q, in the pixel column from x: below the axis, above it.
inline glm::dvec2 beside_axis(double x, glm::dvec2 p, glm::dvec2 q) {
  const auto within = [&](const Polygon& polygon) { return clipped(clipped(polygon, 1, 0, -p.x), -1, 0, q.x); };
  return {area(right_of(within(box(x, -1)), q, p)), area(right_of(within(box(x, 0)), p, q))};
}

// Ends: what crosses the edge above and below.
struct End {
  bool above = false, below = false;
};

inline glm::dvec2 line_areas(End first, End last, double left, double right) {
  const auto height = [](End end, End other) -> std::optional<double> {
    if (end.above != end.below) return end.above ? 0.5 : -0.5;
    if (end.above && other.above != other.below) return other.above ? -0.5 : 0.5;
    return std::nullopt;
  };
  const auto a = height(first, last), b = height(last, first);
  const double length = left + right + 1;
  const auto from_start = [&] { return beside_axis(left, {0, *a}, {length / 2, 0}); };
  const auto to_end = [&] { return beside_axis(left, {length / 2, 0}, {length, *b}); };
  if (a && b && *a != *b) return beside_axis(left, {0, *a}, {length, *b});
  if (a && b) {
    glm::dvec2 sum(0);
    for (const glm::dvec2 part : {from_start(), to_end()}) {
      const double plain = std::min(length / 32, 1.0);
      for (int k = 0; k < 2; ++k) sum[k] += plain * part[k] + (1 - plain) * std::sqrt(part[k] / 2);
    }
    return sum;
  }
  if (a && left <= right) return from_start();
  if (b && right <= left) return to_end();
  return {0, 0};
}

// Ends of a staircase: whether its level and its upright edge go on.
struct StairEnd {
  bool level = false, upright = false;
};

inline glm::dvec2 diagonal_areas(StairEnd first, StairEnd last, double left, double right) {
  const double length = left + right + 1;
  glm::dvec2 sum(0);
  for (int which = 0; which < 2; ++which) {
    const auto corner = [&](StairEnd end) {
      if (end.level && end.upright) return which == 0 ? glm::dvec2(1, 1) : glm::dvec2(1, 0);
      return glm::dvec2(end.level || end.upright || which == 1 ? 1 : 0, 0);
    };
    glm::dvec2 p = corner(first), q = corner(last);
    if (first.level && !first.upright) p = {1, 1};
    if (last.upright && !last.level) q = {1, 1};
    q += length;
    if (p == q) continue;
    sum.x += (1 - area(right_of(box(left + 1, left), p, q))) / 2;
    sum.y += area(right_of(box(left + 1, left + 1), p, q)) / 2;
  }
  return sum;
}

// Interpolated between squares of integers, as the published table is laid out.
inline glm::dvec2 compressed_line_areas(End first, End last, int left, int right) {
  const auto place = [](int distance) {
    const double root = std::sqrt(static_cast<double>(distance)), low = std::min(std::floor(root), 14.0);
    return std::pair(low, root - low);
  };
  const auto [x, fx] = place(left);
  const auto [y, fy] = place(right);
  glm::dvec2 sum(0);
  for (int i = 0; i < 4; ++i) {
    const double u = x + (i & 1), v = y + (i >> 1);
    const double weight = ((i & 1) != 0 ? fx : 1 - fx) * ((i >> 1) != 0 ? fy : 1 - fy);
    if (weight > 0) sum += weight * line_areas(first, last, u * u, v * v);
  }
  return sum;
}

struct Settings {
  double threshold = 0.1, adaptation = 2;
  bool colour = false;
  int search_steps = 16, diagonal_steps = 8;
  double rounding = 0.25;
};

template <typename T>
struct Grid {
  int width = 0, height = 0;
  std::vector<T> values;
  Grid(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  std::size_t index(int x, int y) const {
    x = std::clamp(x, 0, width - 1);
    y = std::clamp(y, 0, height - 1);
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  T at(int x, int y) const { return values[index(x, y)]; }
  void set(int x, int y, T value) { values[index(x, y)] = value; }
  Grid transposed() const {
    Grid result(height, width);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) result.set(y, x, at(x, y));
    return result;
  }
};

struct Edges {
  Grid<int> north, west;
  Edges transposed() const { return {west.transposed(), north.transposed()}; }
};

inline Edges find_edges(const Grid<glm::vec3>& shown, const Settings& settings) {
  const auto step = [&](int x, int y, int u, int v) {
    const glm::vec3 a = shown.at(x, y), b = shown.at(u, v), d = glm::abs(a - b);
    const glm::vec3 luma(0.2126f, 0.7152f, 0.0722f);
    return settings.colour ? std::max({d.x, d.y, d.z}) : std::abs(glm::dot(a, luma) - glm::dot(b, luma));
  };
  Edges edges{{shown.width, shown.height}, {shown.width, shown.height}};
  for (int y = 0; y < shown.height; ++y) {
    for (int x = 0; x < shown.width; ++x) {
      const float west = step(x, y, x - 1, y), north = step(x, y, x, y - 1);
      const float most = std::max({west, north, step(x, y, x + 1, y), step(x, y, x, y + 1), step(x - 1, y, x - 2, y),
                                   step(x, y - 1, x, y - 2)});
      const auto counts = [&](float contrast) {
        return contrast >= static_cast<float>(settings.threshold) &&
               static_cast<float>(settings.adaptation) * contrast >= most;
      };
      edges.west.set(x, y, counts(west) ? 1 : 0);
      edges.north.set(x, y, counts(north) ? 1 : 0);
    }
  }
  return edges;
}

// Weights of level edges: of the pixel and of its northern neighbour.
inline glm::dvec2 level_weights(const Edges& edges, int x, int y, const Settings& settings) {
  const auto crossed = [&](int at) { return End{edges.west.at(at, y - 1) == 1, edges.west.at(at, y) == 1}; };
  const auto open = [&](int at) { return !crossed(at).above && !crossed(at).below; };
  int first = x, last = x;
  while (x - first < 2 * settings.search_steps - 1 && open(first) && edges.north.at(first - 1, y) == 1) --first;
  while (last - x < 2 * settings.search_steps && open(last + 1) && edges.north.at(last + 1, y) == 1) ++last;
  const int left = x - first, right = last - x;
  glm::dvec2 weights = compressed_line_areas(crossed(first), crossed(last + 1), left, right);
  glm::dvec2 factor(1);
  const double lost = (1 - settings.rounding) * (left == right ? 0.5 : 1.0);
  for (int side = 0; side < 2; ++side) {
    const int row = side == 0 ? y + 1 : y - 2;
    if (left <= right) factor[side] -= lost * edges.west.at(first, row);
    if (right <= left) factor[side] -= lost * edges.west.at(last + 1, row);
  }
  return weights * glm::max(factor, glm::dvec2(0));
}

inline glm::dvec2 diagonal_weights(const Edges& edges, int x, int y, const Settings& settings) {
  glm::dvec2 sum(0);
  for (const int rising : {1, 0}) {
    // Steps of a rising staircase have both edges in one pixel, of a falling one the upright edge is one to the right.
    const int beside = 1 - rising, down = rising == 1 ? -1 : 1;
    const auto north = [&](int k) { return edges.north.at(x + k, y + down * k) == 1; };
    const auto upright = [&](int k) { return edges.west.at(x + k + beside, y + down * k) == 1; };
    const auto walk = [&](int sign, bool half_step, bool& ends) {
      for (int k = 1; k <= settings.diagonal_steps; ++k) {
        if (north(sign * k) && upright(sign * k)) continue;
        ends = true;
        return k - 1 + (half_step && north(sign * k) ? 1 : 0);
      }
      ends = false;
      return settings.diagonal_steps - 1 + (half_step ? 1 : 0);
    };
    bool ends_left = true, ends_right = true;
    int left = 0, right = 0;
    if (rising == 0 || upright(0)) left = walk(-1, rising == 1, ends_left);
    if (rising == 1 || upright(0)) right = walk(1, rising == 0, ends_right);
    if (left + right <= 2) continue;
    const int x0 = x - left, y0 = y - down * left, x1 = x + right, y1 = y + down * right;
    StairEnd first{edges.north.at(x0 - 1, y0) == 1, edges.west.at(x0, rising == 1 ? y0 : y0 - 1) == 1};
    StairEnd last{edges.north.at(x1 + 1, y1) == 1, edges.west.at(x1 + 1, rising == 1 ? y1 - 1 : y1) == 1};
    if (!ends_left) first = {};
    if (!ends_right) last = {};
    const glm::dvec2 found = diagonal_areas(first, last, std::min(left, 19), std::min(right, 19));
    sum += rising == 1 ? found : glm::dvec2(found.y, found.x);
  }
  return sum;
}

// Of the pixel and its northern, of the pixel and its western neighbour; not rounded to bytes.
inline Grid<glm::dvec4> find_weights(const Edges& edges, const Settings& settings) {
  const Edges turned = edges.transposed();
  Grid<glm::dvec4> weights(edges.north.width, edges.north.height);
  for (int y = 0; y < weights.height; ++y) {
    for (int x = 0; x < weights.width; ++x) {
      glm::dvec2 level(0), upright(0);
      bool diagonal = false;
      if (edges.north.at(x, y) == 1) {
        if (settings.diagonal_steps > 0) level = diagonal_weights(edges, x, y, settings);
        diagonal = level.x + level.y > 0;
        if (!diagonal) level = level_weights(edges, x, y, settings);
      }
      if (edges.west.at(x, y) == 1 && !diagonal) upright = level_weights(turned, y, x, settings);
      weights.set(x, y, glm::clamp(glm::dvec4(level, upright), 0.0, 1.0));
    }
  }
  return weights;
}

// The blended values and the neighbours' shares.
struct Blended {
  Grid<glm::dvec3> values;
  Grid<double> shares;
};
inline Blended blend(const Grid<glm::dvec3>& values, const Grid<glm::dvec4>& weights) {
  Blended result{{values.width, values.height}, {values.width, values.height}};
  const auto byte = [](double weight) { return std::floor(weight * 255 + 0.5) / 255; };
  for (int y = 0; y < values.height; ++y) {
    for (int x = 0; x < values.width; ++x) {
      const double north = byte(weights.at(x, y).x), south = byte(weights.at(x, y + 1).y);
      const double west = byte(weights.at(x, y).z), east = byte(weights.at(x + 1, y).w);
      const bool sideways = std::max(west, east) > std::max(north, south);
      const double a = sideways ? west : north, b = sideways ? east : south;
      const glm::dvec3 own = values.at(x, y);
      glm::dvec3 value = own;
      double share = 0;
      if (a + b > 0) {
        const glm::dvec3 before = sideways ? values.at(x - 1, y) : values.at(x, y - 1);
        const glm::dvec3 after = sideways ? values.at(x + 1, y) : values.at(x, y + 1);
        value += (a * a * (before - own) + b * b * (after - own)) / (a + b);
        share = (a * a + b * b) / (a + b);
      }
      result.values.set(x, y, value);
      result.shares.set(x, y, share);
    }
  }
  return result;
}

}  // namespace subpixel::replay::smaa_transcription
