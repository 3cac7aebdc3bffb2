#include <fmt/format.h>

#include "base/error.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::replay {

extern const Technique kNoaa, kFxaa, kSmaa, kTaa, kForward, kMsaa, kSimpleComplex, kSbaa, kStreaming, kAgaa, kDcaa,
    kLinkedList, kHybrid, kVisibility, kDais;

std::span<const Technique* const> techniques() {
  static constexpr const Technique* kAll[] = {
      &kNoaa,      &kFxaa, &kSmaa, &kTaa,        &kForward, &kMsaa,       &kSimpleComplex, &kSbaa,
      &kStreaming, &kAgaa, &kDcaa, &kLinkedList, &kHybrid,  &kVisibility, &kDais,
  };
  return kAll;
}

const Technique& find_technique(std::string_view name) {
  std::string valid;
  for (const Technique* technique : techniques()) {
    if (technique->name == name) return *technique;
    valid += (valid.empty() ? "" : ", ") + std::string(technique->name);
  }
  throw UsageError("technique", fmt::format("'{}' is not one of {}", name, valid), "techniques");
}

namespace {

const char* kind_name(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::integer:
      return "integer";
    case ParameterKind::number:
      return "number";
    case ParameterKind::choice:
      return "choice";
    case ParameterKind::boolean:
      return "boolean";
  }
  return "";
}

}  // namespace

nlohmann::json registry_json() {
  nlohmann::json list = nlohmann::json::array();
  for (const Technique* technique : techniques()) {
    nlohmann::json parameters = nlohmann::json::array();
    for (const Parameter& p : technique->parameters) {
      nlohmann::json one{{"name", p.name},
                         {"kind", kind_name(p.kind)},
                         {"doc", p.doc},
                         {"unit", p.unit},
                         {"default", p.default_value}};
      if (p.kind == ParameterKind::integer || p.kind == ParameterKind::number) {
        one["minimum"] = p.minimum;
        one["maximum"] = p.maximum;
      }
      if (!p.allowed.empty()) one["allowed"] = p.allowed;
      if (!p.choices.empty()) one["choices"] = p.choices;
      parameters.push_back(one);
    }
    nlohmann::json maps = nlohmann::json::array();
    for (const MapDescription& map : technique->maps)
      maps.push_back({{"name", map.name}, {"title", map.title}, {"unit", map.unit}, {"maximum", map.maximum}});
    list.push_back({{"name", technique->name},
                    {"title", technique->title},
                    {"paper", technique->paper},
                    {"parameters", parameters},
                    {"maps", maps}});
  }
  return list;
}

}  // namespace subpixel::replay
