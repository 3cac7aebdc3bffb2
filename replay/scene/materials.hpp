// Materials as the shaders read them, and what the scene's shaders need.
#pragma once

#include <cstdint>
#include <vector>

#include "capture_format/capture.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// Materials some draw of some frame uses, by number.
std::vector<bool> used_materials(const capture::Capture& capture);

// True when a fragment's alpha can decide whether it is there: alpha-tested and blended materials (blending needs an
// order no G-buffer has, so blended surfaces are cut at their cutoff too), unless no texture varies the alpha and the
// factor passes the cutoff.
bool is_alpha_tested(const capture::Material& material);

gpu_types::MaterialRecord record_of(const capture::Material& material);

// Whether the replay keeps each frame's point lights, removes them all, or sets a number above 0.
enum class PointLights { captured, none, some };

// FEATURE_ bits of shared_types.h, for all frames together.
std::uint32_t detect_features(const capture::Capture& capture, PointLights lights);

}  // namespace subpixel::replay
