// Materials as the shaders read them, and what the scene's shaders need.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "capture_format/capture.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// Materials some draw of some frame uses, by number.
std::vector<bool> used_materials(const capture::Capture& capture);

// True when alpha decides which samples a fragment covers: alpha-tested materials, and blended ones, which cover as
// many samples as their alpha says. Not when no texture varies the alpha and the factor lets every sample pass.
bool is_alpha_tested(const capture::Material& material);

// A texture some used material needs, and what its alpha is for.
struct TextureUse {
  std::uint32_t texture = 0;            // number in the capture
  bool alpha_weighted = false;          // what is transparent must not bleed into what is not
  std::optional<float> alpha_cutoff{};  // of the alpha test: the lowest, as seen from the texel, of its materials
};
// In order of texture number.
std::vector<TextureUse> texture_uses(const capture::Capture& capture);

// Base colour, metallic-roughness, normal, emissive: numbers in the capture or kNone.
std::array<std::uint32_t, 4> textures_of(const capture::Material& material);

gpu_types::MaterialRecord record_of(const capture::Material& material);

// Whether the replay keeps each frame's point lights, removes them all, or sets a number above 0.
enum class PointLights { captured, none, some };

// FEATURE_ bits of shared_types.h, for all frames together.
std::uint32_t detect_features(const capture::Capture& capture, PointLights lights);

}  // namespace subpixel::replay
