// Typed parameters of a technique: declaration, checking, defaults. Help texts, HTTP and web forms derive from these.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "replay/results/results.hpp"

namespace subpixel::replay {

enum class ParameterKind { integer, number, choice, boolean };

struct Parameter {
  std::string_view name;
  ParameterKind kind = ParameterKind::integer;
  std::string_view doc;                   // one line
  std::string_view unit;                  // "", "samples", "radians", ...
  double minimum = 0, maximum = 0;        // integer and number, inclusive
  std::vector<double> allowed;            // integer: when only these values are allowed (empty: the whole range)
  std::vector<std::string_view> choices;  // choice
  nlohmann::json default_value;
};

using Parameters = std::vector<Parameter>;

// `given` (text or JSON scalars by name) checked against `declared`, with defaults filled in.
// Throws UsageError naming the valid parameters, the range or the choices.
ParameterValues check_parameters(std::string_view technique, const Parameters& declared, const ParameterValues& given);

// One "technique:param=v:param=v" request, the unit of `--techniques a,b:param=v`.
struct TechniqueRequest {
  std::string technique;
  ParameterValues parameters;  // as given, unchecked: values are JSON scalars (numbers where they parse as such)
};

// Parses the comma-separated list of the command line. Throws UsageError naming the position.
std::vector<TechniqueRequest> parse_technique_list(std::string_view text);

}  // namespace subpixel::replay
