#include "replay/measure/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

ImageFile file_of(Image image, const std::string& name = "a") {
  ImageFile file;
  file.path = name;
  file.window = {0, 0, image.width, image.height};
  file.image = std::move(image);
  return file;
}

Comparison compare(const Image& a, const Image& b) {
  return compare_images(file_of(a), file_of(b), {});
}

TEST(Comparison, EqualImagesDifferInNothing) {
  const Image image(16, 12, 3, Encoding::linear, 0.5F);
  const Comparison found = compare(image, image);
  EXPECT_EQ(found.differing_pixels, 0U);
  EXPECT_EQ(found.largest_difference, 0);
  EXPECT_EQ(found.mse, 0);
  EXPECT_EQ(found.hdr_relative_mse, 0);
  EXPECT_FALSE(found.alpha_mse);
}

// Whatever the metrics of display values see, a difference of the values is told.
TEST(Comparison, TellsOfDifferencesThatDisplayValuesHide) {
  Image black(16, 12, 3, Encoding::linear), negative = black;
  negative.pixels[negative.offset(5, 7) + 1] = -2;
  const Comparison below = compare(black, negative);
  EXPECT_EQ(below.mse, 0);
  EXPECT_EQ(below.differing_pixels, 1U);
  EXPECT_EQ(below.largest_difference, 2);
  EXPECT_EQ(below.largest_at, (std::array<std::uint32_t, 2>{5, 7}));
  EXPECT_EQ(below.clamped_pixels, (std::array<std::uint64_t, 2>{0, 1}));
  EXPECT_GT(below.hdr_relative_mse, 0);
  const Comparison above = compare(Image(16, 12, 3, Encoding::linear, 10), Image(16, 12, 3, Encoding::linear, 1000));
  EXPECT_EQ(above.mse, 0);
  EXPECT_EQ(above.largest_difference, 990);
  EXPECT_GT(above.hdr_flip->error.mean, 0.01);
}

TEST(Comparison, NotFiniteIsCountedAndDiffersFromItself) {
  Image strange(16, 12, 3, Encoding::linear, 0.5F);
  strange.pixels[0] = std::numeric_limits<float>::quiet_NaN();
  const Comparison found = compare(strange, strange);
  EXPECT_EQ(found.not_finite_pixels, (std::array<std::uint64_t, 2>{1, 1}));
  EXPECT_EQ(found.differing_pixels, 1U);
  EXPECT_TRUE(std::isinf(found.largest_difference));
  EXPECT_DOUBLE_EQ(found.mse, 1.0 / (16 * 12));
  EXPECT_EQ(found.flip.maximum, 1);
  EXPECT_EQ(found.hdr_flip->error.maximum, 1);
  // Against a display image the marks stay.
  EXPECT_EQ(compare(strange, Image(16, 12, 3)).differing_pixels, 16U * 12);
}

TEST(Comparison, AlphaIsComparedAndIsOneWhereThereIsNone) {
  Image opaque(16, 12, 4, Encoding::display, 1), half = opaque;
  for (std::size_t i = 0; i < 48; ++i) half.pixels[4 * i + 3] = 0.5F;
  EXPECT_EQ(compare(Image(16, 12, 3, Encoding::display, 1), opaque).alpha_mse, 0);
  for (const Comparison& found : {compare(Image(16, 12, 3, Encoding::display, 1), half), compare(half, opaque)}) {
    EXPECT_EQ(found.differing_pixels, 0U);
    EXPECT_EQ(found.alpha_differing_pixels, 48U);
    EXPECT_DOUBLE_EQ(found.alpha_mse.value(), 0.25 * 48 / (16 * 12));
  }
  half.pixels[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_DOUBLE_EQ(compare(half, half).alpha_mse.value(), 1.0 / (16 * 12));
}

TEST(Comparison, GreyIsThreeEqualChannels) {
  EXPECT_EQ(compare(Image(16, 12, 1, Encoding::display, 0.3F), Image(16, 12, 3, Encoding::display, 0.3F)).mse, 0);
  EXPECT_GT(compare(Image(16, 12, 1, Encoding::display, 0.3F), Image(16, 12, 3, Encoding::display, 0.4F)).mse, 0);
}

TEST(Comparison, OtherWindowsAreRefusedByBothNames) {
  const auto refusal = [](const ImageFile& a, const ImageFile& b) {
    try {
      compare_images(a, b, {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  ImageFile a = file_of(Image(4, 3, 3), "a.png"), b = file_of(Image(4, 2, 1), "b.png");
  EXPECT_EQ(refusal(a, b), "images: cannot compare 4x3 to 4x2: a.png and b.png");
  b = file_of(Image(4, 3, 3), "b.png");
  b.window.x = -1;
  EXPECT_EQ(refusal(a, b), "images: cannot compare 4x3 at 0,0 to 4x3 at -1,0: a.png and b.png");
}

}  // namespace
}  // namespace subpixel::replay
