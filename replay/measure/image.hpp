// Images on the host: what frames are read back into, what metrics compare, and their PNG and EXR files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace subpixel::replay {

// display: sRGB-encoded, black 0 to white 1. linear: scene light, any value of 0 or more.
enum class Encoding { display, linear };

// Row-major from the top left, `channels` floats a pixel. Colour is in the first three channels (or in the only one);
// metrics ignore a fourth.
struct Image {
  std::uint32_t width = 0, height = 0, channels = 0;
  std::vector<float> pixels;
  Encoding encoding = Encoding::display;

  Image() = default;
  Image(std::uint32_t image_width, std::uint32_t image_height, std::uint32_t image_channels,
        Encoding image_encoding = Encoding::display, float value = 0)
      : width(image_width),
        height(image_height),
        channels(image_channels),
        pixels(std::size_t{image_width} * image_height * image_channels, value),
        encoding(image_encoding) {}

  std::size_t offset(std::uint32_t x, std::uint32_t y) const { return (std::size_t{y} * width + x) * channels; }
  std::uint32_t colour_channels() const { return channels < 3 ? 1 : 3; }
};

// The sRGB transfer (IEC 61966-2-1), both ways; outside 0..1 by the same formulae, negative values to 0.
float srgb_encode(float linear);
float srgb_decode(float display);

// Clamps linear colour to 0..1 and encodes it; a fourth channel is clamped only. No tone curve: that is the shading
// model's. A pixel with a colour that is NaN or infinite becomes NaN in all colours, which every metric counts as the
// largest difference. A display image comes back as it is.
Image to_display(const Image& image);

// What to_display() does to pixels that are not finite, for a display image that was made otherwise, of the same size.
void mark_not_finite(const Image& linear, Image& display);

// Whether all of a pixel's colours are finite; `pixel` is its index in row-major order.
bool is_finite(const Image& image, std::size_t pixel);

// Largest side that is read or written; beyond it an image is taken for damaged.
inline constexpr std::uint32_t max_image_side = 32768;

// 8 bits a channel, rounded to nearest; NaN writes 0. 1, 3 or 4 channels. The same image gives the same bytes.
std::vector<std::uint8_t> encode_png(const Image& image);

enum class ExrPixel { half_float, full_float };
// OpenEXR, zip-compressed, without a date: the same image gives the same bytes.
std::vector<std::uint8_t> encode_exr(const Image& image, ExrPixel pixel = ExrPixel::half_float);

// OpenEXR of one number a pixel, zip-compressed, in the channel Y, with `unit` in the attribute of that name: what maps
// are made of. Counts are 32-bit integers, the values of an image of one channel 16-bit floats.
std::vector<std::uint8_t> encode_counts_exr(std::uint32_t width, std::uint32_t height,
                                            std::span<const std::uint32_t> counts, std::string_view unit);
std::vector<std::uint8_t> encode_values_exr(const Image& values, std::string_view unit);

}  // namespace subpixel::replay
