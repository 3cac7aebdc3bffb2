#include "scenes/generate/textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <utility>

#include "scenes/builder/camera.hpp"
#include "scenes/generate/random.hpp"

namespace subpixel::capture {
namespace {

std::byte to_byte(double value) {
  return static_cast<std::byte>(std::floor(std::clamp(value, 0.0, 255.0) + 0.5));
}

// `texel` gets the centre of each texel in [0, 1)^2 and returns colour and alpha in 0 to 255.
Texture fill(std::string name, std::uint32_t width, std::uint32_t height, bool srgb,
             const std::function<glm::dvec4(double, double)>& texel) {
  Texture texture{std::move(name), TextureEncoding::rgba8, srgb, width, height, {}};
  texture.bytes.reserve(std::size_t{4} * width * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const glm::dvec4 value = texel((x + 0.5) / width, (y + 0.5) / height);
      for (int c = 0; c < 4; ++c) texture.bytes.push_back(to_byte(value[c]));
    }
  }
  return texture;
}

double lattice_value(std::uint64_t x, std::uint64_t y, std::uint64_t seed) {
  return Random(seed ^ (x * 0xd1342543de82ef95u) ^ (y * 0xaf251af3b0f025b5u)).unit();
}

double smooth(double t) {
  return t * t * (3 - 2 * t);
}

double smooth_step(double low, double high, double x) {
  return smooth(std::clamp((x - low) / (high - low), 0.0, 1.0));
}

struct BrickAt {
  double edge;         // distance to the brick's nearest edge, in brick heights; negative in no case
  std::uint64_t hash;  // of the brick
  bool odd;            // in a chequered pattern
};

BrickAt brick_at(const BrickPattern& pattern, double u, double v, std::uint64_t seed) {
  const double row_position = v * pattern.rows;
  const auto row = static_cast<std::uint32_t>(row_position);
  const double shifted = u * pattern.columns + ((row & 1) != 0 ? pattern.shift : 0.0);
  const double column_position = shifted - std::floor(shifted / pattern.columns) * pattern.columns;
  const auto column = static_cast<std::uint32_t>(column_position);
  const double x = column_position - column;
  const double y = row_position - row;
  const double brick_length = static_cast<double>(pattern.rows) / pattern.columns;  // in brick heights
  const double edge = std::min(std::min(x, 1 - x) * brick_length, std::min(y, 1 - y));
  return {edge, Random(seed + row * 7919ull + column).next(), ((row + column) & 1) != 0};
}

double brick_height(const BrickPattern& pattern, double u, double v, std::uint64_t seed) {
  return smooth_step(pattern.mortar * 0.5, pattern.mortar * 1.6, brick_at(pattern, u, v, seed).edge);
}

}  // namespace

double tileable_noise(double x, double y, std::uint32_t period, std::uint32_t octaves, std::uint64_t seed) {
  double sum = 0;
  double weight = 1;
  double total = 0;
  for (std::uint32_t octave = 0; octave < octaves; ++octave) {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const double tx = smooth(x - fx);
    const double ty = smooth(y - fy);
    const auto wrap = [&](double cell) {
      return static_cast<std::uint64_t>(cell - std::floor(cell / period) * period);
    };
    const std::uint64_t x0 = wrap(fx);
    const std::uint64_t x1 = wrap(fx + 1);
    const std::uint64_t y0 = wrap(fy);
    const std::uint64_t y1 = wrap(fy + 1);
    const double top = lattice_value(x0, y0, seed) * (1 - tx) + lattice_value(x1, y0, seed) * tx;
    const double bottom = lattice_value(x0, y1, seed) * (1 - tx) + lattice_value(x1, y1, seed) * tx;
    sum += weight * (top * (1 - ty) + bottom * ty);
    total += weight;
    weight *= 0.5;
    x *= 2;
    y *= 2;
    period *= 2;
    seed += 0x632be59bd9b4e019u;
  }
  return sum / total;
}

Texture noise_texture(std::string name, std::uint32_t side, std::uint32_t cells, const glm::dvec3& low,
                      const glm::dvec3& high, std::uint64_t seed) {
  return fill(std::move(name), side, side, true, [&](double u, double v) {
    const double t = tileable_noise(u * cells, v * cells, cells, 5, seed);
    return glm::dvec4(glm::mix(low, high, smooth_step(0.2, 0.8, t)), 255);
  });
}

Texture brick_texture(std::string name, std::uint32_t side, const BrickPattern& pattern, std::uint64_t seed) {
  return fill(std::move(name), side, side, true, [&](double u, double v) {
    const BrickAt brick = brick_at(pattern, u, v, seed);
    const double tint = pattern.chequered ? (brick.odd ? 1.0 : 0.0) : static_cast<double>(brick.hash >> 11) * 0x1p-53;
    const double grain = 0.86 + 0.28 * tileable_noise(u * 64, v * 64, 64, 3, seed + 1);
    const double top = smooth_step(pattern.mortar * 0.5, pattern.mortar * 1.2, brick.edge);
    const glm::dvec3 colour = glm::mix(pattern.joint, glm::mix(pattern.brick, pattern.brick_other, tint), top);
    return glm::dvec4(colour * grain, 255);
  });
}

Texture brick_normal_texture(std::string name, std::uint32_t side, const BrickPattern& pattern, double depth,
                             std::uint64_t seed) {
  const double step = 1.0 / side;
  const auto height = [&](double u, double v) {
    const double wrapped_u = u - std::floor(u);
    const double wrapped_v = v - std::floor(v);
    return depth * (brick_height(pattern, wrapped_u, wrapped_v, seed) +
                    0.15 * tileable_noise(wrapped_u * 64, wrapped_v * 64, 64, 2, seed + 1));
  };
  return fill(std::move(name), side, side, false, [&](double u, double v) {
    const double dx = (height(u + step, v) - height(u - step, v)) / (2 * step);
    const double dy = (height(u, v - step) - height(u, v + step)) / (2 * step);  // +Y is up the image
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-dx, -dy, 1));
    return glm::dvec4((normal * 0.5 + 0.5) * 255.0, 255);
  });
}

Texture stained_glass_texture(std::string name, std::uint32_t side, std::uint32_t cells, std::uint64_t seed) {
  constexpr std::array<glm::dvec3, 6> kGlass{
      {{28, 52, 160}, {168, 24, 30}, {214, 160, 40}, {30, 110, 62}, {120, 40, 120}, {190, 206, 220}}};
  return fill(std::move(name), side, side, true, [&](double u, double v) {
    // The nearest and second nearest of points jittered on a grid (Worley 1996) tell the piece and its border.
    const double x = u * cells;
    const double y = v * cells;
    double nearest = 9;
    double second = 9;
    std::uint64_t piece = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double cell_x = std::floor(x) + dx;
        const double cell_y = std::floor(y) + dy;
        const auto wrapped = [&](double cell) {
          return static_cast<std::uint64_t>(cell - std::floor(cell / cells) * cells);
        };
        Random random(seed + wrapped(cell_y) * 7919 + wrapped(cell_x));
        const double away_x = cell_x + random.between(0.1, 0.9) - x;
        const double away_y = cell_y + random.between(0.1, 0.9) - y;
        const double distance = std::sqrt(away_x * away_x + away_y * away_y);
        if (distance < nearest) {
          second = nearest;
          nearest = distance;
          piece = random.next();
        } else {
          second = std::min(second, distance);
        }
      }
    const double lit = smooth_step(0.06, 0.14, second - nearest);
    return glm::dvec4(glm::mix(glm::dvec3(6), kGlass[piece % kGlass.size()], lit), 255);
  });
}

Texture blade_texture(std::string name, std::uint32_t width, std::uint32_t height, const glm::dvec3& root,
                      const glm::dvec3& tip) {
  return fill(std::move(name), width, height, true, [&](double u, double v) {
    const double rib = 1 + 0.18 * (1 - smooth_step(0.0, 0.12, std::abs(u - 0.5)));
    return glm::dvec4(glm::mix(tip, root, v * v) * rib, 255);
  });
}

Texture leaf_texture(std::string name, std::uint32_t side, const glm::dvec3& leaf, std::uint64_t seed) {
  struct Leaf {
    glm::dvec2 root, along;
    double length, tint;
  };
  Random random(seed);
  std::vector<Leaf> leaves;
  for (int i = 0; i < 9; ++i) {  // pairs along the stem, the last at its tip
    const double turn = i == 8 ? 0.0 : (i % 2 == 0 ? -1 : 1) * random.between(0.7, 1.15);
    const int pair = i / 2;
    const double up = 0.92 - 0.15 * pair;
    leaves.push_back({{0.5, up}, {sine(turn), -cosine(turn)}, random.between(0.3, 0.38), random.between(0.8, 1.15)});
  }
  return fill(std::move(name), side, side, true, [&](double u, double v) {
    const glm::dvec2 at(u, v);
    glm::dvec4 value(leaf * 0.8, 0);
    if (std::abs(u - 0.5) < 0.012 && v > 0.12) value = glm::dvec4(96, 84, 52, 255);
    for (const Leaf& one : leaves) {
      const glm::dvec2 from = at - one.root;
      const double along = glm::dot(from, one.along) / one.length;
      const double across = (from.x * -one.along.y + from.y * one.along.x) / one.length;
      if (along < 0 || along > 1) continue;
      const double half_width = 0.30 * 4 * along * (1 - along) * (1 - 0.35 * along);
      if (std::abs(across) > half_width) continue;
      const double vein = std::abs(across) < 0.012 ? 1.25 : 1.0;
      const double branch = along * 9 + std::abs(across) * 6;
      const double ribs = branch - std::floor(branch) < 0.14 ? 1.1 : 1.0;
      value = glm::dvec4(leaf * one.tint * vein * ribs * (0.85 + 0.3 * along), 255);
    }
    return value;
  });
}

}  // namespace subpixel::capture
