// From what someone asked for to a setting of a technique: the command line, the HTTP API, a night's configuration and
// the engine all take this way.
#pragma once

#include <cstdint>
#include <vector>

#include "replay/frame/technique.hpp"

namespace subpixel::replay {

// The technique with every parameter: those of the request, then the run's `samples` where it lets one choose that
// many, then the defaults. Throws UsageError naming the valid techniques, parameters, ranges or choices.
TechniqueSetting complete_technique(const TechniqueRequest& request, std::uint32_t samples);

// Adds the setting to a list of complete requests. False, leaving the list as it is, when it is there already.
bool add_once(std::vector<TechniqueRequest>& list, const TechniqueSetting& setting);

}  // namespace subpixel::replay
