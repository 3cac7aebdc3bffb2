#include "scenes/import/assimp_materials.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "scenes/import/material_values.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"
#include "scenes/import/texture_files.hpp"

namespace subpixel::capture {
namespace {

template <typename T>
std::optional<T> property(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
  T value;
  if (material.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
  return value;
}

TextureFile from_embedded(const aiTexture& texture, const std::string& where) {
  TextureFile file;
  if (texture.mHeight == 0) {  // a whole image file of mWidth bytes
    const auto* from = reinterpret_cast<const std::byte*>(texture.pcData);
    file.bytes.assign(from, from + texture.mWidth);
    file.image = decode_image(file.bytes, where);
    return file;
  }
  file.image.width = texture.mWidth;
  file.image.height = texture.mHeight;
  file.image.has_alpha_channel = true;
  const std::span texels(texture.pcData, std::size_t{texture.mWidth} * texture.mHeight);
  for (const aiTexel& texel : texels) {
    for (const std::uint8_t channel : {texel.r, texel.g, texel.b, texel.a}) file.image.rgba.push_back(channel);
    file.image.is_transparent = file.image.is_transparent || texel.a < 255;
  }
  return file;
}

struct NamedTexture {
  std::string name;  // in NamedTextures::files()
  Sampler sampler;
};

Wrap wrap_of(aiTextureMapMode mode) {
  return mode == aiTextureMapMode_Mirror                                    ? Wrap::mirrored_repeat
         : mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? Wrap::clamp_to_edge
                                                                            : Wrap::repeat;
}

// Finds the textures that materials name: beside the model, or inside its file.
class NamedTextures {
 public:
  // Textures and notices are added to `model`, which outlives this as the others do.
  NamedTextures(const aiScene& scene, const AssetSource& source, const std::string& model_name, Model& model)
      : scene_(scene),
        source_(source),
        model_name_(model_name),
        folder_(std::filesystem::path(model_name).parent_path().generic_string()),
        files_(source, model.textures),
        notices_(model.notices) {}

  TextureFiles& files() { return files_; }

  // The material's texture of a kind, or nothing when there is none of that kind or, with a notice, its file is absent.
  std::optional<NamedTexture> find(const aiMaterial& from, aiTextureType type, unsigned index,
                                   const std::string& material) {
    aiString written;
    aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    if (from.GetTexture(type, index, &written, nullptr, nullptr, nullptr, nullptr, modes) != aiReturn_SUCCESS ||
        written.length == 0) {
      return std::nullopt;
    }
    Sampler sampler;
    sampler.wrap_u = wrap_of(modes[0]);
    sampler.wrap_v = wrap_of(modes[1]);
    const std::string name = written.C_Str();
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      const std::string inside = "embedded texture " + name;
      if (embedded_.insert(name).second) {
        files_.embed(inside, from_embedded(*embedded, source_.describe(model_name_) + ", " + inside));
      }
      return NamedTexture{inside, sampler};
    }
    if (const auto found = find_beside(source_, {folder_}, name)) return NamedTexture{*found, sampler};
    if (absent_.emplace(name, material).second) notices_.push_back(absent_texture_notice(name, material));
    return std::nullopt;
  }

 private:
  const aiScene& scene_;
  const AssetSource& source_;
  std::string model_name_, folder_;
  TextureFiles files_;
  std::vector<std::string>& notices_;
  std::set<std::string> embedded_;
  std::set<std::pair<std::string, std::string>> absent_;  // texture, material: one may be there in several uses
};

// glTF's factor multiplies its texture; the diffuse colour of older formats stands in where there is no texture.
void set_base_colour(const aiMaterial& from, NamedTextures& textures, Material& material) {
  std::optional<NamedTexture> colour = textures.find(from, aiTextureType_BASE_COLOR, 0, material.name);
  if (!colour) colour = textures.find(from, aiTextureType_DIFFUSE, 0, material.name);
  aiColor4D factor(1, 1, 1, 1);
  if (from.Get(AI_MATKEY_BASE_COLOR, factor) == aiReturn_SUCCESS) {
    material.base_colour = {unit(factor.r), unit(factor.g), unit(factor.b), unit(factor.a)};
  } else {
    aiColor3D diffuse(kDefaultDiffuse, kDefaultDiffuse, kDefaultDiffuse);
    from.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
    if (colour) diffuse = {1, 1, 1};
    material.base_colour = {linear_of_srgb(diffuse.r), linear_of_srgb(diffuse.g), linear_of_srgb(diffuse.b),
                            unit(property<float>(from, AI_MATKEY_OPACITY).value_or(1.0f))};
  }
  const std::optional<NamedTexture> opacity = textures.find(from, aiTextureType_OPACITY, 0, material.name);
  if (opacity && (!colour || opacity->name != colour->name)) {
    material.base_colour_texture = textures.files().add_with_alpha(colour ? colour->name : "", opacity->name, 0,
                                                                   colour ? colour->sampler : opacity->sampler);
    material.alpha_mode = AlphaMode::test;
  } else if (colour) {
    material.base_colour_texture = textures.files().add(colour->name, true, colour->sampler);
    if (textures.files().open(colour->name).image.is_transparent) material.alpha_mode = AlphaMode::test;
  }
  if (material.alpha_mode == AlphaMode::opaque && material.base_colour[3] < 1) material.alpha_mode = AlphaMode::blend;
}

// Formats and exporters do not agree on whether 0 is opaque, and nobody models what is never seen.
void show_invisible(Material& material, std::vector<std::string>& notices) {
  if (material.base_colour[3] != 0) return;
  notices.push_back("read: opacity 0 of material " + in_quotes(material.name) +
                    " as 1, since nothing of it would show");
  material.base_colour[3] = 1;
  if (material.alpha_mode == AlphaMode::blend) material.alpha_mode = AlphaMode::opaque;
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

void set_surface(const aiMaterial& from, NamedTextures& textures, Material& material) {
  const auto exponent = property<float>(from, AI_MATKEY_SHININESS);
  material.roughness = exponent ? roughness_of_exponent(*exponent) : material.roughness;
  if (const auto factor = property<float>(from, AI_MATKEY_ROUGHNESS_FACTOR)) material.roughness = unit(*factor);
  if (const auto factor = property<float>(from, AI_MATKEY_METALLIC_FACTOR)) material.metallic = unit(*factor);
  if (const auto map =
          textures.find(from, AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, material.name)) {
    material.metallic_roughness_texture = textures.files().add(map->name, false, map->sampler);
  }
  if (const auto map = textures.find(from, aiTextureType_NORMALS, 0, material.name)) {
    material.normal_texture = textures.files().add(map->name, false, map->sampler);
  }
}

void set_emission(const aiMaterial& from, NamedTextures& textures, Material& material) {
  aiColor3D emissive(0, 0, 0);
  from.Get(AI_MATKEY_COLOR_EMISSIVE, emissive);
  const float strength = property<float>(from, AI_MATKEY_EMISSIVE_INTENSITY).value_or(1.0f);
  for (unsigned c = 0; c < 3; ++c) {
    const float radiance = emissive[c] * strength;
    material.emissive[c] = std::isfinite(radiance) ? std::max(radiance, 0.0f) : 0.0f;
  }
  if (const auto map = textures.find(from, aiTextureType_EMISSIVE, 0, material.name)) {
    material.emissive_texture = textures.files().add(map->name, true, map->sampler);
  }
}

}  // namespace

void add_materials(const aiScene& scene, const AssetSource& source, const std::string& model_name, Model& model) {
  NamedTextures textures(scene, source, model_name, model);
  std::set<unsigned> used;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) used.insert(scene.mMeshes[i]->mMaterialIndex);
  const aiMaterial nothing;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    // One that no mesh has may name textures that are nowhere.
    const aiMaterial& from = used.contains(i) ? *scene.mMaterials[i] : nothing;
    Material material;
    material.name = to_utf8(scene.mMaterials[i]->GetName().C_Str());
    if (material.name.empty()) material.name = model.name + " material " + std::to_string(i);
    set_base_colour(from, textures, material);
    set_alpha_mode(from, material);
    show_invisible(material, model.notices);
    set_surface(from, textures, material);
    set_emission(from, textures, material);
    model.materials.push_back(std::move(material));
  }
}

}  // namespace subpixel::capture
