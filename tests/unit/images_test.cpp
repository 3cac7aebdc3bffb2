#include "replay/measure/image_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace subpixel::replay {
namespace {

namespace fs = std::filesystem;

// A folder of its own for each test, gone afterwards.
class ImageFiles : public testing::Test {
 protected:
  ImageFiles() {
    std::string name = (fs::temp_directory_path() / "subpixel_images_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~ImageFiles() override { fs::remove_all(folder_); }
  fs::path folder_;
};

Image gradient(std::uint32_t width, std::uint32_t height, std::uint32_t channels, Encoding encoding) {
  Image image(width, height, channels, encoding);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<float>(i % 256) / 255;
  return image;
}

TEST(Png, ComesBackFromMemory) {
  const Image image = gradient(7, 5, 3, Encoding::display);
  const std::vector<std::uint8_t> bytes = encode_png(image);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(encode_png(decode_png(text)), bytes);
  EXPECT_THROW(decode_png("no picture"), InputError);
  EXPECT_THROW(decode_png(text.substr(0, text.size() / 2)), InputError);
}

TEST(Srgb, KnownPairs) {
  // 0.5 display is 0.21404 linear; the two parts of the curve meet at 0.04045 (IEC 61966-2-1).
  EXPECT_NEAR(srgb_decode(0.5F), 0.214041F, 1e-6);
  EXPECT_NEAR(srgb_encode(0.214041F), 0.5F, 1e-6);
  EXPECT_NEAR(srgb_encode(0.0031308F), 0.04045F, 1e-5);
  EXPECT_EQ(srgb_encode(0), 0);
  EXPECT_NEAR(srgb_encode(1), 1, 1e-6);
  EXPECT_EQ(srgb_encode(-1), 0);
  EXPECT_EQ(srgb_encode(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Srgb, EightBitValuesComeBack) {
  for (int i = 0; i < 256; ++i) {
    const float display = static_cast<float>(i) / 255;
    EXPECT_EQ(std::lround(srgb_encode(srgb_decode(display)) * 255), i);
  }
}

TEST(Display, LinearIsClampedAndEncodedAndAlphaOnlyClamped) {
  Image linear(1, 1, 4, Encoding::linear);
  linear.pixels = {4, 0.214041F, -1, 0.5F};
  const Image display = to_display(linear);
  EXPECT_EQ(display.encoding, Encoding::display);
  EXPECT_NEAR(display.pixels[0], 1, 1e-6);
  EXPECT_NEAR(display.pixels[1], 0.5, 1e-6);
  EXPECT_EQ(display.pixels[2], 0);
  EXPECT_EQ(display.pixels[3], 0.5F);
}

TEST_F(ImageFiles, PngKeepsEveryByteOfEveryChannelCount) {
  for (const std::uint32_t channels : {1U, 3U, 4U}) {
    const Image image = gradient(37, 11, channels, Encoding::display);
    const fs::path path = folder_ / (std::to_string(channels) + " channels.png");
    write_file_atomically(path, encode_png(image));
    const Image back = read_image(path);
    ASSERT_EQ(back.channels, channels);
    EXPECT_EQ(back.encoding, Encoding::display);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) ASSERT_NEAR(back.pixels[i], image.pixels[i], 1e-6) << i;
  }
}

TEST_F(ImageFiles, PngClampsAndRounds) {
  Image image(5, 1, 1);
  image.pixels = {-1, 2, std::numeric_limits<float>::quiet_NaN(), 0.4999F / 255, 0.5001F / 255};
  write_file_atomically(folder_ / "a.png", encode_png(image));
  const Image back = read_image(folder_ / "a.png");
  EXPECT_EQ(back.pixels[0], 0);
  EXPECT_EQ(back.pixels[1], 1);
  EXPECT_EQ(back.pixels[2], 0);
  EXPECT_EQ(back.pixels[3], 0);
  EXPECT_NEAR(back.pixels[4], 1.0F / 255, 1e-6);
}

TEST_F(ImageFiles, ExrKeepsFloatsAndHalves) {
  Image image(3, 2, 3, Encoding::linear);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = std::exp(static_cast<float>(i) - 9);
  write_file_atomically(folder_ / "full.exr", encode_exr(image, ExrPixel::full_float));
  EXPECT_EQ(read_image(folder_ / "full.exr").pixels, image.pixels);
  write_file_atomically(folder_ / "half.exr", encode_exr(image));
  const Image half = read_image(folder_ / "half.exr");
  EXPECT_EQ(half.encoding, Encoding::linear);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    EXPECT_NEAR(half.pixels[i], image.pixels[i], image.pixels[i] / 2048 + 1e-7) << i;
  }
}

TEST_F(ImageFiles, NumbersOfMapsComeBackWithTheirUnit) {
  const std::vector<std::uint32_t> counts = {0, 1, 64, 65535, 65537, 16777215};  // beyond what 16 bits hold
  const auto bytes = encode_counts_exr(3, 2, counts, "executions");
  write_file_atomically(folder_ / "counts.exr", bytes);
  const ImageFile file = read_image_file(folder_ / "counts.exr");
  EXPECT_EQ(file.channels, std::vector<std::string>{"Y"});
  EXPECT_EQ(file.image.pixels, std::vector<float>(counts.begin(), counts.end()));
  EXPECT_NE(std::string(bytes.begin(), bytes.end()).find("executions"), std::string::npos);
  Image values(2, 1, 1);
  values.pixels = {0.25F, 0.0078125F};
  write_file_atomically(folder_ / "values.exr", encode_values_exr(values, ""));
  EXPECT_EQ(read_image(folder_ / "values.exr").pixels, values.pixels);
  EXPECT_THROW(encode_counts_exr(2, 2, counts, ""), InputError);
  EXPECT_THROW(encode_values_exr(Image(2, 2, 3), ""), InputError);
}

TEST_F(ImageFiles, EqualImagesAreEqualBytes) {
  const Image image = gradient(64, 40, 3, Encoding::display);
  EXPECT_EQ(encode_png(image), encode_png(image));
  EXPECT_EQ(encode_exr(image), encode_exr(image));
}

TEST_F(ImageFiles, WhatIsNotAnImageIsRefusedByName) {
  const auto refusal = [](const fs::path& path) {
    try {
      read_image(path);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_TRUE(refusal(folder_ / "none.png").ends_with((folder_ / "none.png").string()));
  write_file_atomically(folder_ / "text.png", std::string_view("this is no image"));
  EXPECT_TRUE(refusal(folder_ / "text.png").starts_with("image: "));
  const auto expect_cut_is_refused = [&](std::vector<std::uint8_t> bytes, const char* name) {
    bytes.resize(bytes.size() / 2);
    write_file_atomically(folder_ / name, bytes);
    EXPECT_NE(refusal(folder_ / name), "accepted") << name;
  };
  expect_cut_is_refused(encode_exr(gradient(64, 64, 3, Encoding::linear)), "cut.exr");
#ifndef __SANITIZE_ADDRESS__
  // libpng's jump out of OpenImageIO's reader loses a string there, which the leak check would hold against us.
  expect_cut_is_refused(encode_png(gradient(64, 64, 3, Encoding::display)), "cut.png");
#endif
}

}  // namespace
}  // namespace subpixel::replay
