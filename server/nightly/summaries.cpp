#include "server/nightly/summaries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/printable.hpp"
#include "server/nightly/against.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

std::string xml(std::string_view text) {
  std::string out;
  for (const char c : printable(text, 4000)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

// A name or message inside of a Markdown table.
std::string cell_text(std::string_view text) {
  std::string out;
  for (const char c : printable(text, 1000)) {
    if (c == '|' || c == '<' || c == '*' || c == '_' || c == '`' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string_view mark(CellStatus status) {
  switch (status) {
    case CellStatus::passed:
      return "ok";
    case CellStatus::failed:
      return "**FAILED**";
    case CellStatus::new_:
      return "new";
    case CellStatus::missing:
      return "**missing**";
    case CellStatus::unjudged:
      break;
  }
  return "?";
}

// Columns in order of first appearance.
std::vector<std::string> techniques_of(const NightRecord& night) {
  std::vector<std::string> techniques;
  for (const NightCell& cell : night.cells) {
    if (std::ranges::find(techniques, cell.technique) == techniques.end()) techniques.push_back(cell.technique);
  }
  return techniques;
}

const NightCell* cell_at(const NightRecord& night, std::size_t capture, const std::string& technique) {
  for (const NightCell& cell : night.cells) {
    if (cell.capture == capture && cell.technique == technique) return &cell;
  }
  return nullptr;
}

json optional_json(const auto& value) {
  return value ? json(*value) : json(nullptr);
}

std::string grid(const NightRecord& night) {
  // Techniques down, captures across: there are many settings of techniques and their names are long.
  std::string out = "| technique |";
  std::string rule = "| --- |";
  for (const NightCapture& capture : night.captures) {
    out += fmt::format(" {} |", cell_text(capture.name));
    rule += " --- |";
  }
  out += fmt::format("\n{}\n", rule);
  for (const std::string& technique : techniques_of(night)) {
    out += fmt::format("| {} |", cell_text(technique));
    for (std::size_t i = 0; i < night.captures.size(); ++i) {
      const NightCell* cell = cell_at(night, i, technique);
      out += fmt::format(" {} |", cell == nullptr ? std::string_view("") : mark(cell->status));
    }
    out += "\n";
  }
  return out;
}

std::string failures(const NightRecord& night) {
  std::string out;
  for (const NightCell& cell : night.cells) {
    for (const GateResult& gate : cell.gates) {
      if (gate.outcome != GateOutcome::failed) continue;
      out += fmt::format("| {} | {} | {} | {} |\n", cell_text(night.captures.at(cell.capture).name),
                         cell_text(cell.technique), gate.gate, cell_text(gate.detail));
    }
  }
  return out.empty() ? out : fmt::format("| capture | technique | gate | why |\n| --- | --- | --- | --- |\n{}", out);
}

}  // namespace

std::string noise_text(const NightRecord& night) {
  if (!night.facts.contains("rounds")) return "";
  std::size_t most = 0, timed = 0;
  bool counted = false;
  for (const NightCell& cell : night.cells) {
    most = std::max(most, cell.time.rounds.size());
    timed += cell.time.rounds.empty() ? 0 : 1;
    counted = counted || cell.time.instructions > 0;
  }
  std::string out = fmt::format("Times ({}): ", night.facts.value("measure", "device time"));
  if (night.facts.contains("noise")) {
    out += fmt::format("from round to round the ratio of msaa to noaa varied by {:.1f}%, load {:.1f}; ",
                       100 * night.facts.value("noise", 0.0), night.facts.value("load", 0.0));
  }
  out += fmt::format("{} cells in {} rounds", timed, night.facts.value("rounds", 0));
  if (const auto again = night.facts.value("measured_again", 0); again > 0)
    out += fmt::format(", {} of them in {}", again, most);
  return out + (counted ? ". Instructions were counted." : ". Instructions: not counted on this machine.");
}

std::string headline(const NightRecord& night) {
  const CellCounts counts = count_cells(night);
  const std::size_t bad = counts.failed + counts.missing;
  std::string words = fmt::format("night {} of {} {}: ", night.id, night.name, to_text(night.status));
  words += bad > 0 ? fmt::format("{} of {} cells failed", bad, night.cells.size())
                   : fmt::format("{} cells", night.cells.size());
  if (counts.new_ > 0) words += fmt::format(", {} new", counts.new_);
  if (night.baseline_night) {
    return words + fmt::format("; compared with {} (night {})", night.baseline.value_or(""), *night.baseline_night);
  }
  return words + fmt::format("; nothing is approved as {} yet", night.baseline.value_or("a baseline"));
}

std::string to_markdown(const NightRecord& night) {
  std::string out = fmt::format("# {}\n\n", cell_text(headline(night)));
  out += fmt::format("{} to {} UTC, build {}{}.", night.started_utc, night.finished_utc, night.build,
                     night.commit.empty() ? "" : " of commit " + cell_text(night.commit));
  if (!night.reason.empty()) out += fmt::format(" {}", cell_text(night.reason));
  for (const NightCapture& capture : night.captures) {
    if (!capture.head) continue;
    out += fmt::format(" {}, {}.", cell_text(capture.head->driver_version), cell_text(capture.head->cpu_model));
    break;
  }
  out += fmt::format("\n\n{}", grid(night));
  const std::string times = noise_text(night);
  if (!times.empty()) out += fmt::format("\n{}\n", times);
  const std::string why = failures(night);
  if (!why.empty()) out += fmt::format("\n{}", why);
  return out + against_markdown(night, "");
}

std::string to_comment(const NightRecord& night, const std::string& address) {
  std::string out = fmt::format("**{}**\n", cell_text(headline(night)));
  if (!address.empty()) out += fmt::format("\n{}/#/nights/{}\n", address, night.id);
  const std::string why = failures(night);
  if (!why.empty()) out += fmt::format("\n{}", why);
  return out + against_markdown(night, address);
}

std::string to_junit(const NightRecord& night) {
  std::size_t tests = 0, failed = 0, skipped = 0;
  std::string suites;
  for (std::size_t i = 0; i < night.captures.size(); ++i) {
    std::size_t suite_tests = 0, suite_failed = 0, suite_skipped = 0;
    std::string cases;
    for (const NightCell& cell : night.cells) {
      if (cell.capture != i) continue;
      for (const GateResult& gate : cell.gates) {
        ++suite_tests;
        cases += fmt::format("    <testcase classname=\"{}\" name=\"{} {}\"", xml(night.captures[i].name),
                             xml(cell.technique), xml(gate.gate));
        if (gate.outcome == GateOutcome::failed) {
          ++suite_failed;
          cases += fmt::format("><failure message=\"{}\"/></testcase>\n", xml(gate.detail));
        } else if (gate.outcome == GateOutcome::skipped) {
          ++suite_skipped;
          cases += fmt::format("><skipped message=\"{}\"/></testcase>\n", xml(gate.detail));
        } else {
          cases += "/>\n";
        }
      }
    }
    suites += fmt::format("  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" skipped=\"{}\" timestamp=\"{}\">\n{}",
                          xml(night.captures[i].name), suite_tests, suite_failed, suite_skipped,
                          night.started_utc.substr(0, 19), cases);
    suites += "  </testsuite>\n";
    tests += suite_tests;
    failed += suite_failed;
    skipped += suite_skipped;
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"subpixel nightly {}\" tests=\"{}\" "
      "failures=\"{}\" skipped=\"{}\">\n{}</testsuites>\n",
      xml(night.name), tests, failed, skipped, suites);
}

json to_sarif(const NightRecord& night, const std::string& config_file) {
  json results = json::array(), rules = json::array();
  std::vector<std::string> known;
  for (const NightCell& cell : night.cells) {
    const std::string& capture = night.captures.at(cell.capture).name;
    for (const GateResult& gate : cell.gates) {
      if (gate.outcome != GateOutcome::failed) continue;
      if (std::ranges::find(known, gate.gate) == known.end()) {
        known.push_back(gate.gate);
        rules.push_back({{"id", gate.gate}, {"shortDescription", {{"text", "nightly gate " + gate.gate}}}});
      }
      const json place = {{"artifactLocation", {{"uri", config_file}}}, {"region", {{"startLine", 1}}}};
      results.push_back(
          {{"ruleId", gate.gate},
           {"level", "error"},
           {"message", {{"text", printable(fmt::format("{}, {}: {}", capture, cell.technique, gate.detail), 1000)}}},
           {"locations",
            {{{"physicalLocation", place},
              {"logicalLocations", {{{"fullyQualifiedName", printable(capture + "/" + cell.technique, 300)}}}}}}}});
    }
  }
  return {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
          {"version", "2.1.0"},
          {"runs",
           {{{"tool", {{"driver", {{"name", "subpixel nightly"}, {"version", night.build}, {"rules", rules}}}}},
             {"results", results}}}}};
}

json to_json(const NightRecord& night) {
  const CellCounts counts = count_cells(night);
  json captures = json::array();
  for (const NightCapture& capture : night.captures) {
    captures.push_back({{"name", capture.name},
                        {"source", capture.source},
                        {"hash", capture.hash},
                        {"problem", capture.problem},
                        {"head", capture.head ? replay::to_json(*capture.head) : json(nullptr)}});
  }
  json cells = json::array();
  for (const NightCell& cell : night.cells) {
    cells.push_back({{"id", cell.id},
                     {"capture", night.captures.at(cell.capture).name},
                     {"technique", cell.technique},
                     {"status", to_text(cell.status)},
                     {"gates", to_json(cell.gates)},
                     {"time", to_json(cell.time)}});
  }
  return {{"id", night.id},
          {"name", night.name},
          {"status", to_text(night.status)},
          {"reason", night.reason},
          {"started_utc", night.started_utc},
          {"finished_utc", night.finished_utc.empty() ? json(nullptr) : json(night.finished_utc)},
          {"build", night.build},
          {"commit", night.commit},
          {"facts", night.facts},
          {"times", noise_text(night)},
          {"baseline", optional_json(night.baseline)},
          {"baseline_night", optional_json(night.baseline_night)},
          {"counts",
           {{"passed", counts.passed}, {"failed", counts.failed}, {"new", counts.new_}, {"missing", counts.missing}}},
          {"captures", captures},
          {"cells", cells}};
}

}  // namespace subpixel::server
