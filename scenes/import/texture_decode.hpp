// Image files decoded to look at their texels: is there transparency, is the file sound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace subpixel::capture {

struct DecodedImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  // 4 * width * height, top row first; grey is repeated, missing alpha is 255
  bool has_alpha_channel = false;
  bool is_transparent = false;  // some alpha is below 255
};

// Decodes PNG, JPEG, TGA, BMP, GIF, ... held in memory. `where` names the file in errors. Throws InputError when no
// format fits, the file is damaged, or a side is longer than kMaxTextureSide.
DecodedImage decode_image(std::span<const std::byte> file, const std::string& where);

// `image` at another size, by OpenImageIO's default filter.
DecodedImage resized(const DecodedImage& image, std::uint32_t width, std::uint32_t height);

}  // namespace subpixel::capture
