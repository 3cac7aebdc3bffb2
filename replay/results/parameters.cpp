#include "replay/results/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "base/error.hpp"
#include "base/numbers.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

// A sweep is a product of its ranges; more than this is a mistyped range, not a study.
constexpr std::size_t max_requests = 1024;

json parse_scalar(std::string_view text) {
  if (text == "true") return true;
  if (text == "false") return false;
  if (const auto integer = parse_number<std::int64_t>(text)) return *integer;
  if (const auto number = parse_number<double>(text); number && std::isfinite(*number)) return *number;
  return std::string(text);
}

std::string as_text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

template <class Range, class Name>
std::string joined(const Range& range, Name name) {
  std::string out;
  for (const auto& element : range) out += (out.empty() ? "" : ", ") + std::string(name(element));
  return out.empty() ? "none" : out;
}

// The checker of one value: `fail` words the refusal the same way for every kind.
struct Check {
  std::string_view technique;
  const Parameter& declared;
  const json& given;

  [[noreturn]] void fail(const std::string& expected) const {
    throw UsageError(fmt::format("technique {}", technique),
                     fmt::format("{} = {} is not {}", declared.name, as_text(given), expected),
                     fmt::format("parameter {}", declared.name));
  }

  json numeric() const {
    const json value = given.is_string() ? parse_scalar(given.get<std::string>()) : given;
    if (!value.is_number()) fail(declared.kind == ParameterKind::integer ? "a whole number" : "a number");
    const double number = value.get<double>();
    if (!(number >= declared.minimum && number <= declared.maximum)) {
      fail(fmt::format("in {} to {}", declared.minimum, declared.maximum));
    }
    if (declared.kind == ParameterKind::number) return number;
    if (number != std::floor(number)) fail("a whole number");
    if (!declared.allowed.empty() && std::ranges::find(declared.allowed, number) == declared.allowed.end()) {
      fail("one of " + joined(declared.allowed, [](double allowed) { return fmt::format("{}", allowed); }));
    }
    return static_cast<std::int64_t>(number);
  }

  json choice() const {
    const std::string text = as_text(given);
    if (std::ranges::find(declared.choices, text) == declared.choices.end()) {
      fail("one of " + joined(declared.choices, [](std::string_view name) { return name; }));
    }
    return text;
  }

  json boolean() const {
    const std::string text = as_text(given);
    if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
    if (text == "false" || text == "off" || text == "no" || text == "0") return false;
    fail("true or false");
  }
};

// The values a written value stands for: "1..4" is 1, 2, 3, 4 and "4|8" is 4, 8; anything else is itself.
std::vector<json> expand_value(std::string_view text) {
  if (const std::size_t dots = text.find(".."); dots != std::string_view::npos) {
    const auto first = parse_number<std::int64_t>(text.substr(0, dots));
    const auto last = parse_number<std::int64_t>(text.substr(dots + 2));
    const auto limit = static_cast<std::int64_t>(max_requests);
    if (!first || !last || *first > *last || *first < -limit || *last > limit) return {};
    std::vector<json> values;
    for (std::int64_t value = *first; value <= *last; ++value) values.emplace_back(value);
    return values;
  }
  std::vector<json> values;
  while (true) {
    const std::size_t bar = text.find('|');
    const std::string_view part = text.substr(0, bar);
    if (part.empty()) return {};
    values.push_back(parse_scalar(part));
    if (bar == std::string_view::npos) return values;
    text.remove_prefix(bar + 1);
  }
}

// `text` is one request and `position` where it starts in the list. Returns one request for each point of its sweep.
std::vector<TechniqueRequest> parse_request(std::string_view text, std::size_t position) {
  const auto fail = [](const std::string& why, std::size_t at) -> void {
    throw UsageError("technique list", why, fmt::format("character {}", at + 1));
  };
  std::vector<TechniqueRequest> requests(1);
  std::size_t part_start = 0;
  for (bool name_part = true; part_start <= text.size(); name_part = false) {
    const std::size_t colon = std::min(text.find(':', part_start), text.size());
    const std::string_view part = text.substr(part_start, colon - part_start);
    const std::size_t at = position + part_start;
    part_start = colon + 1;
    if (name_part) {
      if (part.empty()) fail("a technique name is missing", at);
      if (const std::size_t equals = part.find('='); equals != std::string_view::npos) {
        fail("a technique name comes first, then :parameter=value", at + equals);
      }
      requests.front().technique = part;
      continue;
    }
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || equals == 0) fail("expected parameter=value after ':'", at);
    const std::string name(part.substr(0, equals));
    const std::size_t value_at = at + equals + 1;
    if (requests.front().parameters.contains(name)) fail(fmt::format("parameter {} is given twice", name), at);
    const std::vector<json> values = expand_value(part.substr(equals + 1));
    if (values.empty()) fail(fmt::format("parameter {} needs a value, first..last or a|b|c", name), value_at);
    if (values.size() * requests.size() > max_requests) {
      fail(fmt::format("the sweep has more than {} points", max_requests), value_at);
    }
    std::vector<TechniqueRequest> expanded;
    for (const TechniqueRequest& request : requests) {
      for (const json& value : values) {
        expanded.push_back(request);
        expanded.back().parameters[name] = value;
      }
    }
    requests = std::move(expanded);
  }
  return requests;
}

}  // namespace

ParameterValues check_parameters(std::string_view technique, const Parameters& declared, const ParameterValues& given) {
  for (const auto& [name, value] : given) {
    const bool known = std::ranges::any_of(
        declared, [&given_name = name](const Parameter& parameter) { return parameter.name == given_name; });
    if (!known) {
      throw UsageError(fmt::format("technique {}", technique),
                       fmt::format("unknown parameter {} (valid: {})", name,
                                   joined(declared, [](const Parameter& parameter) { return parameter.name; })),
                       fmt::format("parameter {}", name));
    }
  }
  ParameterValues checked;
  for (const Parameter& parameter : declared) {
    const std::string name(parameter.name);
    const auto found = given.find(name);
    if (found == given.end()) {
      checked[name] = parameter.default_value;
      continue;
    }
    const Check check{technique, parameter, found->second};
    switch (parameter.kind) {
      case ParameterKind::integer:
      case ParameterKind::number:
        checked[name] = check.numeric();
        break;
      case ParameterKind::choice:
        checked[name] = check.choice();
        break;
      case ParameterKind::boolean:
        checked[name] = check.boolean();
        break;
    }
  }
  return checked;
}

std::vector<TechniqueRequest> parse_technique_list(std::string_view text) {
  std::vector<TechniqueRequest> requests;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    for (TechniqueRequest& request : parse_request(text.substr(start, comma - start), start)) {
      requests.push_back(std::move(request));
    }
    if (requests.size() > max_requests) {
      throw UsageError("technique list", fmt::format("more than {} requests", max_requests),
                       fmt::format("character {}", start + 1));
    }
    start = comma + 1;
  }
  return requests;
}

}  // namespace subpixel::replay
