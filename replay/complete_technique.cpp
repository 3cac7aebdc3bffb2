#include "replay/complete_technique.hpp"

#include <algorithm>

#include "base/printable.hpp"
#include "replay/techniques/technique.hpp"

namespace subpixel::replay {

TechniqueRequest complete_technique(const std::string& name, ParameterValues given, std::uint32_t samples) {
  const Technique& technique = find_technique(printable(name, 60));
  // As Replay does: the run's number of samples goes to techniques that allow it.
  for (const Parameter& parameter : technique.parameters) {
    if (parameter.name == "samples" && std::ranges::count(parameter.allowed, static_cast<double>(samples)) > 0) {
      given.try_emplace("samples", samples);
    }
  }
  return {name, check_parameters(technique.name, technique.parameters, given)};
}

}  // namespace subpixel::replay
