#include "replay/scene/materials.hpp"

#include <algorithm>
#include <optional>

namespace subpixel::replay {
namespace {

bool has(std::uint32_t texture) { return texture != capture::kNone; }

bool is_dark(const capture::Float3& colour) { return colour[0] == 0 && colour[1] == 0 && colour[2] == 0; }

}  // namespace

std::vector<bool> used_materials(const capture::Capture& capture) {
  std::vector<bool> used(capture.materials.size());
  for (const auto& frame : capture.frames)
    for (const auto& draw : frame.draws) used[draw.material] = true;
  return used;
}

bool is_alpha_tested(const capture::Material& material) {
  if (material.alpha_mode == capture::AlphaMode::opaque) return false;
  return has(material.base_colour_texture) || material.base_colour[3] < material.alpha_cutoff;
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
