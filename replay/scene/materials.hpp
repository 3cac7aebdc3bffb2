// Materials as the shaders read them, and what the scene's shaders need.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "capture_format/capture.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// What the draws of all frames make of a material.
struct MaterialUse {
  bool drawn = false;
  bool translucent_vertices = false;  // some draw's vertex colours may be below 1 in alpha
};
// By number.
std::vector<MaterialUse> material_uses(const capture::Capture& capture);

// True when alpha decides which samples a fragment covers: alpha-tested materials, and blended ones, which cover as
// many samples as their alpha says. Not when nothing varies the alpha and the factor lets every sample pass.
bool is_alpha_tested(const capture::Material& material, bool translucent_vertices = false);

// A texture some used material needs, and what its alpha is for.
struct TextureUse {
  std::uint32_t texture = 0;            // number in the capture
  bool alpha_weighted = false;          // what is transparent must not bleed into what is not
  std::optional<float> alpha_cutoff{};  // of the alpha test: the lowest, as seen from the texel, of its materials
};
// In order of texture number.
std::vector<TextureUse> texture_uses(const capture::Capture& capture);

// Base colour, metallic-roughness, normal, emissive: numbers in the capture or kNone. Of an unlit material the first.
std::array<std::uint32_t, 4> textures_of(const capture::Material& material);
// Where they are read, in the same order. Matrices that are not finite count as absent.
std::array<capture::UvMapping, 4> uv_mappings_of(const capture::Material& material);

// `number`: the material's, which says where its uv mappings are.
gpu_types::MaterialRecord record_of(const capture::Material& material, std::uint32_t number, MaterialUse use);
std::array<gpu_types::UvMappingRecord, 4> mapping_records_of(const capture::Material& material);

// Whether the replay keeps each frame's point lights, removes them all, or sets a number above 0.
enum class PointLights { captured, none, some };

// FEATURE_ bits of shared_types.h, for all frames together.
std::uint32_t detect_features(const capture::Capture& capture, PointLights lights);

}  // namespace subpixel::replay
