#include "replay/measure/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "base/error.hpp"
#include "replay/measure/percentiles.hpp"

namespace subpixel::replay {
namespace {

Image noise(std::uint32_t width, std::uint32_t height, std::uint32_t channels, unsigned seed) {
  Image image(width, height, channels);
  std::mt19937 random(seed);
  for (float& value : image.pixels) value = static_cast<float>(random() % 256) / 255;
  return image;
}

TEST(Metrics, MseOfFourHandComputedPixels) {
  Image a(2, 2, 1);
  Image b(2, 2, 1);
  b.pixels = {0.5F, 0, 0.25F, 1};
  EXPECT_DOUBLE_EQ(mse(a, b), (0.25 + 0.0625 + 1) / 4);
  EXPECT_DOUBLE_EQ(psnr_db(0.01), 20);
  EXPECT_TRUE(std::isinf(psnr_db(mse(a, a))));
}

TEST(Metrics, MseIgnoresTheFourthChannel) {
  Image a(3, 1, 4);
  Image b(3, 1, 3);
  for (std::uint32_t x = 0; x < 3; ++x) a.pixels[a.offset(x, 0) + 3] = 1;
  b.pixels[b.offset(1, 0) + 2] = 0.5F;
  EXPECT_DOUBLE_EQ(mse(a, b), 0.25 / 9);
}

TEST(Metrics, AreSymmetricWhereTheyShouldBe) {
  const Image a = noise(40, 30, 3, 1);
  const Image b = noise(40, 30, 4, 2);
  EXPECT_EQ(mse(a, b), mse(b, a));
  EXPECT_EQ(ssim(a, b), ssim(b, a));
  EXPECT_EQ(error_map(a, b).pixels, error_map(b, a).pixels);
}

TEST(Metrics, RelativeMseFollowsItsDefinition) {
  Image reference(2, 1, 1, Encoding::linear);
  Image test(2, 1, 1, Encoding::linear);
  reference.pixels = {10, 0};
  test.pixels = {11, 0.1F};
  EXPECT_NEAR(hdr_relative_mse(reference, test), (1 / 100.01 + 0.01 / 0.01) / 2, 1e-7);
}

TEST(Metrics, SsimOfConstantsIsItsLuminanceTerm) {
  const Image a(20, 16, 3, Encoding::display, 0.25F);
  const Image b(20, 16, 3, Encoding::display, 0.75F);
  EXPECT_NEAR(ssim(a, b), (2 * 0.25 * 0.75 + 1e-4) / (0.0625 + 0.5625 + 1e-4), 1e-9);
  EXPECT_DOUBLE_EQ(ssim(a, a), 1);
  EXPECT_TRUE(std::isnan(ssim(Image(10, 30, 3), Image(10, 30, 3))));
}

// One window, so the sums can be taken over it directly.
TEST(Metrics, SsimOfOneWindowEqualsTheDirectSums) {
  const Image a = noise(11, 11, 1, 3);
  const Image b = noise(11, 11, 1, 4);
  double total = 0;
  for (int y = -5; y <= 5; ++y) {
    for (int x = -5; x <= 5; ++x) total += std::exp(-(x * x + y * y) / 4.5);
  }
  double ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
  for (int turn = 0; turn < 2; ++turn) {
    for (int y = 0; y < 11; ++y) {
      for (int x = 0; x < 11; ++x) {
        const double weight = std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / 4.5) / total;
        const double pa = a.pixels[y * 11 + x];
        const double pb = b.pixels[y * 11 + x];
        if (turn == 0) {
          ma += weight * pa;
          mb += weight * pb;
        } else {
          va += weight * (pa - ma) * (pa - ma);
          vb += weight * (pb - mb) * (pb - mb);
          cov += weight * (pa - ma) * (pb - mb);
        }
      }
    }
  }
  const double expected = (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
  EXPECT_NEAR(ssim(a, b), expected, 1e-12);
}

TEST(Metrics, FlickerSeesOnlyChangesTheReferenceDoesNotHave) {
  const Image r0 = noise(16, 9, 3, 5);
  Image r1 = r0;
  for (float& value : r1.pixels) value *= 0.5F;
  EXPECT_EQ(flicker(r0, r1, r0, r1), 0);
  // A constant error over both frames doesn't flicker; one that appears in one pixel's channel does.
  Image t0 = r0;
  Image t1 = r1;
  for (std::size_t i = 0; i < t0.pixels.size(); ++i) {
    t0.pixels[i] += 0.25F;
    t1.pixels[i] += 0.25F;
  }
  EXPECT_NEAR(flicker(r0, r1, t0, t1), 0, 1e-7);
  t1.pixels[7] += 0.5F;
  EXPECT_NEAR(flicker(r0, r1, t0, t1), 0.5 / (16 * 9 * 3), 1e-7);
}

TEST(Metrics, ErrorMapIsTheLargestChannelDifference) {
  Image a(2, 1, 3);
  Image b(2, 1, 3);
  b.pixels = {0.1F, 0.3F, 0.2F, 0, 0, 0.5F};
  const Image map = error_map(a, b);
  EXPECT_EQ(map.channels, 1U);
  EXPECT_FLOAT_EQ(map.pixels[0], 0.3F);
  EXPECT_FLOAT_EQ(map.pixels[1], 0.5F);
}

TEST(Metrics, InvalidPixelsAreCounted) {
  Image image(4, 1, 3);
  image.pixels[1] = std::numeric_limits<float>::quiet_NaN();
  image.pixels[2] = -1;
  image.pixels[5] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(invalid_pixels(image), 2U);
}

TEST(Metrics, WhatIsNotFiniteIsTheLargestDifference) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const Image black(20, 20, 3);
  for (const float value : {nan, infinite, -infinite}) {
    Image linear(20, 20, 3, Encoding::linear);
    linear.pixels[linear.offset(9, 9) + 2] = value;
    const Image shown = to_display(linear);
    for (const auto& [a, b] : {std::pair{&shown, &black}, {&black, &shown}, {&shown, &shown}}) {
      EXPECT_DOUBLE_EQ(mse(*a, *b), 1.0 / 400) << "a pixel is as a whole";
      EXPECT_LT(ssim(*a, *b), -0.9) << "every window holds it";
      EXPECT_EQ(error_map(*a, *b).pixels[9 * 20 + 9], 1);
      EXPECT_DOUBLE_EQ(flicker(*a, *a, *b, *b), 2.0 / 400);
    }
    const Image dark(20, 20, 3, Encoding::linear);
    EXPECT_DOUBLE_EQ(hdr_relative_mse(dark, linear), relative_error_limit / 1200);
    EXPECT_DOUBLE_EQ(hdr_relative_mse(linear, linear), relative_error_limit / 1200);
    EXPECT_TRUE(std::isfinite(hdr_relative_mse(linear, dark)));
    EXPECT_EQ(not_finite_pixels(linear), 1U);
  }
}

TEST(Metrics, MarkedPixelsAreThoseOfTheLinearImage) {
  Image linear(3, 1, 3, Encoding::linear, 0.5F);
  linear.pixels[4] = std::numeric_limits<float>::infinity();
  Image display(3, 1, 3, Encoding::display, 0.25F);
  mark_not_finite(linear, display);
  EXPECT_EQ(not_finite_pixels(display), 1U);
  EXPECT_TRUE(std::isnan(display.pixels[3]) && std::isnan(display.pixels[4]) && std::isnan(display.pixels[5]));
  EXPECT_EQ(display.pixels[2], 0.25F);
}

TEST(Metrics, ShapesThatDifferAreRefusedByName) {
  try {
    mse(Image(4, 3, 3), Image(4, 2, 1));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "images: cannot compare 4x3 with 3 channels to 4x2 with 1 channel: size");
  }
}

TEST(Percentiles, AgreeWithASortedCopy) {
  std::mt19937 random(6);
  std::vector<float> values;
  values.reserve(10007);
  for (int i = 0; i < 10007; ++i) values.push_back(std::pow(static_cast<float>(random() % 100000) / 100000, 4.0F));
  values[3] = 0;
  std::vector<float> sorted = values;
  std::ranges::sort(sorted);
  double sum = 0;
  for (const float value : sorted) sum += value;
  const Percentiles percentiles(values);
  EXPECT_NEAR(percentiles.mean(), sum / 10007, 1e-12);
  EXPECT_EQ(percentiles.maximum(), sorted.back());
  EXPECT_EQ(percentiles.minimum(), sorted.front());
  for (const double share : {0.001, 0.25, 0.5, 0.99, 1.0}) {
    EXPECT_EQ(percentiles.at(share), sorted[static_cast<std::size_t>(std::ceil(share * 10007)) - 1]) << share;
    double running = 0;
    std::size_t at = 0;
    while (running < share * sum * (1 - 1e-12)) running += sorted[at++];
    EXPECT_EQ(percentiles.weighted_at(share), sorted[at - 1]) << share;
  }
}

TEST(Median, IsTheMiddleOneOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({9, 1, 4}), 4);
  EXPECT_EQ(median({8, 1, 3, 2}), 2.5);
  EXPECT_EQ(median({5, 5, 1, 5}), 5);
}

TEST(Percentiles, OfEqualValuesAreThatValue) {
  const std::vector<float> zeros(100, 0.0F);
  EXPECT_EQ(Percentiles(zeros).at(0.99), 0);
  EXPECT_EQ(Percentiles(zeros).weighted_at(0.5), 0);
  const std::vector<float> ones(100, 1.0F);
  EXPECT_EQ(Percentiles(ones).weighted_at(0.75), 1);
}

TEST(Metrics, GroupsOfPixelsTakeAsLongAsTheirBusiest) {
  // 10x5: a group of 8x4, one of 2x4 beside it, one of 8x1 and one of 2x1 below.
  std::vector<std::uint32_t> counts(50, 1);
  counts[0] = 3;
  counts[1] = 2;
  counts[9] = 4;
  counts[49] = 5;
  EXPECT_EQ(group_executions(counts, 10, 5), 3u * 32 + 4u * 8 + 1u * 8 + 5u * 2);
  EXPECT_EQ(group_executions(std::vector<std::uint32_t>(32, 0), 8, 4), 0u);
}

}  // namespace
}  // namespace subpixel::replay
