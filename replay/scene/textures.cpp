#include "replay/scene/textures.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "capture_format/limits.hpp"
#include "replay/measure/image.hpp"

namespace subpixel::replay {
namespace {

// A file name extension by which OpenImageIO finds the right reader, from the first bytes or else from the name.
std::string format_extension(const capture::Texture& texture) {
  struct Magic {
    std::string_view bytes, extension;
  };
  static constexpr Magic kMagic[] = {
      {"\x89PNG", "png"}, {"\xff\xd8\xff", "jpg"}, {"BM", "bmp"},  {"GIF8", "gif"}, {"DDS ", "dds"},  {"8BPS", "psd"},
      {"#?", "hdr"},      {"v/1\x01", "exr"},      {"II*", "tif"}, {"MM", "tif"},   {"RIFF", "webp"},
  };
  const std::string_view head(reinterpret_cast<const char*>(texture.bytes.data()),
                              std::min<std::size_t>(texture.bytes.size(), 16));
  for (const auto& magic : kMagic)
    if (head.starts_with(magic.bytes)) return std::string(magic.extension);
  const auto dot = texture.name.rfind('.');
  if (dot != std::string::npos && texture.name.find('/', dot) == std::string::npos && texture.name.size() - dot <= 5)
    return texture.name.substr(dot + 1);
  return "tga";  // the one common format without a magic number
}

std::string title(const capture::Texture& texture) {
  return "texture '" + texture.name + "'";
}

Mipmaps decode_file(const capture::Texture& texture) {
  OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(texture.bytes.data()), texture.bytes.size());
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  // Readers that are closed and opened again while their type is found out forget the argument, not the attribute.
  OIIO::Filesystem::IOProxy* proxy = &memory;
  config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const std::string name = "texture." + format_extension(texture);
  // Finding a reader by a file's name reads its head, and the one of DDS does not go back to the beginning.
  const bool is_dds = name.ends_with(".dds");
  auto input = is_dds ? OIIO::ImageInput::create("dds") : OIIO::ImageInput::open(name, &config, &memory);
  OIIO::ImageSpec opened;
  if (is_dds && input && !input->open(name, opened, config)) {
    throw InputError(title(texture), "can't be decoded: " + input->geterror(), name);
  }
  if (!input) throw InputError(title(texture), "can't be decoded: " + OIIO::geterror(), name);
  const OIIO::ImageSpec spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 ||
      static_cast<std::uint32_t>(spec.width) > capture::kMaxTextureSide ||
      static_cast<std::uint32_t>(spec.height) > capture::kMaxTextureSide)
    throw InputError(title(texture),
                     fmt::format("{}x{} texels with {} channels; at most {} a side", spec.width, spec.height,
                                 spec.nchannels, capture::kMaxTextureSide),
                     name);
  const std::size_t texels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const int channels = std::min(spec.nchannels, 4);
  std::vector<std::uint8_t> read(texels * static_cast<std::size_t>(channels));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, read.data()))
    throw InputError(title(texture), "can't be decoded: " + input->geterror(), name);

  Mipmaps image{static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height), texture.srgb, {}};
  auto& level = image.levels.emplace_back(texels * 4, std::uint8_t{255});
  for (std::size_t i = 0; i < texels; ++i) {
    const std::uint8_t* from = &read[i * static_cast<std::size_t>(channels)];
    std::uint8_t* to = &level[4 * i];
    const bool grey = channels < 3;
    for (int c = 0; c < 3; ++c) to[c] = grey ? from[0] : from[c];
    if (channels == 2 || channels == 4) to[3] = from[channels - 1];
  }
  return image;
}

// Linear light, colours weighted as the filter needs them, four floats a texel.
struct Level {
  std::uint32_t width = 0, height = 0;
  std::vector<float> texels;
};

const std::array<float, 256>& srgb_table() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < 256; ++i) values[i] = srgb_decode(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table;
}

std::uint8_t to_byte(float value) {
  const float rounded = std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f;
  return static_cast<std::uint8_t>(rounded);
}

Level to_linear(const Mipmaps& image, bool premultiply) {
  const auto& bytes = image.levels.front();
  Level level{image.width, image.height, std::vector<float>(bytes.size())};
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    const float alpha = static_cast<float>(bytes[i + 3]) / 255.0f;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = image.srgb ? srgb_table()[bytes[i + c]] : static_cast<float>(bytes[i + c]) / 255.0f;
      level.texels[i + c] = premultiply ? value * alpha : value;
    }
    level.texels[i + 3] = alpha;
  }
  return level;
}

// The source texels that target texel `i` covers along one axis, with their weights: a box of source/target texels,
// which on an odd side straddles three.
struct Span {
  std::uint32_t first = 0, count = 0;
  std::array<float, 3> weight{};
};

Span box_span(std::uint32_t source, std::uint32_t target, std::uint32_t i) {
  const double width = static_cast<double>(source) / target;
  const double begin = i * width, end = begin + width;
  Span span;
  span.first = static_cast<std::uint32_t>(begin);
  for (std::uint32_t s = span.first; s < source && s < span.first + 3; ++s) {
    const double overlap = std::min(end, s + 1.0) - std::max(begin, static_cast<double>(s));
    if (overlap <= 1e-9) break;
    span.weight[span.count++] = static_cast<float>(overlap / width);
  }
  return span;
}

Level halved(const Level& from) {
  Level to{std::max(1u, from.width / 2), std::max(1u, from.height / 2), {}};
  to.texels.resize(std::size_t{to.width} * to.height * 4);
  for (std::uint32_t y = 0; y < to.height; ++y) {
    const Span rows = box_span(from.height, to.height, y);
    for (std::uint32_t x = 0; x < to.width; ++x) {
      const Span columns = box_span(from.width, to.width, x);
      float* texel = &to.texels[(std::size_t{y} * to.width + x) * 4];
      for (std::uint32_t r = 0; r < rows.count; ++r)
        for (std::uint32_t c = 0; c < columns.count; ++c) {
          const float weight = rows.weight[r] * columns.weight[c];
          const float* source = &from.texels[(std::size_t{rows.first + r} * from.width + columns.first + c) * 4];
          for (int i = 0; i < 4; ++i) texel[i] += weight * source[i];
        }
    }
  }
  return to;
}

std::vector<std::uint8_t> to_bytes(const Level& level, bool srgb, bool premultiplied) {
  std::vector<std::uint8_t> bytes(level.texels.size());
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    const float alpha = level.texels[i + 3];
    const float scale = premultiplied ? (alpha > 0 ? 1.0f / alpha : 0.0f) : 1.0f;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = level.texels[i + c] * scale;
      bytes[i + c] = to_byte(srgb ? srgb_encode(std::min(value, 1.0f)) : value);
    }
    bytes[i + 3] = to_byte(alpha);
  }
  return bytes;
}

// The fraction of texels that pass `cutoff` (on 0..255) with their alpha scaled.
double coverage(const std::vector<std::uint8_t>& texels, double scale, double cutoff) {
  std::size_t passing = 0;
  for (std::size_t i = 3; i < texels.size(); i += 4) passing += texels[i] * scale >= cutoff ? 1 : 0;
  return static_cast<double>(passing) / (static_cast<double>(texels.size()) / 4.0);
}

void keep_coverage(std::vector<std::uint8_t>& texels, double wanted, double cutoff) {
  double low = 0, high = 16;
  for (int step = 0; step < 16; ++step) {
    const double middle = (low + high) / 2;
    (coverage(texels, middle, cutoff) < wanted ? low : high) = middle;
  }
  // Two scales bracket the wanted coverage; on a level of few texels they can differ much, so take the nearer.
  const double scale = wanted - coverage(texels, low, cutoff) < coverage(texels, high, cutoff) - wanted ? low : high;
  for (std::size_t i = 3; i < texels.size(); i += 4)
    texels[i] = static_cast<std::uint8_t>(std::min(255.0, std::floor(texels[i] * scale + 0.5)));
}

// Transparent texels take the next coarser level's colour, coarsest first.
void fill_transparent(Mipmaps& image) {
  for (std::size_t l = image.levels.size() - 1; l-- > 0;) {
    auto& fine = image.levels[l];
    const auto& coarse = image.levels[l + 1];
    const std::uint32_t width = std::max(1u, image.width >> l), height = std::max(1u, image.height >> l);
    const std::uint32_t coarse_width = std::max(1u, width / 2), coarse_height = std::max(1u, height / 2);
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x) {
        std::uint8_t* texel = &fine[(std::size_t{y} * width + x) * 4];
        if (texel[3] != 0) continue;
        const std::uint32_t cx = std::min(x / 2, coarse_width - 1), cy = std::min(y / 2, coarse_height - 1);
        std::copy_n(&coarse[(std::size_t{cy} * coarse_width + cx) * 4], 3, texel);
      }
  }
}

}  // namespace

Mipmaps decode_texture(const capture::Texture& texture) {
  if (texture.encoding == capture::TextureEncoding::image_file) return decode_file(texture);
  Mipmaps image{texture.width, texture.height, texture.srgb, {}};
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(texture.bytes.data());
  if (texture.width == 0 || texture.height == 0 ||
      texture.bytes.size() != std::size_t{texture.width} * texture.height * 4)
    throw InputError(
        title(texture),
        fmt::format("{} bytes are not {}x{} texels of 4", texture.bytes.size(), texture.width, texture.height),
        "rgba8");
  image.levels.emplace_back(bytes, bytes + texture.bytes.size());
  return image;
}

void build_mipmaps(Mipmaps& image, bool alpha_weighted, std::optional<float> alpha_cutoff) {
  Level level = to_linear(image, alpha_weighted);
  while (level.width > kMaxTextureSide || level.height > kMaxTextureSide) {
    level = halved(level);
    image.levels.front() = to_bytes(level, image.srgb, alpha_weighted);
    image.width = level.width;
    image.height = level.height;
  }
  image.levels.resize(1);
  while (level.width > 1 || level.height > 1) {
    level = halved(level);
    image.levels.push_back(to_bytes(level, image.srgb, alpha_weighted));
  }
  if (alpha_weighted) fill_transparent(image);
  if (!alpha_cutoff) return;
  const double cutoff = std::clamp(*alpha_cutoff * 255.0, 1.0, 255.0);
  const double wanted = coverage(image.levels.front(), 1.0, cutoff);
  for (std::size_t l = 1; l < image.levels.size(); ++l) keep_coverage(image.levels[l], wanted, cutoff);
}

Mipmaps load_texture(const capture::Capture& capture, const TextureUse& use) {
  const auto& texture = capture.textures[use.texture];
  Mipmaps mipmaps = decode_texture(texture);
  const capture::MipFilter mip = texture.sampler.mip;
  const bool of_means = mip == capture::MipFilter::linear_of_means || mip == capture::MipFilter::nearest_of_means;
  build_mipmaps(mipmaps, use.alpha_weighted, of_means ? std::nullopt : use.alpha_cutoff);
  if (mip == capture::MipFilter::none) mipmaps.levels.resize(1);
  return mipmaps;
}

}  // namespace subpixel::replay
