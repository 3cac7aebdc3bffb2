#include "scenes/import/texture_decode.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <memory>

#include "base/error.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {
namespace {

// The first bytes of the formats that scene files use; a file's name often lies.
const char* extension_of(std::span<const std::byte> file) {
  const auto starts = [&](std::initializer_list<int> magic) {
    return file.size() >= magic.size() &&
           std::equal(magic.begin(), magic.end(), file.begin(),
                      [](int expected, std::byte actual) { return expected == std::to_integer<int>(actual); });
  };
  if (starts({0x89, 'P', 'N', 'G'})) return "texture.png";
  if (starts({0xff, 0xd8})) return "texture.jpg";
  if (starts({'G', 'I', 'F', '8'})) return "texture.gif";
  if (starts({'B', 'M'})) return "texture.bmp";
  if (starts({'I', 'I', '*', 0}) || starts({'M', 'M', 0, '*'})) return "texture.tif";
  if (starts({'R', 'I', 'F', 'F'})) return "texture.webp";
  if (starts({'#', '?'})) return "texture.hdr";
  return "texture.tga";  // has no magic at its start
}

}  // namespace

DecodedImage decode_image(std::span<const std::byte> file, const std::string& where) {
  const auto fail = [&](const std::string& why) { throw InputError("can't decode the texture", why, where); };
  OIIO::Filesystem::IOMemReader memory(file.data(), file.size());
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // colours as the file has them, not multiplied by alpha
  // Some readers are closed and opened again while their type is found out, and forget the argument.
  OIIO::Filesystem::IOProxy* proxy = &memory;
  config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const auto input = OIIO::ImageInput::open(extension_of(file), &config, &memory);
  if (!input) {
    OIIO::geterror();  // clears it; its text speaks of the made-up name
    fail("no known image format, or damaged");
  }
  const OIIO::ImageSpec& spec = input->spec();
  const auto side_fits = [](int side) { return side >= 1 && side <= static_cast<int>(kMaxTextureSide); };
  if (!side_fits(spec.width) || !side_fits(spec.height) || spec.nchannels < 1 || spec.nchannels > 8) {
    fail(std::to_string(spec.width) + "x" + std::to_string(spec.height) + " with " + std::to_string(spec.nchannels) +
         " channels is not supported");
  }
  DecodedImage image;
  image.width = static_cast<std::uint32_t>(spec.width);
  image.height = static_cast<std::uint32_t>(spec.height);
  const std::size_t texels = std::size_t{image.width} * image.height;
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<std::uint8_t> samples(texels * channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, samples.data())) fail(input->geterror());
  image.has_alpha_channel = channels == 2 || channels >= 4;
  image.rgba.resize(4 * texels);
  for (std::size_t i = 0; i < texels; ++i) {
    const std::uint8_t* from = &samples[i * channels];
    std::uint8_t* to = &image.rgba[4 * i];
    for (std::size_t c = 0; c < 3; ++c) to[c] = channels >= 3 ? from[c] : from[0];
    to[3] = channels == 2 ? from[1] : channels >= 4 ? from[3] : std::uint8_t{255};
    image.is_transparent = image.is_transparent || to[3] < 255;
  }
  return image;
}

DecodedImage resized(const DecodedImage& image, std::uint32_t width, std::uint32_t height) {
  const OIIO::ImageSpec from(static_cast<int>(image.width), static_cast<int>(image.height), 4, OIIO::TypeDesc::UINT8);
  const OIIO::ImageBuf source(from, const_cast<std::uint8_t*>(image.rgba.data()));  // wraps, never writes
  const OIIO::ROI region(0, static_cast<int>(width), 0, static_cast<int>(height), 0, 1, 0, 4);
  const OIIO::ImageBuf target = OIIO::ImageBufAlgo::resize(source, "", 0.0f, region, 1);
  DecodedImage result = image;
  result.width = width;
  result.height = height;
  result.rgba.resize(std::size_t{4} * width * height);
  target.get_pixels(region, OIIO::TypeDesc::UINT8, result.rgba.data());
  return result;
}

}  // namespace subpixel::capture
