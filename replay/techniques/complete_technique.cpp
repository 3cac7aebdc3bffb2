#include "replay/techniques/complete_technique.hpp"

#include <algorithm>

#include "base/printable.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::replay {

TechniqueSetting complete_technique(const TechniqueRequest& request, std::uint32_t samples) {
  const Technique& technique = find_technique(printable(request.technique, 60));
  ParameterValues given = request.parameters;
  for (const Parameter& parameter : technique.parameters) {
    if (parameter.name == "samples" && std::ranges::count(parameter.allowed, static_cast<double>(samples)) > 0)
      given.try_emplace("samples", samples);
  }
  return technique.with(given);
}

bool add_once(std::vector<TechniqueRequest>& list, const TechniqueSetting& setting) {
  const std::string_view name = setting.technique->name;
  const bool is_there = std::ranges::any_of(list, [&](const TechniqueRequest& other) {
    return other.technique == name && other.parameters == setting.values;
  });
  if (!is_there) list.push_back({std::string(name), setting.values});
  return !is_there;
}

}  // namespace subpixel::replay
