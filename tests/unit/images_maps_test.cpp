#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "replay/measure/maps.hpp"

namespace subpixel::replay {
namespace {

double luminance(const Rgb& colour) {
  return 0.2126 * srgb_decode(colour[0]) + 0.7152 * srgb_decode(colour[1]) + 0.0722 * srgb_decode(colour[2]);
}

TEST(ColourMaps, LuminanceRisesAllTheWay) {
  for (const ColourMap map : {ColourMap::magma, ColourMap::viridis}) {
    double before = -1;
    for (int i = 0; i <= 1000; ++i) {
      const double now = luminance(colour_at(map, static_cast<float>(i) / 1000));
      EXPECT_GT(now, before) << i;
      before = now;
    }
  }
}

// Values of the published maps between the control points, at 8 of 255 and 128 of 255.
TEST(ColourMaps, StayCloseToThePublishedOnes) {
  const auto expect_near = [](ColourMap map, int index, const Rgb& published) {
    const Rgb colour = colour_at(map, static_cast<float>(index) / 255);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(colour[c], published[c], 0.012) << index << " channel " << c;
  };
  expect_near(ColourMap::magma, 8, {0.013708F, 0.011771F, 0.068667F});
  expect_near(ColourMap::magma, 128, {0.716387F, 0.214982F, 0.475290F});
  expect_near(ColourMap::viridis, 8, {0.277018F, 0.050344F, 0.375715F});
  expect_near(ColourMap::viridis, 128, {0.127568F, 0.566949F, 0.550556F});
}

TEST(ColourMaps, ValuesOutsideShowTheEnds) {
  for (const ColourMap map : {ColourMap::magma, ColourMap::viridis}) {
    EXPECT_EQ(colour_at(map, -1), colour_at(map, 0));
    EXPECT_EQ(colour_at(map, 7), colour_at(map, 1));
    EXPECT_EQ(colour_at(map, std::numeric_limits<float>::quiet_NaN()), colour_at(map, 0));
  }
}

Rgb pixel_of(const Image& image, std::size_t pixel) {
  return {image.pixels[pixel * 3], image.pixels[pixel * 3 + 1], image.pixels[pixel * 3 + 2]};
}

TEST(ColourMaps, ValuesSpreadOverTheMaximum) {
  Image values(3, 1, 1);
  values.pixels = {0, 0.125F, 3};
  const Image coloured = colour_error(values);
  ASSERT_EQ(coloured.channels, 3U);
  EXPECT_EQ(pixel_of(coloured, 0), colour_at(ColourMap::magma, 0));
  EXPECT_EQ(pixel_of(coloured, 2), colour_at(ColourMap::magma, 1));
  EXPECT_NEAR(pixel_of(coloured, 1)[0], colour_at(ColourMap::magma, 0.5F)[0], 0.005);
}

TEST(ColourMaps, EveryCountHasItsColour) {
  const Image coloured = colour_counts(2, 2, {0, 1, 8, 99}, 8);
  EXPECT_EQ(pixel_of(coloured, 0), colour_at(ColourMap::viridis, 0));
  EXPECT_EQ(pixel_of(coloured, 1), colour_at(ColourMap::viridis, 1.0F / 8));
  EXPECT_EQ(pixel_of(coloured, 2), colour_at(ColourMap::viridis, 1));
  EXPECT_EQ(pixel_of(coloured, 3), pixel_of(coloured, 2));
}

TEST(ColourMaps, PalettesAreTheirEvenlySpacedPoints) {
  const nlohmann::json palettes = palettes_json();
  for (const auto& [name, map] : {std::pair{"magma", ColourMap::magma}, std::pair{"viridis", ColourMap::viridis}}) {
    const nlohmann::json& points = palettes.at(name);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Rgb colour = colour_at(map, static_cast<float>(i) / static_cast<float>(points.size() - 1));
      const auto packed = static_cast<std::uint32_t>(std::stoul(points[i].get<std::string>().substr(1), nullptr, 16));
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(colour[c] * 255, packed >> (16 - 8 * c) & 255, 1e-3) << name << i;
    }
  }
  EXPECT_EQ(palettes.at("magma").front(), "#000004");
}

TEST(ColourMaps, MistakesAreRefused) {
  EXPECT_THROW(colour_counts(2, 2, {0, 1}, 8), InputError);
  EXPECT_THROW(colour_counts(1, 1, {0}, 0), InputError);
  EXPECT_THROW(colour_values(Image(1, 1, 3), 1, ColourMap::magma), InputError);
  EXPECT_THROW(colour_values(Image(1, 1, 1), 0, ColourMap::magma), InputError);
}

}  // namespace
}  // namespace subpixel::replay
