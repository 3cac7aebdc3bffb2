#include "replay/scene/textures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <span>

#include "base/error.hpp"
#include "replay/measure/image.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

Mipmaps level0(std::uint32_t width, std::uint32_t height, bool srgb, std::vector<std::uint8_t> texels) {
  return {width, height, srgb, {std::move(texels)}};
}

TEST(SceneTextures, MipmapsAverageInLinearLight) {
  auto image = level0(2, 1, true, {0, 0, 0, 255, 255, 255, 255, 255});
  build_mipmaps(image, false, std::nullopt);
  ASSERT_EQ(image.levels.size(), 2u);
  EXPECT_EQ(image.levels[1], (std::vector<std::uint8_t>{188, 188, 188, 255}));  // sRGB of linear 0.5
  auto linear = level0(2, 1, false, {0, 0, 0, 255, 255, 255, 255, 255});
  build_mipmaps(linear, false, std::nullopt);
  EXPECT_EQ(linear.levels[1], (std::vector<std::uint8_t>{128, 128, 128, 255}));
}

TEST(SceneTextures, OddSidesKeepTheMean) {
  std::vector<std::uint8_t> texels;
  double sum = 0;
  for (int i = 0; i < 5 * 7; ++i) {
    const auto value = static_cast<std::uint8_t>(i * 97 % 256);
    sum += value;
    texels.insert(texels.end(), {value, value, value, 255});
  }
  auto image = level0(5, 7, false, texels);
  build_mipmaps(image, false, std::nullopt);
  ASSERT_EQ(image.levels.size(), 3u);
  EXPECT_EQ(image.levels[1].size(), 2u * 3u * 4u);
  EXPECT_EQ(image.levels[2].size(), 4u);
  EXPECT_NEAR(image.levels[2][0], sum / 35, 1.5);
}

TEST(SceneTextures, TransparentTexelsDontBleedColour) {
  auto image = level0(2, 2, false, {10, 200, 30, 255, 255, 0, 255, 0, 255, 0, 255, 0, 255, 0, 255, 0});
  build_mipmaps(image, true, std::nullopt);
  EXPECT_EQ(image.levels[1], (std::vector<std::uint8_t>{10, 200, 30, 64}));
  // Level 0's transparent texels took the colour beside them.
  EXPECT_EQ(image.levels[0][4], 10);
  EXPECT_EQ(image.levels[0][7], 0);
}

TEST(SceneTextures, MipmapsKeepTheCoverageOfTheAlphaTest) {
  // Thin opaque strokes on one texel in five: plain averages would all fall below the cutoff.
  constexpr std::uint32_t kSide = 64;
  std::vector<std::uint8_t> texels;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const bool stroke = (i % kSide * 3 + i / kSide * 7) % 5 == 0;
    texels.insert(texels.end(), {50, 100, 20, static_cast<std::uint8_t>(stroke ? 255 : 20)});
  }
  const auto coverage = [](const std::vector<std::uint8_t>& level) {
    int passing = 0;
    for (std::size_t i = 3; i < level.size(); i += 4) passing += level[i] >= 128 ? 1 : 0;
    return passing / (static_cast<double>(level.size()) / 4);
  };
  auto plain = level0(kSide, kSide, true, texels), kept = plain;
  build_mipmaps(plain, true, std::nullopt);
  build_mipmaps(kept, true, 0.5f);
  const double wanted = coverage(kept.levels[0]);
  EXPECT_NEAR(wanted, 0.2, 0.02);
  EXPECT_EQ(coverage(plain.levels[2]), 0.0);
  for (std::size_t l = 1; l < 3; ++l) EXPECT_NEAR(coverage(kept.levels[l]), wanted, 0.15) << "level " << l;
}

TEST(SceneTextures, LevelsOfMeansAreWhatTheyAreWhateverTheAlphaTest) {
  capture::Capture capture;
  auto& texture = capture.textures.emplace_back();
  texture.width = texture.height = 2;
  for (const int value : {255, 0, 0, 0}) texture.bytes.insert(texture.bytes.end(), 4, static_cast<std::byte>(value));
  const auto smallest = [&](capture::MipFilter mip) {
    texture.sampler.mip = mip;
    return load_texture(capture, {0, true, 0.2f}).levels.back()[3];
  };
  EXPECT_EQ(smallest(capture::MipFilter::linear_of_means), 64);
  EXPECT_EQ(smallest(capture::MipFilter::nearest_of_means), 64);
  // A quarter of the largest level passes, all of the smallest would.
  EXPECT_NE(smallest(capture::MipFilter::linear), 64);
  EXPECT_NE(smallest(capture::MipFilter::nearest), 64);
}

TEST(SceneTextures, DecodesImageFilesOfOneToFourChannels) {
  const std::vector<std::pair<std::uint32_t, std::vector<std::uint8_t>>> cases{
      {1, {51, 51, 51, 255}}, {3, {51, 102, 153, 255}}, {4, {51, 102, 153, 204}}};
  for (const auto& [channels, expected] : cases) {
    Image image(3, 2, channels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = 0.2f * static_cast<float>(i % channels + 1);
    const auto png = encode_png(image);
    capture::Texture texture{"picture", capture::TextureEncoding::image_file, true, 0, 0, {}};
    texture.bytes.assign(reinterpret_cast<const std::byte*>(png.data()),
                         reinterpret_cast<const std::byte*>(png.data() + png.size()));
    const auto decoded = decode_texture(texture);
    EXPECT_EQ(decoded.width, 3u);
    EXPECT_EQ(decoded.height, 2u);
    EXPECT_TRUE(decoded.srgb);
    EXPECT_EQ(std::vector<std::uint8_t>(decoded.levels[0].begin(), decoded.levels[0].begin() + 4), expected)
        << channels << " channels";
  }
}

// A file of 4x4 red texels: the first block colour, which index 0 means.
std::vector<std::byte> dds_file(const char (&code)[5], std::uint32_t dxgi_format,
                                const std::vector<unsigned char>& block) {
  std::vector<std::uint32_t> words(dxgi_format != 0 ? 37 : 32);
  words[0] = 0x20534444, words[1] = 124, words[2] = 0x81007, words[3] = 4, words[4] = 4;  // "DDS ", sizes
  words[5] = static_cast<std::uint32_t>(block.size());
  words[19] = 32, words[20] = 4, words[27] = 0x1000;
  std::memcpy(&words[21], code, 4);
  if (dxgi_format != 0) words[32] = dxgi_format, words[33] = 3, words[35] = 1;
  const auto head = std::as_bytes(std::span(words)), tail = std::as_bytes(std::span(block));
  std::vector<std::byte> file(head.begin(), head.end());
  file.insert(file.end(), tail.begin(), tail.end());
  return file;
}

TEST(SceneTextures, DecodesBlockCompressedFiles) {
  capture::Texture texture;
  texture.encoding = capture::TextureEncoding::image_file;
  // BC1 by its FourCC, and BC7, which has none: red, and a block of mode 6 whose end points are all 0.
  std::vector<unsigned char> nothing(16);
  nothing[0] = 0x40;
  const std::vector<std::uint8_t> red{255, 0, 0, 255}, clear{0, 0, 0, 0};
  for (const auto& [file, expected] : {std::pair{dds_file("DXT1", 0, {0x00, 0xf8, 0, 0, 0, 0, 0, 0}), red},
                                       std::pair{dds_file("DX10", 98, nothing), clear}}) {
    texture.bytes = file;
    const Mipmaps image = decode_texture(texture);
    ASSERT_EQ(image.width, 4u);
    for (std::size_t i = 0; i < 16; ++i) {
      EXPECT_EQ(std::vector<std::uint8_t>(image.levels[0].begin() + 4 * i, image.levels[0].begin() + 4 * i + 4),
                expected);
    }
  }
  // What the reader does not know is said: BC1 without its FourCC.
  texture.bytes = dds_file("DX10", 71, {0x00, 0xf8, 0, 0, 0, 0, 0, 0});
  EXPECT_THROW(decode_texture(texture), InputError);
}

TEST(SceneTextures, BrokenFilesAreNamed) {
  for (const char* content : {"", "not an image", "\x89PNG\r\n\x1a\nbroken", "BM", "\xff\xd8\xff\xe0"}) {
    capture::Texture texture{"bark", capture::TextureEncoding::image_file, true, 0, 0, {}};
    const std::string_view text(content);
    texture.bytes.assign(reinterpret_cast<const std::byte*>(text.data()),
                         reinterpret_cast<const std::byte*>(text.data() + text.size()));
    try {
      decode_texture(texture);
      FAIL() << "decoded: " << content;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bark"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace subpixel::replay
