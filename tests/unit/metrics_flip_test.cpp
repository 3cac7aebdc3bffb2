#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "replay/measure/flip.hpp"
#include "tests/unit/flip_oracle.hpp"

namespace subpixel::replay {
namespace {

// Smooth colour with an edge, a line and some noise: every part of the metric has something to see.
Image scene(std::uint32_t width, std::uint32_t height, float shift, unsigned seed, float noise) {
  Image image(width, height, 3);
  std::mt19937 random(seed);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      float* pixel = &image.pixels[image.offset(x, y)];
      const float u = static_cast<float>(x) / static_cast<float>(width);
      const float v = static_cast<float>(y) / static_cast<float>(height);
      const bool right = u + 0.3F * v > 0.55F + shift;
      const bool line = std::abs(u - v - shift) < 0.02F;
      pixel[0] = line ? 1.0F : (right ? 0.2F + 0.5F * v : 0.8F * u);
      pixel[1] = line ? 0.1F : (right ? 0.7F * u : 0.3F);
      pixel[2] = line ? 0.1F : 0.5F + 0.5F * std::sin(6 * v + 3 * shift);
      for (int c = 0; c < 3; ++c) {
        const float wobble = noise * (static_cast<float>(random() % 1000) / 1000 - 0.5F);
        pixel[c] = std::clamp(pixel[c] + wobble, 0.0F, 1.0F);
      }
    }
  }
  return image;
}

Image constant(float r, float g, float b) {
  Image image(24, 20, 3);
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
    image.pixels[i] = r;
    image.pixels[i + 1] = g;
    image.pixels[i + 2] = b;
  }
  return image;
}

void expect_agreement(const Image& reference, const Image& test, double ppd) {
  FlipOptions options;
  options.pixels_per_degree = ppd;
  const FlipResult result = flip(reference, test, options);
  const oracle::Plane expected = oracle::flip(reference, test, ppd);
  double worst = 0;
  double sum = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    worst = std::max(worst, std::abs(expected[i] - result.map.pixels[i]));
    sum += expected[i];
  }
  EXPECT_LT(worst, 2e-5);
  EXPECT_NEAR(result.mean, sum / static_cast<double>(expected.size()), 2e-6);
}

TEST(Flip, AgreesWithThePapersEquationsInDoubles) {
  expect_agreement(scene(61, 47, 0, 1, 0), scene(61, 47, 0.05F, 2, 0), FlipOptions{}.pixels_per_degree);
  expect_agreement(scene(50, 33, 0, 3, 0.4F), scene(50, 33, 0, 4, 0.4F), FlipOptions{}.pixels_per_degree);
  expect_agreement(scene(37, 29, 0, 5, 1), scene(37, 29, 0.1F, 6, 1), 30);
  expect_agreement(scene(40, 90, 0, 7, 0.2F), scene(40, 90, 0.02F, 8, 0.1F), 120);
}

TEST(Flip, DefaultViewingConditionsAreThePapers) {
  EXPECT_NEAR(FlipOptions{}.pixels_per_degree, 67.0206, 1e-4);
}

TEST(Flip, EqualImagesDoNotDiffer) {
  const Image image = scene(64, 64, 0, 1, 0.5F);
  const FlipResult result = flip(image, image);
  EXPECT_EQ(result.mean, 0);
  EXPECT_EQ(result.maximum, 0);
  EXPECT_EQ(result.p99, 0);
  EXPECT_EQ(result.weighted_median, 0);
}

// Of constant images the filters leave nothing but the colour term. Green against blue is the largest difference there
// is, 1 by definition. Black against white: HyAB 100, 100^0.7 = 25.1189; the largest difference is
// (L* 87.735 - 32.297 and the Hunt-adjusted a*, b* distance, 308.11 in all)^0.7 = 41.27.
TEST(Flip, ConstantImagesByHand) {
  EXPECT_NEAR(flip(constant(0, 1, 0), constant(0, 0, 1)).mean, 1, 1e-6);
  const oracle::Triple green = oracle::hunt_lab({0, 1, 0});
  const oracle::Triple blue = oracle::hunt_lab({0, 0, 1});
  EXPECT_NEAR(green[0], 87.735, 0.01);
  EXPECT_NEAR(blue[0], 32.297, 0.01);
  const double largest = std::pow(oracle::hyab(green, blue), 0.7);
  const double knee = 0.4 * largest;
  const double expected = 0.95 + (std::pow(100.0, 0.7) - knee) / (largest - knee) * 0.05;
  EXPECT_NEAR(flip(constant(0, 0, 0), constant(1, 1, 1)).mean, expected, 1e-6);
  EXPECT_NEAR(expected, 0.967, 0.001);
}

TEST(Flip, IsSymmetric) {
  const Image a = scene(70, 50, 0, 1, 0.3F);
  const Image b = scene(70, 50, 0.04F, 2, 0.3F);
  EXPECT_EQ(flip(a, b).map.pixels, flip(b, a).map.pixels);
}

TEST(Flip, EveryNumberOfThreadsGivesTheSameBits) {
  const Image a = scene(65, 300, 0, 1, 0.3F);
  const Image b = scene(65, 300, 0.04F, 2, 0.3F);
  const FlipResult one = flip(a, b, {.threads = 1});
  for (const unsigned threads : {2U, 3U, 4U}) {
    const FlipResult many = flip(a, b, {.threads = threads});
    EXPECT_EQ(one.map.pixels, many.map.pixels);
    EXPECT_EQ(one.mean, many.mean);
  }
}

TEST(Flip, GreyAndFourChannelImagesReadAsColour) {
  Image grey(30, 20, 1);
  Image colour(30, 20, 3);
  Image with_alpha(30, 20, 4);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
    const float value = static_cast<float>(random() % 256) / 255;
    grey.pixels[i] = value;
    for (int c = 0; c < 3; ++c) colour.pixels[i * 3 + c] = with_alpha.pixels[i * 4 + c] = value;
    with_alpha.pixels[i * 4 + 3] = value;
  }
  const Image black(30, 20, 1);
  const Image black_colour(30, 20, 3);
  EXPECT_EQ(flip(grey, black).mean, flip(colour, black_colour).mean);
  EXPECT_EQ(flip(with_alpha, black_colour).mean, flip(colour, black_colour).mean);
}

TEST(Flip, SmallestImagesAndStrangeValuesStayInRange) {
  for (const std::uint32_t width : {1U, 2U, 5U}) {
    Image a(width, 1, 3);
    Image b(width, 1, 3, Encoding::display, 1);
    a.pixels[0] = std::numeric_limits<float>::quiet_NaN();
    b.pixels[1] = std::numeric_limits<float>::infinity();
    a.pixels[2] = -5;
    const FlipResult result = flip(a, b);
    EXPECT_GT(result.mean, 0.9);
    EXPECT_LE(result.maximum, 1);
  }
}

TEST(Flip, WhatIsNotFiniteIsNeverEqual) {
  const Image black(40, 30, 3);
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
    Image strange = black;
    strange.pixels[strange.offset(7, 5) + 1] = value;
    for (const FlipResult& result : {flip(strange, black), flip(black, strange), flip(strange, strange)}) {
      EXPECT_EQ(result.map.pixels[result.map.offset(7, 5)], 1);
      EXPECT_EQ(result.maximum, 1);
      EXPECT_GE(result.mean, 1.0 / (40 * 30));
    }
  }
}

TEST(Flip, RefusesOtherSizesAndImpossibleViewing) {
  EXPECT_THROW(flip(Image(4, 4, 3), Image(4, 5, 3)), InputError);
  EXPECT_THROW(flip(Image(4, 4, 3), Image(4, 4, 3), {.pixels_per_degree = 0}), InputError);
  EXPECT_THROW(flip(Image(4, 4, 3), Image(4, 4, 3), {.pixels_per_degree = std::nan("")}), InputError);
}

TEST(Flip, AFullFrameTakesLessThanASecond) {
  const Image a = scene(1280, 720, 0, 1, 0.3F);
  const Image b = scene(1280, 720, 0.01F, 2, 0.3F);
  const auto start = std::chrono::steady_clock::now();
  const FlipResult result = flip(a, b);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  RecordProperty("milliseconds", std::to_string(elapsed.count() * 1000));
  EXPECT_GT(result.p99, result.mean);
  EXPECT_GE(result.weighted_third_quartile, result.weighted_median);
  EXPECT_GE(result.weighted_median, result.weighted_first_quartile);
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(elapsed.count(), 1.0);  // 0.05 s on two idle cores
#endif
}

}  // namespace
}  // namespace subpixel::replay
