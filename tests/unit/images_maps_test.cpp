#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

TEST(ColourMaps, ValuesSpreadOverTheMaximum) {
  Image values(3, 1, 1);
  values.pixels = {0, 0.125F, 3};
  const ColouredMap coloured = colour_error(values);
  ASSERT_EQ(coloured.image.channels, 3U);
  const auto pixel = [&](int i) {
    return Rgb{coloured.image.pixels[i * 3], coloured.image.pixels[i * 3 + 1], coloured.image.pixels[i * 3 + 2]};
  };
  EXPECT_EQ(pixel(0), colour_at(ColourMap::magma, 0));
  EXPECT_EQ(pixel(2), colour_at(ColourMap::magma, 1));
  EXPECT_NEAR(pixel(1)[0], colour_at(ColourMap::magma, 0.5F)[0], 0.005);
  const nlohmann::json legend = to_json(coloured.legend);
  EXPECT_EQ(legend.at("map"), "magma");
  EXPECT_EQ(legend.at("maximum"), 0.25);
  EXPECT_EQ(legend.at("entries").size(), 5U);
  EXPECT_EQ(legend.at("entries").at(4).at("value"), 0.25);
  EXPECT_EQ(legend.at("entries").at(0).at("colour"), "#000004");
}

TEST(ColourMaps, EveryCountHasItsColourInTheLegend) {
  const ColouredMap coloured = colour_counts(2, 2, {0, 1, 8, 99}, 8, "Lighting executions", "per pixel");
  ASSERT_EQ(coloured.legend.entries.size(), 9U);
  EXPECT_TRUE(coloured.legend.discrete);
  const auto pixel = [&](int i) {
    return Rgb{coloured.image.pixels[i * 3], coloured.image.pixels[i * 3 + 1], coloured.image.pixels[i * 3 + 2]};
  };
  EXPECT_EQ(pixel(0), coloured.legend.entries[0].colour);
  EXPECT_EQ(pixel(1), coloured.legend.entries[1].colour);
  EXPECT_EQ(pixel(2), coloured.legend.entries[8].colour);
  EXPECT_EQ(pixel(3), pixel(2));
}

TEST(ColourMaps, LongLegendsAreThinnedAndKeepTheirEnd) {
  const ColouredMap coloured = colour_counts(1, 1, {0}, 64, "Lighting executions", "per pixel");
  EXPECT_LE(coloured.legend.entries.size(), 17U);
  EXPECT_EQ(coloured.legend.entries.front().value, 0);
  EXPECT_EQ(coloured.legend.entries.back().value, 64);
}

TEST(ColourMaps, MistakesAreRefused) {
  EXPECT_THROW(colour_counts(2, 2, {0, 1}, 8, "a", ""), InputError);
  EXPECT_THROW(colour_counts(1, 1, {0}, 0, "a", ""), InputError);
  EXPECT_THROW(colour_values(Image(1, 1, 3), 1, ColourMap::magma, "a", ""), InputError);
  EXPECT_THROW(colour_values(Image(1, 1, 1), 0, ColourMap::magma, "a", ""), InputError);
}

}  // namespace
}  // namespace subpixel::replay
