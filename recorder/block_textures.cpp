#include "recorder/block_textures.hpp"

#include <array>

#include "recorder/subpixel_recorder.h"

namespace subpixel::recording {
namespace {

constexpr std::uint32_t four_cc(const char (&code)[5]) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(code[i]);
  return value;
}

// DDS_HEADER with its magic and DDS_PIXELFORMAT, in 32-bit words.
constexpr std::size_t kHeaderWords = 32;
constexpr std::size_t kPixelFormat = 19;  // the word where it begins
constexpr std::uint32_t kCapsHeightWidthFormatSize = 0x81007;
constexpr std::uint32_t kFourCcIsValid = 0x4;
constexpr std::uint32_t kNormalMap = 0x80000000;  // OpenImageIO works out z, without it reads grey and alpha
constexpr std::uint32_t kTexture = 0x1000;
constexpr std::uint32_t kTwoDimensions = 3;

}  // namespace

std::uint64_t level_bytes(const BlockFormat& format, std::uint32_t width, std::uint32_t height) {
  return std::uint64_t{(width + 3) / 4} * ((height + 3) / 4) * format.block_bytes;
}

std::vector<std::byte> dds_file(const BlockFormat& format, std::uint32_t width, std::uint32_t height,
                                std::span<const std::byte> blocks) {
  std::vector<std::uint32_t> words(kHeaderWords);
  words[0] = four_cc("DDS ");
  words[1] = 124;  // of the header, without the magic
  words[2] = kCapsHeightWidthFormatSize;
  words[3] = height;
  words[4] = width;
  words[5] = static_cast<std::uint32_t>(blocks.size());
  words[kPixelFormat] = 32;  // of itself
  words[kPixelFormat + 1] = kFourCcIsValid | (format.is_normal_map ? kNormalMap : 0);
  words[kPixelFormat + 2] = format.four_cc;
  words[27] = kTexture;
  if (format.dxgi != 0) {
    const std::array<std::uint32_t, 5> second{format.dxgi, kTwoDimensions, 0, 1, 0};
    words.insert(words.end(), second.begin(), second.end());
  }
  const auto head = std::as_bytes(std::span(words));
  std::vector<std::byte> file;
  file.reserve(head.size() + blocks.size());
  file.insert(file.end(), head.begin(), head.end());
  file.insert(file.end(), blocks.begin(), blocks.end());
  return file;
}

// The older header where there is one: OpenImageIO 2.4 knows nothing but BC6H and BC7 behind the second.
std::optional<BlockFormat> block_format(std::uint32_t texture_format) {
  switch (texture_format) {
    case SUBPIXEL_TEXTURE_BC1:
      return BlockFormat{8, four_cc("DXT1")};
    case SUBPIXEL_TEXTURE_BC2:
      return BlockFormat{16, four_cc("DXT3")};
    case SUBPIXEL_TEXTURE_BC3:
      return BlockFormat{16, four_cc("DXT5")};
    case SUBPIXEL_TEXTURE_BC4:
      return BlockFormat{8, four_cc("ATI1")};
    case SUBPIXEL_TEXTURE_BC5:
      return BlockFormat{16, four_cc("ATI2"), 0, true};
    case SUBPIXEL_TEXTURE_BC6H_UFLOAT:
      return BlockFormat{16, four_cc("DX10"), 95};
    case SUBPIXEL_TEXTURE_BC6H_SFLOAT:
      return BlockFormat{16, four_cc("DX10"), 96};
    case SUBPIXEL_TEXTURE_BC7:
      return BlockFormat{16, four_cc("DX10"), 98};
    default:
      return std::nullopt;
  }
}

}  // namespace subpixel::recording
