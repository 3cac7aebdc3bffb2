#include "capture_format/import/assimp_materials.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <tuple>

#include "capture_format/error.hpp"
#include "capture_format/import/text.hpp"
#include "capture_format/import/texture_decode.hpp"

namespace subpixel::capture {
namespace {

template <typename T>
std::optional<T> property(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
  T value;
  if (material.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
  return value;
}

float unit(float value) {
  return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 0.0f;
}

// A texture file with what its texels say.
struct Source {
  std::vector<std::byte> file;
  DecodedImage image;
};

class TextureLibrary {
 public:
  TextureLibrary(const aiScene& scene, const AssetSource& source, const std::string& model_name,
                 std::vector<Texture>& textures)
      : scene_(scene),
        source_(source),
        folder_(std::filesystem::path(model_name).parent_path().generic_string()),
        textures_(textures) {}

  // The name of the material's texture of a kind, or nothing.
  std::optional<std::string> name_of(const aiMaterial& material, aiTextureType type, unsigned index = 0) const {
    aiString name;
    if (material.GetTexture(type, index, &name) != aiReturn_SUCCESS || name.length == 0) return std::nullopt;
    return std::string(name.C_Str());
  }

  const Source& open(const std::string& name, const std::string& material) {
    const auto known = sources_.find(name);
    if (known != sources_.end()) return known->second;
    Source opened;
    std::string where = name;
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      where = "embedded texture " + name;
      opened = from_embedded(*embedded, where);
    } else {
      const std::string path = folder_.empty() ? name : folder_ + "/" + name;
      where = source_.describe(normal_name(path));
      std::optional<std::vector<std::byte>> bytes = source_.read(path);
      if (!bytes) {
        throw InputError("can't import the model",
                         "texture " + to_utf8(name) + " of material " + material + " is missing", where);
      }
      opened.image = decode_image(*bytes, where);
      opened.file = std::move(*bytes);
    }
    return sources_.emplace(name, std::move(opened)).first->second;
  }

  // The texture number of a file in the way it is used.
  std::uint32_t add(const std::string& name, bool srgb, const std::string& material) {
    const auto [number, is_new] = numbers_.try_emplace({name, "", srgb}, next_number());
    if (is_new) {
      const Source& opened = open(name, material);
      Texture texture{short_name(name), TextureEncoding::image_file, srgb, 0, 0, opened.file};
      if (opened.file.empty()) {  // an embedded texture of plain texels
        texture = {short_name(name), TextureEncoding::rgba8, srgb, opened.image.width, opened.image.height, {}};
        set_texels(texture, opened.image);
      }
      textures_.push_back(std::move(texture));
    }
    return number->second;
  }

  // Colour of one file with the alpha of another, as OBJ's map_d asks for.
  std::uint32_t add_combined(const std::string& colour, const std::string& alpha, const std::string& material) {
    const auto [number, is_new] = numbers_.try_emplace({colour, alpha, true}, next_number());
    if (is_new) {
      DecodedImage image = open(colour, material).image;
      DecodedImage mask = open(alpha, material).image;
      if (mask.width != image.width || mask.height != image.height) mask = resized(mask, image.width, image.height);
      for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        image.rgba[i + 3] = mask.has_alpha_channel ? mask.rgba[i + 3] : mask.rgba[i];
      }
      Texture texture{short_name(colour) + " with alpha of " + short_name(alpha),
                      TextureEncoding::rgba8,
                      true,
                      image.width,
                      image.height,
                      {}};
      set_texels(texture, image);
      textures_.push_back(std::move(texture));
    }
    return number->second;
  }

 private:
  std::uint32_t next_number() const { return static_cast<std::uint32_t>(textures_.size()); }

  static std::string short_name(const std::string& name) {
    return to_utf8(std::filesystem::path(normal_name(name)).filename().string());
  }

  static void set_texels(Texture& texture, const DecodedImage& image) {
    const auto bytes = std::as_bytes(std::span(image.rgba));
    texture.bytes.assign(bytes.begin(), bytes.end());
  }

  static Source from_embedded(const aiTexture& texture, const std::string& where) {
    Source opened;
    if (texture.mHeight == 0) {  // a whole image file of mWidth bytes
      const auto* from = reinterpret_cast<const std::byte*>(texture.pcData);
      opened.file.assign(from, from + texture.mWidth);
      opened.image = decode_image(opened.file, where);
      return opened;
    }
    opened.image.width = texture.mWidth;
    opened.image.height = texture.mHeight;
    opened.image.has_alpha_channel = true;
    const std::span texels(texture.pcData, std::size_t{texture.mWidth} * texture.mHeight);
    for (const aiTexel& texel : texels) {
      for (const std::uint8_t channel : {texel.r, texel.g, texel.b, texel.a}) opened.image.rgba.push_back(channel);
      opened.image.is_transparent = opened.image.is_transparent || texel.a < 255;
    }
    return opened;
  }

  const aiScene& scene_;
  const AssetSource& source_;
  std::string folder_;
  std::vector<Texture>& textures_;
  std::map<std::string, Source> sources_;
  std::map<std::tuple<std::string, std::string, bool>, std::uint32_t> numbers_;
};

// Blinn-Phong exponent to roughness: alpha = sqrt(2 / (n + 2)) (Walter et al. 2007), and glTF's alpha is roughness^2.
float roughness_of_exponent(float exponent) {
  return unit(std::sqrt(std::sqrt(2.0f / (std::max(exponent, 0.0f) + 2.0f))));
}

// IEC 61966-2-1. Colours in MTL files and their like are meant for the screen.
float linear_of_srgb(float value) {
  const float c = unit(value);
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

// glTF's factor multiplies its texture; the diffuse colour of older formats stands in where there is no texture.
void set_base_colour(const aiMaterial& from, TextureLibrary& textures, Material& material) {
  std::optional<std::string> name = textures.name_of(from, aiTextureType_BASE_COLOR);
  if (!name) name = textures.name_of(from, aiTextureType_DIFFUSE);
  aiColor4D factor(1, 1, 1, 1);
  if (from.Get(AI_MATKEY_BASE_COLOR, factor) == aiReturn_SUCCESS) {
    material.base_colour = {unit(factor.r), unit(factor.g), unit(factor.b), unit(factor.a)};
  } else {
    aiColor3D diffuse(0.8f, 0.8f, 0.8f);
    from.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
    if (name) diffuse = {1, 1, 1};
    material.base_colour = {linear_of_srgb(diffuse.r), linear_of_srgb(diffuse.g), linear_of_srgb(diffuse.b),
                            unit(property<float>(from, AI_MATKEY_OPACITY).value_or(1.0f))};
  }
  const std::optional<std::string> opacity = textures.name_of(from, aiTextureType_OPACITY);
  if (name && opacity && *opacity != *name) {
    material.base_colour_texture = textures.add_combined(*name, *opacity, material.name);
    material.alpha_mode = AlphaMode::test;
  } else if (name) {
    material.base_colour_texture = textures.add(*name, true, material.name);
    if (textures.open(*name, material.name).image.is_transparent) material.alpha_mode = AlphaMode::test;
  }
  if (material.alpha_mode == AlphaMode::opaque && material.base_colour[3] < 1) material.alpha_mode = AlphaMode::blend;
}

// glTF says how alpha is meant; other formats leave it to what was found in the textures.
void set_alpha_mode(const aiMaterial& from, Material& material) {
  if (const auto mode = property<aiString>(from, AI_MATKEY_GLTF_ALPHAMODE)) {
    const std::string name = mode->C_Str();
    material.alpha_mode = name == "MASK" ? AlphaMode::test : name == "BLEND" ? AlphaMode::blend : AlphaMode::opaque;
    material.alpha_cutoff = unit(property<float>(from, AI_MATKEY_GLTF_ALPHACUTOFF).value_or(0.5f));
  }
  material.two_sided = property<bool>(from, AI_MATKEY_TWOSIDED).value_or(false) ||
                       material.alpha_mode == AlphaMode::test;  // leaf cards are seen from behind, too
}

void set_surface(const aiMaterial& from, TextureLibrary& textures, Material& material) {
  const auto exponent = property<float>(from, AI_MATKEY_SHININESS);
  material.roughness = exponent ? roughness_of_exponent(*exponent) : material.roughness;
  if (const auto factor = property<float>(from, AI_MATKEY_ROUGHNESS_FACTOR)) material.roughness = unit(*factor);
  if (const auto factor = property<float>(from, AI_MATKEY_METALLIC_FACTOR)) material.metallic = unit(*factor);
  if (const auto name = textures.name_of(from, AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE)) {
    material.metallic_roughness_texture = textures.add(*name, false, material.name);
  }
  if (const auto name = textures.name_of(from, aiTextureType_NORMALS)) {
    material.normal_texture = textures.add(*name, false, material.name);
  }
}

void set_emission(const aiMaterial& from, TextureLibrary& textures, Material& material) {
  aiColor3D emissive(0, 0, 0);
  from.Get(AI_MATKEY_COLOR_EMISSIVE, emissive);
  const float strength = property<float>(from, AI_MATKEY_EMISSIVE_INTENSITY).value_or(1.0f);
  for (unsigned c = 0; c < 3; ++c) {
    const float radiance = emissive[c] * strength;
    material.emissive[c] = std::isfinite(radiance) ? std::max(radiance, 0.0f) : 0.0f;
  }
  if (const auto name = textures.name_of(from, aiTextureType_EMISSIVE)) {
    material.emissive_texture = textures.add(*name, true, material.name);
  }
}

}  // namespace

void add_materials(const aiScene& scene, const AssetSource& source, const std::string& model_name, Model& model) {
  TextureLibrary textures(scene, source, model_name, model.textures);
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    const aiMaterial& from = *scene.mMaterials[i];
    Material material;
    material.name = to_utf8(from.GetName().C_Str());
    if (material.name.empty()) material.name = model.name + " material " + std::to_string(i);
    set_base_colour(from, textures, material);
    set_alpha_mode(from, material);
    set_surface(from, textures, material);
    set_emission(from, textures, material);
    model.materials.push_back(std::move(material));
  }
}

}  // namespace subpixel::capture
