#include "replay/measure/image.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "capture_format/error.hpp"

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

// First four channels at most. `name` stands in messages.
Image read_pixels(const std::unique_ptr<OIIO::ImageInput>& input, const std::string& name) {
  const auto fail = [&](const std::string& why) { throw InputError("image", why, name); };
  if (!input) fail(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  const auto in_bounds = [](int side) { return side > 0 && side <= static_cast<int>(max_image_side); };
  if (!in_bounds(spec.width) || !in_bounds(spec.height) || spec.nchannels < 1) {
    fail("size " + std::to_string(spec.width) + "x" + std::to_string(spec.height) + " is outside 1 to " +
         std::to_string(max_image_side));
  }
  // Two channels are grey with alpha; the grey alone is the picture.
  const int channels = spec.nchannels == 2 ? 1 : std::min(spec.nchannels, 4);
  Image image(static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height),
              static_cast<std::uint32_t>(channels),
              spec.format.is_floating_point() ? Encoding::linear : Encoding::display);
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, image.pixels.data())) fail(input->geterror());
  return image;
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

Image to_display(const Image& image) {
  if (image.encoding == Encoding::display) return image;
  Image display = image;
  display.encoding = Encoding::display;
  const std::uint32_t colour = image.colour_channels();
  for (std::size_t i = 0; i < display.pixels.size(); ++i) {
    const float clamped = std::clamp(display.pixels[i], 0.0F, 1.0F);
    display.pixels[i] = i % image.channels < colour ? srgb_encode(clamped) : clamped;
  }
  return display;
}

Image read_image(const std::filesystem::path& path) {
  OIIO::ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  return read_pixels(OIIO::ImageInput::open(path.string(), &wanted), path.string());
}

Image decode_png(std::string_view bytes) {
  OIIO::Filesystem::IOMemReader memory(const_cast<char*>(bytes.data()), bytes.size());  // is only read from
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create("png");
  OIIO::ImageSpec wanted, found;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  if (!input || !input->set_ioproxy(&memory) || !input->open("memory.png", found, wanted)) {
    throw InputError("image", input ? input->geterror() : OIIO::geterror(), "PNG in memory");
  }
  Image image = read_pixels(input, "PNG in memory");
  input.reset();  // before what it reads from
  return image;
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

}  // namespace subpixel::replay
