// The list of techniques.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "replay/frame/technique.hpp"

namespace subpixel::replay {

// All techniques, in the order they are listed to users. The only list there is.
std::span<const Technique* const> techniques();
// Throws UsageError that names the valid ones.
const Technique& find_technique(std::string_view name);
// The registry as JSON: [{name, title, paper, parameters: [{name, kind, doc, unit, minimum, maximum, allowed, choices,
// default}], maps: [{name, title, unit, maximum}]}]
nlohmann::json registry_json();

}  // namespace subpixel::replay
