// A technique as someone asked for it, made whole.
#pragma once

#include <cstdint>
#include <string>

#include "replay/results/parameters.hpp"

namespace subpixel::replay {

// `name` with every parameter filled in: `given`, then `samples` where the technique lets one choose them, then the
// defaults. Throws UsageError.
TechniqueRequest complete_technique(const std::string& name, ParameterValues given, std::uint32_t samples);

}  // namespace subpixel::replay
