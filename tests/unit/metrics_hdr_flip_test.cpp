#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "replay/measure/flip.hpp"
#include "tests/unit/flip_oracle.hpp"

namespace subpixel::replay {
namespace {

Image constant(float value, std::uint32_t width = 24, std::uint32_t height = 20) {
  return {width, height, 3, Encoding::linear, value};
}

// The tone curve, from its published form a(x) with x scaled by 0.6.
double curve(double x) {
  const double y = 0.6 * x;
  return std::clamp(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0.0, 1.0);
}

// Where the curve is 0.85: 0.160020 x^2 - 0.282900 x - 0.119 = 0, x = (0.2829 + sqrt(0.156202)) / 0.32004 = 2.118873.
constexpr double kShoulder = 2.118873;

// FLIP of two constant greys, linear: the filters change nothing, so the colour term alone.
double grey_error(double a, double b) {
  const double largest = std::pow(oracle::hyab(oracle::hunt_lab({0, 1, 0}), oracle::hunt_lab({0, 0, 1})), 0.7);
  const double difference = std::pow(oracle::hyab(oracle::hunt_lab({a, a, a}), oracle::hunt_lab({b, b, b})), 0.7);
  const double knee = 0.4 * largest;
  return difference < knee ? 0.95 / knee * difference : 0.95 + (difference - knee) / (largest - knee) * 0.05;
}

Image noise(std::uint32_t width, std::uint32_t height, unsigned seed, double stops) {
  Image image(width, height, 3, Encoding::linear);
  std::mt19937 random(seed);
  for (float& value : image.pixels)
    value = static_cast<float>(std::exp2(stops * (static_cast<double>(random() % 1000) / 1000 - 0.5)));
  return image;
}

TEST(HdrFlip, ExposureRangeByHand) {
  EXPECT_NEAR(curve(kShoulder), 0.85, 1e-5);
  // Three pixels in four are 1/16 and one is 1: median and largest luminance lie four stops apart.
  Image reference = constant(1.0F / 16);
  for (std::uint32_t y = 0; y < 20; ++y)
    for (std::uint32_t x = 0; x < 6; ++x)
      for (int c = 0; c < 3; ++c) reference.pixels[reference.offset(x, y) + c] = 1;
  const HdrFlipResult result = hdr_flip(reference, reference);
  EXPECT_NEAR(result.start, 1.08330, 1e-4);
  EXPECT_NEAR(result.stop, 5.08330, 1e-4);
  EXPECT_EQ(result.exposures, 4u);
  EXPECT_EQ(result.error.maximum, 0);
  // Luminance is 0.2126, 0.7152 and 0.0722 of the primaries.
  Image green = constant(0);
  for (std::size_t i = 1; i < green.pixels.size(); i += 3) green.pixels[i] = 8;
  EXPECT_NEAR(hdr_flip(green, green).start, 1.08330 - std::log2(8 * 0.7152), 1e-4);
  EXPECT_EQ(hdr_flip(green, green).exposures, 2u);
}

TEST(HdrFlip, ConstantImagesByHand) {
  // One luminance: the only exposure brings the reference to 0.85, whatever its value.
  for (const float scale : {1.0F, 1e-3F, 4000.0F}) {
    EXPECT_NEAR(hdr_flip(constant(scale), constant(0)).error.mean, grey_error(0.85, 0), 2e-6);
    EXPECT_NEAR(hdr_flip(constant(scale), constant(0.5F * scale)).error.mean, grey_error(0.85, curve(0.5 * kShoulder)),
                2e-6);
  }
  EXPECT_NEAR(curve(0.5 * kShoulder), 0.690267, 1e-5);
}

// The error is the maximum over exposures, and the map says at which.
TEST(HdrFlip, EachPixelKeepsItsWorstExposure) {
  // Far apart, so that neither half's filters reach the other's middle.
  constexpr std::uint32_t kWidth = 400;
  Image reference = constant(1.0F / 256, kWidth, 3);
  Image test = constant(0, kWidth, 3);
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < kWidth / 4; ++x)
      for (int c = 0; c < 3; ++c) {
        reference.pixels[reference.offset(x, y) + c] = 1;
        test.pixels[test.offset(x, y) + c] = 0.5F;
      }
  const HdrFlipResult result = hdr_flip(reference, test);
  EXPECT_EQ(result.exposures, 8u);
  // The dark part is told from black best when it is brightest, the bright one before the curve's shoulder flattens it.
  const std::size_t bright = kWidth + 20, dark = kWidth + 300;
  EXPECT_EQ(result.at[dark], 7u);
  EXPECT_EQ(result.at[bright], 0u);
  EXPECT_NEAR(result.error.map.pixels[dark], grey_error(0.85, 0), 2e-6);
  EXPECT_NEAR(result.error.map.pixels[bright], grey_error(0.85, curve(0.5 * kShoulder)), 2e-6);
}

TEST(HdrFlip, AgreesWithThePapersEquationsInDoubles) {
  const Image reference = noise(41, 27, 1, 9);
  const Image test = noise(41, 27, 2, 9);
  const HdrFlipResult result = hdr_flip(reference, test, {.pixels_per_degree = 30});
  EXPECT_GT(result.exposures, 3u);
  oracle::Plane worst(41 * 27, 0);
  for (std::uint32_t i = 0; i < result.exposures; ++i) {
    const double exposure = result.start + i * (result.stop - result.start) / (result.exposures - 1);
    const auto mapped = [&](Image image) {
      for (float& value : image.pixels) value = static_cast<float>(curve(value * std::exp2(exposure)));
      return image;
    };
    const oracle::Plane one = oracle::flip(mapped(reference), mapped(test), 30);
    for (std::size_t p = 0; p < one.size(); ++p) worst[p] = std::max(worst[p], one[p]);
  }
  for (std::size_t p = 0; p < worst.size(); ++p) EXPECT_NEAR(result.error.map.pixels[p], worst[p], 2e-5);
}

TEST(HdrFlip, SymmetricBetweenImagesOfTheSameLuminances) {
  Image a = noise(33, 20, 5, 6), b = a;
  std::reverse(b.pixels.begin(), b.pixels.end());
  for (std::size_t i = 0; i < b.pixels.size(); i += 3) std::swap(b.pixels[i], b.pixels[i + 2]);
  EXPECT_EQ(hdr_flip(a, b).error.map.pixels, hdr_flip(b, a).error.map.pixels);
  // Otherwise the reference decides what a viewer exposes for.
  EXPECT_NE(hdr_flip(constant(1), constant(0.25F)).error.mean, hdr_flip(constant(0.25F), constant(1)).error.mean);
}

TEST(HdrFlip, EveryNumberOfThreadsGivesTheSameBits) {
  const Image a = noise(40, 200, 1, 5), b = noise(40, 200, 2, 5);
  EXPECT_EQ(hdr_flip(a, b, {.threads = 1}).error.map.pixels, hdr_flip(a, b, {.threads = 3}).error.map.pixels);
}

TEST(HdrFlip, BlackAndStrangeValuesStayInRange) {
  EXPECT_EQ(hdr_flip(constant(0), constant(0)).exposures, 1u);
  EXPECT_EQ(hdr_flip(constant(0), constant(0)).error.maximum, 0);
  EXPECT_GT(hdr_flip(constant(0), constant(1)).error.mean, 0.5);
  // More than half the pixels black: the median is that of the others.
  Image lamp = constant(0);
  lamp.pixels[0] = lamp.pixels[1] = lamp.pixels[2] = 1e6F;
  EXPECT_EQ(hdr_flip(lamp, lamp).exposures, 2u);
  Image strange = constant(1);
  strange.pixels[0] = std::numeric_limits<float>::quiet_NaN();
  strange.pixels[4] = std::numeric_limits<float>::infinity();
  strange.pixels[8] = -3;
  for (const HdrFlipResult& result : {hdr_flip(strange, constant(1)), hdr_flip(constant(1), strange)})
    for (const float value : result.error.map.pixels) ASSERT_TRUE(value >= 0 && value <= 1);
  // What is not finite has the largest error, also beside itself, and no say in the exposures.
  const HdrFlipResult same = hdr_flip(strange, strange);
  EXPECT_EQ(same.error.map.pixels[0], 1);
  EXPECT_EQ(same.error.map.pixels[1], 1);
  EXPECT_EQ(same.error.map.pixels[2], 0);
  EXPECT_LE(same.exposures, 2u);
  EXPECT_THROW(hdr_flip(constant(1, 4, 4), constant(1, 5, 4)), InputError);
}

}  // namespace
}  // namespace subpixel::replay
