#include "replay/scene/materials.hpp"

#include <algorithm>
#include <map>

namespace subpixel::replay {
namespace {

bool has(std::uint32_t texture) {
  return texture != capture::kNone;
}

bool is_dark(const capture::Float3& colour) {
  return colour[0] == 0 && colour[1] == 0 && colour[2] == 0;
}

}  // namespace

std::vector<bool> used_materials(const capture::Capture& capture) {
  std::vector<bool> used(capture.materials.size());
  for (const auto& frame : capture.frames)
    for (const auto& draw : frame.draws) used[draw.material] = true;
  return used;
}

bool is_alpha_tested(const capture::Material& material) {
  if (material.alpha_mode == capture::AlphaMode::opaque) return false;
  const float needed = material.alpha_mode == capture::AlphaMode::blend ? 1.0f : material.alpha_cutoff;
  return has(material.base_colour_texture) || material.base_colour[3] < needed;
}

std::array<std::uint32_t, 4> textures_of(const capture::Material& material) {
  return {material.base_colour_texture, material.metallic_roughness_texture, material.normal_texture,
          material.emissive_texture};
}

std::vector<TextureUse> texture_uses(const capture::Capture& capture) {
  std::map<std::uint32_t, TextureUse> uses;
  const std::vector<bool> used = used_materials(capture);
  for (std::size_t m = 0; m < used.size(); ++m) {
    if (!used[m]) continue;
    const auto& material = capture.materials[m];
    for (const std::uint32_t texture : textures_of(material))
      if (has(texture)) uses.try_emplace(texture, TextureUse{texture});
    if (!is_alpha_tested(material) || !has(material.base_colour_texture)) continue;
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

gpu_types::MaterialRecord record_of(const capture::Material& material) {
  gpu_types::MaterialRecord record{};
  record.base_colour = {material.base_colour[0], material.base_colour[1], material.base_colour[2],
                        material.base_colour[3]};
  record.emissive_cutoff = {material.emissive[0], material.emissive[1], material.emissive[2], material.alpha_cutoff};
  record.metal_rough = {material.metallic, material.roughness, 0, 0};
  std::uint32_t flags = 0;
  if (has(material.base_colour_texture)) flags |= MATERIAL_BASE_TEXTURE;
  if (is_alpha_tested(material)) flags |= MATERIAL_ALPHA_TEST;
  if (has(material.normal_texture)) flags |= MATERIAL_NORMAL_MAP;
  if (has(material.metallic_roughness_texture)) flags |= MATERIAL_ROUGHNESS_TEXTURE;
  if (has(material.emissive_texture)) flags |= MATERIAL_EMISSIVE_TEXTURE;
  if (material.two_sided) flags |= MATERIAL_TWO_SIDED;
  if (material.alpha_mode == capture::AlphaMode::blend) flags |= MATERIAL_ALPHA_BLEND;
  record.flags = {flags, 0, 0, 0};
  return record;
}

std::uint32_t detect_features(const capture::Capture& capture, PointLights lights) {
  std::uint32_t bits = 0;
  const std::vector<bool> used = used_materials(capture);
  std::optional<float> roughness;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const auto& material = capture.materials[i];
    if (has(material.base_colour_texture)) bits |= FEATURE_BASE_TEXTURE;
    if (is_alpha_tested(material)) bits |= FEATURE_ALPHA_TEST;
    if (has(material.normal_texture)) bits |= FEATURE_NORMAL_MAP;
    if (has(material.metallic_roughness_texture)) bits |= FEATURE_ROUGHNESS_TEXTURE | FEATURE_VARYING_ROUGHNESS;
    if (!is_dark(material.emissive)) {
      bits |= FEATURE_EMISSIVE;
      if (has(material.emissive_texture)) bits |= FEATURE_EMISSIVE_TEXTURE;
    }
    if (material.metallic != 0) bits |= FEATURE_METAL;
    if (material.two_sided) bits |= FEATURE_TWO_SIDED;
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
  }
  return bits;
}

}  // namespace subpixel::replay
