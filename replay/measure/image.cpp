#include "replay/measure/image.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

std::vector<std::uint8_t> encode(const std::string& extension, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                                 const void* pixels) {
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(extension);
  if (!output) throw InputError("image", "this OpenImageIO cannot write " + extension, OIIO::geterror());
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  output->set_ioproxy(&memory);
  const bool written =
      output->open("memory." + extension, spec) && output->write_image(type, pixels) && output->close();
  if (!written) throw InputError("image", "cannot encode " + extension, output->geterror());
  return bytes;
}

std::uint8_t to_byte(float value) {
  if (!(value > 0)) return 0;  // NaN too
  const float scaled = std::min(value, 1.0F) * 255.0F;
  const auto floor = static_cast<std::uint8_t>(scaled);
  // Half up; std::lround would be a call for each of a frame's millions of values.
  return static_cast<std::uint8_t>(floor + (scaled - static_cast<float>(floor) >= 0.5F ? 1 : 0));
}

// Only what a file of the given image needs; no date, no program version: equal images are equal bytes.
OIIO::ImageSpec spec_for(const Image& image, const OIIO::TypeDesc& type) {
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), static_cast<int>(image.channels),
                       type);
  // Alpha is stored as it is, without multiplying or dividing colour by it.
  spec.attribute("oiio:UnassociatedAlpha", 1);
  return spec;
}

std::vector<std::uint8_t> encode_channel_exr(OIIO::ImageSpec spec, const OIIO::TypeDesc& type, const void* pixels,
                                             std::string_view unit) {
  spec.channelnames = {"Y"};
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", "");  // else the time of writing: the same image must give the same bytes
  spec.attribute("unit", std::string(unit));
  return encode("exr", spec, type, pixels);
}

}  // namespace

float srgb_encode(float linear) {
  if (!(linear > 0)) return 0;
  return linear <= 0.0031308F ? linear * 12.92F : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
}

float srgb_decode(float display) {
  if (!(display > 0)) return 0;
  return display <= 0.04045F ? display / 12.92F : std::pow((display + 0.055F) / 1.055F, 2.4F);
}

bool is_finite(const Image& image, std::size_t pixel) {
  const float* const colours = &image.pixels[pixel * image.channels];
  bool finite = true;
  for (std::uint32_t c = 0; c < image.colour_channels(); ++c) finite = finite && std::isfinite(colours[c]);
  return finite;
}

void mark_not_finite(const Image& linear, Image& display) {
  assert(linear.width == display.width && linear.height == display.height);
  const std::size_t pixels = std::size_t{linear.width} * linear.height;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (is_finite(linear, i)) continue;
    float* const colours = &display.pixels[i * display.channels];
    std::fill_n(colours, display.colour_channels(), std::numeric_limits<float>::quiet_NaN());
  }
}

Image to_display(const Image& image) {
  if (image.encoding == Encoding::display) return image;
  Image display = image;
  display.encoding = Encoding::display;
  const std::uint32_t colour = image.colour_channels();
  for (std::size_t i = 0; i < display.pixels.size(); ++i) {
    const float clamped = std::clamp(display.pixels[i], 0.0F, 1.0F);
    display.pixels[i] = i % image.channels < colour ? srgb_encode(clamped) : clamped;
  }
  mark_not_finite(image, display);
  return display;
}

std::vector<std::uint8_t> encode_png(const Image& image) {
  std::vector<std::uint8_t> bytes(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), bytes.begin(), to_byte);
  OIIO::ImageSpec spec = spec_for(image, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  // Frames are written in the run whose wall time counts: at 1280x720 zlib's level 1 without row filters takes 36 ms,
  // the defaults 66 ms, and the files differ by a tenth.
  spec.attribute("png:compressionLevel", 1);
  spec.attribute("png:filter", 8);  // PNG_FILTER_NONE
  return encode("png", spec, OIIO::TypeDesc::UINT8, bytes.data());
}

std::vector<std::uint8_t> encode_exr(const Image& image, ExrPixel pixel) {
  OIIO::ImageSpec spec = spec_for(image, pixel == ExrPixel::half_float ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.attribute("oiio:ColorSpace", image.encoding == Encoding::linear ? "Linear" : "sRGB");
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", "");  // else the time of writing: the same image must give the same bytes
  return encode("exr", spec, OIIO::TypeDesc::FLOAT, image.pixels.data());
}

std::vector<std::uint8_t> encode_counts_exr(std::uint32_t width, std::uint32_t height,
                                            std::span<const std::uint32_t> counts, std::string_view unit) {
  if (counts.size() != std::size_t{width} * height) throw InputError("map", "needs a count for each pixel", "map");
  const OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 1, OIIO::TypeDesc::UINT);
  return encode_channel_exr(spec, OIIO::TypeDesc::UINT, counts.data(), unit);
}

std::vector<std::uint8_t> encode_values_exr(const Image& values, std::string_view unit) {
  if (values.channels != 1) throw InputError("map", "needs one channel", "map");
  return encode_channel_exr(spec_for(values, OIIO::TypeDesc::HALF), OIIO::TypeDesc::FLOAT, values.pixels.data(), unit);
}

}  // namespace subpixel::replay
