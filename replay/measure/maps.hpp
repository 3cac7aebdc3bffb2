// Numbers per pixel shown as colours, with the legend that says what the colours mean.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

enum class ColourMap { magma, viridis };

using Rgb = std::array<float, 3>;  // display values

// `t` in 0..1 (clamped; NaN as 0). Luminance rises with t over the whole range.
Rgb colour_at(ColourMap map, float t);

struct LegendEntry {
  double value = 0;
  Rgb colour{};
};

// discrete: an entry is one value's colour, the last one stands for itself and above. Otherwise entries are evenly
// spaced points of a continuous scale whose last colour also shows what is above.
struct Legend {
  std::string title, unit;
  ColourMap map = ColourMap::magma;
  bool discrete = false;
  double maximum = 0;
  std::vector<LegendEntry> entries;
};

// {title, unit, map: "magma"|"viridis", discrete, maximum, entries: [{value, colour: "#rrggbb"}]}
nlohmann::json to_json(const Legend& legend);

struct ColouredMap {
  Image image;  // three channels, display
  Legend legend;
};

// One channel of values, 0 to `maximum` over the whole of `map`. `maximum` is above 0.
ColouredMap colour_values(const Image& values, double maximum, ColourMap map, std::string_view title,
                          std::string_view unit);

// Counts, width x height of them, in viridis with one colour for each of 0 to `maximum`.
ColouredMap colour_counts(std::uint32_t width, std::uint32_t height, const std::vector<std::uint32_t>& counts,
                          std::uint32_t maximum, std::string_view title, std::string_view unit);

// The error map of `metrics.hpp` in magma, 0 to 0.25: above that, a difference is plain without a map.
inline constexpr double error_map_maximum = 0.25;
ColouredMap colour_error(const Image& error);

}  // namespace subpixel::replay
