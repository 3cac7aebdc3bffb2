#include "server/nightly/night.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/error.hpp"
#include "base/json_fields.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 3> kOutcomes{"passed", "failed", "skipped"};
constexpr std::array<std::string_view, 5> kCellStatuses{"unjudged", "passed", "failed", "new", "missing"};
constexpr std::array<std::string_view, 4> kNightStatuses{"running", "passed", "failed", "interrupted"};

template <typename Enum, std::size_t N>
Enum from_text(const std::array<std::string_view, N>& names, std::string_view text) {
  for (std::size_t i = 0; i < N; ++i) {
    if (names[i] == text) return static_cast<Enum>(i);
  }
  throw InputError("can't read the store", fmt::format("unknown value {}", text), "nights");
}

json span_json(const TimeSpan& span) {
  return {{"ms", span.ms}, {"spread", span.spread_ms}};
}

TimeSpan span_from_field(const JsonField& field) {
  return {field.member("ms").number(), field.member("spread").number()};
}

}  // namespace

std::string_view to_text(GateOutcome outcome) {
  return kOutcomes[static_cast<std::size_t>(outcome)];
}
std::string_view to_text(CellStatus status) {
  return kCellStatuses[static_cast<std::size_t>(status)];
}
std::string_view to_text(NightStatus status) {
  return kNightStatuses[static_cast<std::size_t>(status)];
}
CellStatus cell_status_from_text(std::string_view text) {
  return from_text<CellStatus>(kCellStatuses, text);
}
NightStatus night_status_from_text(std::string_view text) {
  return from_text<NightStatus>(kNightStatuses, text);
}

CellCounts count_cells(const NightRecord& night) {
  CellCounts counts;
  for (const NightCell& cell : night.cells) {
    counts.passed += cell.status == CellStatus::passed ? 1 : 0;
    counts.failed += cell.status == CellStatus::failed ? 1 : 0;
    counts.new_ += cell.status == CellStatus::new_ ? 1 : 0;
    counts.missing += cell.status == CellStatus::missing ? 1 : 0;
  }
  return counts;
}

std::string technique_key(const std::string& technique, const replay::ParameterValues& parameters) {
  const replay::Technique& declared = replay::find_technique(technique);
  std::string key = technique;
  for (const replay::Parameter& parameter : declared.parameters) {
    const auto given = parameters.find(std::string(parameter.name));
    if (given == parameters.end()) continue;
    const bool shown =
        parameter.name == "samples" ? parameter.allowed.size() != 1 : given->second != parameter.default_value;
    if (!shown) continue;
    const json& value = given->second;
    key += fmt::format(":{}={}", parameter.name, value.is_string() ? value.get<std::string>() : value.dump());
  }
  return key;
}

json to_json(const CellTime& time) {
  json references = json::object();
  for (const auto& [technique, span] : time.references) references[technique] = span_json(span);
  json document = span_json(time.own);
  document["references"] = references;
  document["instructions"] = time.instructions;
  json rounds = json::array();
  for (const TimeRound& round : time.rounds) {
    json others = json::object();
    for (const auto& [technique, ms] : round.references) others[technique] = ms;
    rounds.push_back({{"ms", round.own}, {"references", others}});
  }
  document["rounds"] = rounds;
  return document;
}

CellTime cell_time_from_json(const json& document) {
  const JsonField field(document, "night cell");
  CellTime time;
  time.own = span_from_field(field);
  const JsonField references = field.member("references");
  for (const auto& item : references.object().items()) {
    time.references[item.key()] = span_from_field(references.member(item.key()));
  }
  if (field.has("instructions")) time.instructions = field.member("instructions").number();
  if (!field.has("rounds")) return time;  // of a store before version 5
  const JsonField rounds = field.member("rounds");
  for (std::size_t i = 0; i < rounds.array_size(); ++i) {
    const JsonField round = rounds.element(i);
    TimeRound one{round.member("ms").number(), {}};
    const JsonField others = round.member("references");
    for (const auto& item : others.object().items()) one.references[item.key()] = others.member(item.key()).number();
    time.rounds.push_back(std::move(one));
  }
  return time;
}

json to_json(const std::vector<GateResult>& gates) {
  json list = json::array();
  for (const GateResult& gate : gates) {
    list.push_back({{"gate", gate.gate}, {"outcome", to_text(gate.outcome)}, {"detail", gate.detail}});
  }
  return list;
}

std::vector<GateResult> gates_from_json(const json& document) {
  const JsonField list(document, "night cell");
  std::vector<GateResult> gates;
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    const JsonField gate = list.element(i);
    gates.push_back({gate.member("gate").text(), from_text<GateOutcome>(kOutcomes, gate.member("outcome").text()),
                     gate.member("detail").text()});
  }
  return gates;
}

}  // namespace subpixel::server
