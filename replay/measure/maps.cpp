#include "replay/measure/maps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

constexpr std::size_t point_count = 18;
using ControlPoints = std::array<std::uint32_t, point_count>;

// Eighteen evenly spaced colours, 0xrrggbb, of the maps by Smith and van der Walt (matplotlib, CC0); between them the
// colour is interpolated, which stays within 0.01 of theirs.
constexpr ControlPoints magma_points = {0x000004, 0x090720, 0x1a1042, 0x311165, 0x4a1079, 0x621980,
                                        0x792282, 0x912b81, 0xaa337d, 0xc23b75, 0xd9466b, 0xec5860,
                                        0xf7725c, 0xfc8e64, 0xfeaa74, 0xfec68a, 0xfde2a3, 0xfcfdbf};
constexpr ControlPoints viridis_points = {0x440154, 0x481769, 0x472a7a, 0x433d84, 0x3d4e8a, 0x355e8d,
                                          0x2e6d8e, 0x297b8e, 0x23898e, 0x1f978b, 0x21a585, 0x2eb37c,
                                          0x46c06f, 0x65cb5e, 0x89d548, 0xb0dd2f, 0xd8e219, 0xfde725};

Rgb unpack(std::uint32_t colour) {
  return {static_cast<float>(colour >> 16 & 255) / 255, static_cast<float>(colour >> 8 & 255) / 255,
          static_cast<float>(colour & 255) / 255};
}

void put(Image& image, std::size_t pixel, const Rgb& colour) {
  std::copy(colour.begin(), colour.end(), image.pixels.begin() + static_cast<std::ptrdiff_t>(pixel * 3));
}

// A texture of the map, so that a pixel costs one look-up.
std::vector<Rgb> colour_table(ColourMap map) {
  std::vector<Rgb> table;
  table.reserve(1024);
  for (int i = 0; i < 1024; ++i) table.push_back(colour_at(map, static_cast<float>(i) / 1023));
  return table;
}

}  // namespace

Rgb colour_at(ColourMap map, float t) {
  const ControlPoints& points = map == ColourMap::magma ? magma_points : viridis_points;
  const float at = (t > 0 ? std::min(t, 1.0F) : 0.0F) * static_cast<float>(point_count - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), point_count - 2);
  const float share = at - static_cast<float>(below);
  const Rgb low = unpack(points[below]);
  const Rgb high = unpack(points[below + 1]);
  Rgb colour{};
  for (std::size_t c = 0; c < colour.size(); ++c) colour[c] = low[c] + share * (high[c] - low[c]);
  return colour;
}

nlohmann::json palettes_json() {
  const auto colours = [](const ControlPoints& points) {
    nlohmann::json list = nlohmann::json::array();
    for (const std::uint32_t point : points) list.push_back(fmt::format("#{:06x}", point));
    return list;
  };
  return {{"magma", colours(magma_points)}, {"viridis", colours(viridis_points)}};
}

Image colour_values(const Image& values, double maximum, ColourMap map) {
  if (values.channels != 1 || !(maximum > 0)) throw InputError("map", "needs one channel and a maximum above 0", "map");
  Image coloured(values.width, values.height, 3);
  const std::vector<Rgb> table = colour_table(map);
  const auto scale = static_cast<float>(1 / maximum);
  const auto last = static_cast<float>(table.size()) - 0.5F;
  for (std::size_t i = 0; i < values.pixels.size(); ++i) {
    const float t = values.pixels[i] * scale;
    const float inside = t > 0 ? std::min(t, 1.0F) : 0.0F;
    put(coloured, i, table[static_cast<std::size_t>(inside * last)]);
  }
  return coloured;
}

Image colour_counts(std::uint32_t width, std::uint32_t height, const std::vector<std::uint32_t>& counts,
                    std::uint32_t maximum) {
  if (counts.size() != std::size_t{width} * height || maximum == 0) {
    throw InputError("map", "needs a count for each pixel and a maximum above 0", "map");
  }
  Image coloured(width, height, 3);
  std::vector<Rgb> table;
  for (std::uint32_t value = 0; value <= maximum; ++value) {
    table.push_back(colour_at(ColourMap::viridis, static_cast<float>(value) / static_cast<float>(maximum)));
  }
  for (std::size_t i = 0; i < counts.size(); ++i) put(coloured, i, table[std::min(counts[i], maximum)]);
  return coloured;
}

Image colour_error(const Image& error) {
  return colour_values(error, error_map_maximum, ColourMap::magma);
}

}  // namespace subpixel::replay
