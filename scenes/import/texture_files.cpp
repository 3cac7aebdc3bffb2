#include "scenes/import/texture_files.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include "base/error.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

DecodedImage white(std::uint32_t width, std::uint32_t height) {
  DecodedImage image;
  image.width = width;
  image.height = height;
  image.rgba.assign(std::size_t{4} * width * height, 255);
  return image;
}

DecodedImage at_size_of(const DecodedImage& other, const DecodedImage& image) {
  if (image.width == other.width && image.height == other.height) return image;
  return resized(image, other.width, other.height);
}

bool is_grey(const DecodedImage& image) {
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] != image.rgba[i + 1] || image.rgba[i] != image.rgba[i + 2]) return false;
  }
  return true;
}

std::size_t channel_offset(char channel, const DecodedImage& image) {
  switch (channel) {
    case 'r':
      return 0;
    case 'g':
      return 1;
    case 'b':
      return 2;
    case 'm':
      return 3;
    default:
      return image.is_transparent ? 3 : 0;
  }
}

}  // namespace

const TextureFile& TextureFiles::open(const std::string& name) {
  const auto known = files_.find(name);
  if (known != files_.end()) return known->second;
  const std::string where = source_.describe(name);
  std::optional<std::vector<std::byte>> bytes = source_.read(name);
  if (!bytes) throw InputError("can't import the model", "the texture is missing", where);
  DecodedImage image = decode_image(*bytes, where);
  return files_.emplace(name, TextureFile{std::move(*bytes), std::move(image)}).first->second;
}

std::pair<std::uint32_t, bool> TextureFiles::number_of(Way way) {
  const auto [number, is_new] = numbers_.try_emplace(std::move(way), static_cast<std::uint32_t>(textures_.size()));
  return {number->second, is_new};
}

void TextureFiles::append_texels(const std::string& name, bool srgb, const DecodedImage& image,
                                 const Sampler& sampler) {
  Texture texture{name, TextureEncoding::rgba8, srgb, image.width, image.height, {}, sampler};
  const auto bytes = std::as_bytes(std::span(image.rgba));
  texture.bytes.assign(bytes.begin(), bytes.end());
  textures_.push_back(std::move(texture));
}

std::uint32_t TextureFiles::add(const std::string& name, bool srgb, const Sampler& sampler) {
  const TextureFile& file = open(name);
  const auto [number, is_new] =
      number_of({name, "", srgb ? Use::colour : Use::numbers, 0, sampler.wrap_u, sampler.wrap_v});
  if (is_new && file.bytes.empty()) append_texels(short_file_name(name), srgb, file.image, sampler);
  if (is_new && !file.bytes.empty()) {
    textures_.push_back({short_file_name(name), TextureEncoding::image_file, srgb, 0, 0, file.bytes, sampler});
  }
  return number;
}

std::uint32_t TextureFiles::add_with_alpha(const std::string& colour, const std::string& alpha, char channel,
                                           const Sampler& sampler) {
  const DecodedImage& alphas = open(alpha).image;
  DecodedImage image = colour.empty() ? white(alphas.width, alphas.height) : open(colour).image;
  const auto [number, is_new] = number_of({colour, alpha, Use::with_alpha, channel, sampler.wrap_u, sampler.wrap_v});
  if (!is_new) return number;
  const DecodedImage mask = at_size_of(image, alphas);
  const std::size_t offset = channel_offset(channel, mask);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) image.rgba[i + 3] = mask.rgba[i + offset];
  append_texels((colour.empty() ? "white" : short_file_name(colour)) + " with alpha of " + short_file_name(alpha), true,
                image, sampler);
  return number;
}

std::uint32_t TextureFiles::add_surface(const std::string& roughness, const std::string& metallic,
                                        const Sampler& sampler) {
  if (roughness == metallic && !is_grey(open(roughness).image)) return add(roughness, false, sampler);
  DecodedImage image = open(roughness.empty() ? metallic : roughness).image;
  const auto [number, is_new] = number_of({roughness, metallic, Use::surface, 0, sampler.wrap_u, sampler.wrap_v});
  if (!is_new) return number;
  const DecodedImage metal =
      metallic.empty() ? white(image.width, image.height) : at_size_of(image, open(metallic).image);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    image.rgba[i + 1] = roughness.empty() ? 255 : image.rgba[i];
    image.rgba[i + 2] = metal.rgba[i];
    image.rgba[i] = 0;
    image.rgba[i + 3] = 255;
  }
  append_texels((roughness.empty() ? "" : short_file_name(roughness) + " as roughness") +
                    (roughness.empty() || metallic.empty() ? "" : ", ") +
                    (metallic.empty() ? "" : short_file_name(metallic) + " as metallic"),
                false, image, sampler);
  return number;
}

std::string absent_texture_notice(const std::string& name, const std::string& material) {
  return "ignored: texture " + in_quotes(name) + " of material " + in_quotes(material) + ", whose file is missing";
}

std::string short_file_name(const std::string& name) {
  return to_utf8(std::filesystem::path(normal_name(name)).filename().string());
}

}  // namespace subpixel::capture
