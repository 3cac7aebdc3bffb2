#include "replay/scene/materials.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "capture_format/streams.hpp"
#include "replay/scene/geometry.hpp"

namespace subpixel::replay {
namespace {

bool has(std::uint32_t texture) {
  return texture != capture::kNone;
}

bool is_dark(const capture::Float3& colour) {
  return colour[0] == 0 && colour[1] == 0 && colour[2] == 0;
}

}  // namespace

std::vector<MaterialUse> material_uses(const capture::Capture& capture) {
  std::vector<MaterialUse> uses(capture.materials.size());
  for (const auto& frame : capture.frames)
    for (const auto& draw : frame.draws) {
      auto& use = uses[draw.material];
      use.drawn = true;
      use.translucent_vertices |= has(draw.colour.buffer) && capture::component_count(draw.colour.format) == 4;
    }
  return uses;
}

bool is_alpha_tested(const capture::Material& material, bool translucent_vertices) {
  if (material.alpha_mode == capture::AlphaMode::opaque) return false;
  const float needed = material.alpha_mode == capture::AlphaMode::blend ? 1.0f : material.alpha_cutoff;
  return has(material.base_colour_texture) || translucent_vertices || material.base_colour[3] < needed;
}

std::array<std::uint32_t, 4> textures_of(const capture::Material& material) {
  if (material.unlit) return {material.base_colour_texture, capture::kNone, capture::kNone, capture::kNone};
  return {material.base_colour_texture, material.metallic_roughness_texture, material.normal_texture,
          material.emissive_texture};
}

std::array<capture::UvMapping, 4> uv_mappings_of(const capture::Material& material) {
  std::array<capture::UvMapping, 4> mappings{material.base_colour_uv, material.metallic_roughness_uv,
                                             material.normal_uv, material.emissive_uv};
  for (auto& mapping : mappings)
    if (!std::ranges::all_of(mapping.matrix, [](float m) { return std::abs(m) <= kLargestUv; }))
      mapping.matrix = capture::UvMapping{}.matrix;
  return mappings;
}

std::vector<TextureUse> texture_uses(const capture::Capture& capture) {
  std::map<std::uint32_t, TextureUse> uses;
  const std::vector<MaterialUse> materials = material_uses(capture);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!materials[m].drawn) continue;
    const auto& material = capture.materials[m];
    for (const std::uint32_t texture : textures_of(material))
      if (has(texture)) uses.try_emplace(texture, TextureUse{texture});
    if (!is_alpha_tested(material, materials[m].translucent_vertices) || !has(material.base_colour_texture)) continue;
    auto& use = uses[material.base_colour_texture];
    use.alpha_weighted = true;
    if (material.alpha_mode != capture::AlphaMode::test) continue;
    const float cutoff = material.alpha_cutoff / std::max(material.base_colour[3], 1e-3f);
    use.alpha_cutoff = std::min(use.alpha_cutoff.value_or(1.0f), cutoff);
  }
  std::vector<TextureUse> result;
  for (const auto& [number, use] : uses) result.push_back(use);
  return result;
}

gpu_types::MaterialRecord record_of(const capture::Material& material, std::uint32_t number, MaterialUse use) {
  gpu_types::MaterialRecord record{};
  record.base_colour = {material.base_colour[0], material.base_colour[1], material.base_colour[2],
                        material.base_colour[3]};
  const capture::Float3 emissive = material.unlit ? capture::Float3{} : material.emissive;
  record.emissive_cutoff = {emissive[0], emissive[1], emissive[2], material.alpha_cutoff};
  record.metal_rough = {material.metallic, material.roughness, material.normal_scale, 0};
  const auto textures = textures_of(material);
  const auto mappings = uv_mappings_of(material);
  std::uint32_t flags = 0;
  constexpr std::uint32_t kTextureFlags[] = {MATERIAL_BASE_TEXTURE, MATERIAL_ROUGHNESS_TEXTURE, MATERIAL_NORMAL_MAP,
                                             MATERIAL_EMISSIVE_TEXTURE};
  for (std::size_t t = 0; t < textures.size(); ++t) {
    if (has(textures[t])) flags |= kTextureFlags[t];
    if (mappings[t].set != 0) flags |= std::uint32_t{MATERIAL_SECOND_UV} << t;
  }
  if (is_alpha_tested(material, use.translucent_vertices)) flags |= MATERIAL_ALPHA_TEST;
  if (material.two_sided) flags |= MATERIAL_TWO_SIDED;
  if (material.alpha_mode == capture::AlphaMode::blend) flags |= MATERIAL_ALPHA_BLEND;
  if (material.unlit) flags |= MATERIAL_UNLIT;
  record.flags = {flags, 4 * number, 0, 0};
  return record;
}

std::array<gpu_types::UvMappingRecord, 4> mapping_records_of(const capture::Material& material) {
  std::array<gpu_types::UvMappingRecord, 4> records{};
  const auto mappings = uv_mappings_of(material);
  for (std::size_t t = 0; t < mappings.size(); ++t) {
    const auto& m = mappings[t].matrix;
    records[t].row[0] = {m[0], m[1], m[2], 0};
    records[t].row[1] = {m[3], m[4], m[5], 0};
  }
  return records;
}

namespace {

// Of one drawn material, all but the roughness.
std::uint32_t material_features(const capture::Material& material, MaterialUse use) {
  std::uint32_t bits = 0;
  if (is_alpha_tested(material, use.translucent_vertices)) bits |= FEATURE_ALPHA_TEST;
  if (material.two_sided) bits |= FEATURE_TWO_SIDED;
  const auto textures = textures_of(material);
  const auto mappings = uv_mappings_of(material);
  for (std::size_t t = 0; t < textures.size(); ++t) {
    if (!has(textures[t])) continue;
    if (mappings[t].set != 0) bits |= FEATURE_SECOND_UV;
    if (mappings[t].matrix != capture::UvMapping{}.matrix) bits |= FEATURE_TEXTURE_TRANSFORM;
  }
  if (has(textures[0])) bits |= FEATURE_BASE_TEXTURE;
  if (material.unlit) return bits | FEATURE_UNLIT | FEATURE_EMISSIVE | FEATURE_METAL;
  if (has(material.normal_texture)) {
    bits |= FEATURE_NORMAL_MAP;
    if (material.normal_scale != 1) bits |= FEATURE_NORMAL_SCALE;
  }
  if (has(material.metallic_roughness_texture)) bits |= FEATURE_ROUGHNESS_TEXTURE | FEATURE_VARYING_ROUGHNESS;
  if (!is_dark(material.emissive)) {
    bits |= FEATURE_EMISSIVE;
    if (has(material.emissive_texture)) bits |= FEATURE_EMISSIVE_TEXTURE;
  }
  if (material.metallic != 0) bits |= FEATURE_METAL;
  return bits;
}

}  // namespace

std::uint32_t detect_features(const capture::Capture& capture, PointLights lights) {
  std::uint32_t bits = 0;
  const std::vector<MaterialUse> uses = material_uses(capture);
  std::optional<float> roughness;
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if (!uses[i].drawn) continue;
    const auto& material = capture.materials[i];
    bits |= material_features(material, uses[i]);
    for (const std::uint32_t texture : textures_of(material))
      if (has(texture) && capture.textures[texture].sampler != capture::Sampler{}) bits |= FEATURE_SAMPLERS;
    // What reflects nothing has no roughness.
    if (material.unlit) continue;
    if (roughness.value_or(material.roughness) != material.roughness) bits |= FEATURE_VARYING_ROUGHNESS;
    roughness = material.roughness;
  }
  if (lights == PointLights::some) bits |= FEATURE_POINT_LIGHTS;
  for (const auto& frame : capture.frames) {
    if (frame.sun && !is_dark(frame.sun->irradiance)) {
      bits |= FEATURE_SUN;
      if (frame.sun->shadows) bits |= FEATURE_SHADOWS;
    }
    if (lights == PointLights::captured && !frame.point_lights.empty()) bits |= FEATURE_POINT_LIGHTS;
    if (lights != PointLights::none &&
        std::ranges::any_of(frame.point_lights, [](const auto& light) { return light.cone.has_value(); }))
      bits |= FEATURE_SPOT_LIGHTS;
    for (const auto& draw : frame.draws)
      if (has(draw.colour.buffer)) bits |= FEATURE_VERTEX_COLOUR;
  }
  return bits;
}

}  // namespace subpixel::replay
