// Values of older formats' materials in ours.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

inline float unit(float value) {
  return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 0.0f;
}

// Blinn-Phong exponent to roughness: alpha = sqrt(2 / (n + 2)) (Walter et al. 2007), and glTF's alpha is roughness^2.
inline float roughness_of_exponent(float exponent) {
  return unit(std::sqrt(std::sqrt(2.0f / (std::max(exponent, 0.0f) + 2.0f))));
}

// IEC 61966-2-1. Colours in MTL files and their like are meant for the screen.
inline float linear_of_srgb(float value) {
  const float c = unit(value);
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

// Of faces that name no material: the name and colour (sRGB) that assimp gives most of them.
inline constexpr float kDefaultDiffuse = 0.6f;
inline constexpr const char* kDefaultMaterialName = "DefaultMaterial";

// `has_colours`: those of the vertices multiply the base colour, and are all that there is.
inline Material default_material(const std::string& name, bool has_colours) {
  Material material;
  material.name = name;
  const float grey = has_colours ? 1.0f : linear_of_srgb(kDefaultDiffuse);
  material.base_colour = {grey, grey, grey, 1};
  material.roughness = 1;
  return material;
}

}  // namespace subpixel::capture
