// Numbers per pixel shown as colours.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

enum class ColourMap { magma, viridis };

using Rgb = std::array<float, 3>;  // display values

// `t` in 0..1 (clamped; NaN as 0). Luminance rises with t over the whole range.
Rgb colour_at(ColourMap map, float t);

// {magma: ["#rrggbb", ...], viridis: [...]}: evenly spaced points of each map, between which colour_at() interpolates.
nlohmann::json palettes_json();

// One channel of values as display colours, 0 to `maximum` over the whole of `map`. Throws InputError for other
// channels and for a `maximum` that is not above 0, as colour_counts() does.
Image colour_values(const Image& values, double maximum, ColourMap map);

// Counts, width x height of them, in viridis with one colour for each of 0 to `maximum`, whose colour stands for what
// is above too.
Image colour_counts(std::uint32_t width, std::uint32_t height, const std::vector<std::uint32_t>& counts,
                    std::uint32_t maximum);

// The error map of `metrics.hpp` in magma, 0 to 0.25: above that, a difference is plain without a map.
inline constexpr double error_map_maximum = 0.25;
Image colour_error(const Image& error);

}  // namespace subpixel::replay
