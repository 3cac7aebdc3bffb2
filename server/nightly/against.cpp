#include "server/nightly/against.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/nightly/trends.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::size_t kListed = 40;  // what changed, by name
constexpr std::size_t kNameBytes = 120;
constexpr std::size_t kMaxDifferenceBytes = std::size_t{256} << 20;

struct Pair {
  NightCell* today;
  const NightCell* yesterday;
};

void list(json& summary, std::uint32_t frame, std::string_view what, const std::string& draw,
          const std::string& details) {
  if (summary["list"].size() >= kListed) {
    summary["unlisted"] = summary.value("unlisted", 0) + 1;
    return;
  }
  summary["list"].push_back(
      {{"frame", frame}, {"what", what}, {"draw", printable(draw, kNameBytes)}, {"details", printable(details, 300)}});
}

void add_to(json& number, std::size_t more) {
  number = number.get<std::size_t>() + more;
}

std::string names_of(const JsonField& fields) {
  std::string names;
  for (std::size_t i = 0; i < fields.array_size(); ++i) {
    const JsonField entry = fields.element(i);
    names += (names.empty() ? "" : ", ") + (entry.raw().is_string() ? entry.text() : entry.member("field").text());
  }
  return names;
}

void add_change(json& summary, std::uint32_t frame, const JsonField& change) {
  std::string details;
  const auto note = [&](const char* group, const char* member) {
    const std::string names = names_of(change.member(member));
    if (names.empty()) return;
    if (*group != '\0') add_to(summary[group]["changed"], 1);
    details += (details.empty() ? "" : "; ") + std::string(member) + ": " + names;
  };
  note("meshes", "mesh");
  note("materials", "material");
  note("textures", "textures");
  if (!change.member("moved").raw().is_null()) {
    add_to(summary["draws"]["moved"], 1);
    details += details.empty() ? "moved" : "; moved";
  }
  if (details.empty()) details = "another name or order";
  list(summary, frame, "changed", change.member("name").text(), details);
}

// By how much `now` is above `before`, as a share; of nothing, everything is more.
double rise(double before, double now) {
  if (now <= before) return before > 0 ? now / before - 1 : 0;
  return before > 0 ? now / before - 1 : 1e9;
}

void add_gate(NightCell& cell, const std::string& name, double before, double now, double allowed) {
  const double more = rise(before, now);
  const std::string share = more > 1e6 ? "from nothing" : fmt::format("{:+.1f}%", 100 * more);
  cell.gates.push_back(
      {"against " + name, more > allowed ? GateOutcome::failed : GateOutcome::passed,
       fmt::format("{:.6g}, yesterday {:.6g} ({}; up to {:+.0f}% is allowed)", now, before, share, 100 * allowed)});
  if (more > allowed) cell.status = CellStatus::failed;
}

double number_of(const std::map<std::string, double>& numbers, const std::string& name) {
  const auto found = numbers.find(name);
  return found == numbers.end() ? std::nan("") : found->second;
}

json number_json(double value) {
  return std::isnan(value) ? json(nullptr) : json(value);
}

json measured(const Pair& pair) {
  const auto before = cell_numbers(*pair.yesterday), now = cell_numbers(*pair.today);
  json numbers = json::object();
  for (const char* name : {"fitted_bytes_per_pixel", "executions", "error.mse", "error.flip_mean", "ms"}) {
    numbers[name] = {{"before", number_json(number_of(before, name))}, {"now", number_json(number_of(now, name))}};
  }
  json frames = json::array();
  for (const NightFrame& frame : pair.today->frames) {
    const auto then = std::ranges::find(pair.yesterday->frames, frame.result.frame,
                                        [](const NightFrame& other) { return other.result.frame; });
    if (then == pair.yesterday->frames.end()) continue;
    const auto image = [](const NightFrame& of) {
      const auto found = of.result.images.find("image");
      return found == of.result.images.end() ? json(nullptr) : json(found->second);
    };
    frames.push_back({{"frame", frame.result.frame},
                      {"yesterday", image(*then)},
                      {"today", image(frame)},
                      {"difference", frame.difference.empty() ? json(nullptr) : json(frame.difference)}});
  }
  return {{"technique", pair.today->technique}, {"numbers", numbers}, {"frames", frames}};
}

void judge_pair(const Pair& pair, const GateOptions& options) {
  const auto before = cell_numbers(*pair.yesterday), now = cell_numbers(*pair.today);
  const auto gate = [&](const char* name, const char* number) {
    const double then = number_of(before, number), tonight = number_of(now, number);
    if (!std::isnan(then) && !std::isnan(tonight)) add_gate(*pair.today, name, then, tonight, options.against.at(name));
  };
  gate("memory", "fitted_bytes_per_pixel");
  gate("executions", "executions");
  gate("error", "error.mse");
}

std::string table_text(std::string_view text) {
  std::string out;
  for (const char c : printable(text, 400)) {
    if (c == '|' || c == '<' || c == '*' || c == '_' || c == '`' || c == '\\' || c == '[') out += '\\';
    out += c;
  }
  return out;
}

std::string change_cells(const json& pair) {
  if (pair.at("before").is_null() || pair.at("now").is_null()) return "";
  const double before = pair.at("before"), now = pair.at("now");
  if (before == now) return fmt::format("{:.4g}", now);
  return fmt::format("{:.4g} to {:.4g}{}", before, now,
                     before != 0 ? fmt::format(" ({:+.1f}%)", 100 * (now / before - 1)) : "");
}

std::string markdown_of(const std::string& capture, const json& summary, const std::string& address) {
  std::string out = fmt::format("\n## {}: today against yesterday\n\n", table_text(capture));
  if (summary.contains("problem")) return out + table_text(summary.at("problem").get<std::string>()) + "\n";
  const json& draws = summary.at("draws");
  out += fmt::format("Capture {} against {}. ", summary.value("today", "").substr(0, 8),
                     summary.value("yesterday", "").substr(0, 8));
  if (summary.at("same").get<bool>()) return out + "The same is drawn.\n";
  out += fmt::format(
      "{} frames; draws {} to {}: {} equal, {} added, {} gone, {} changed, {} of them moved; {} meshes, {} materials "
      "and "
      "{} textures changed.\n",
      summary.value("frames", 0), draws.value("before", 0), draws.value("after", 0), draws.value("equal", 0),
      draws.value("added", 0), draws.value("gone", 0), draws.value("changed", 0), draws.value("moved", 0),
      summary.at("meshes").value("changed", 0), summary.at("materials").value("changed", 0),
      summary.at("textures").value("changed", 0));
  if (summary.contains("techniques") && !summary.at("techniques").empty()) {
    out +=
        "\n| technique | bytes per pixel | lighting executions | MSE | pictures |\n| --- | --- | --- | --- | --- |\n";
    for (const json& technique : summary.at("techniques")) {
      const json& numbers = technique.at("numbers");
      std::string pictures;
      for (const json& frame : technique.at("frames")) {
        if (address.empty() || frame.at("difference").is_null()) continue;
        for (const char* role : {"yesterday", "today", "difference"}) {
          if (frame.at(role).is_null()) continue;
          pictures += fmt::format("[{}]({}/api/blobs/{}) ", role, address, frame.at(role).get<std::string>());
        }
        break;
      }
      out += fmt::format("| {} | {} | {} | {} | {} |\n", table_text(technique.at("technique").get<std::string>()),
                         change_cells(numbers.at("fitted_bytes_per_pixel")), change_cells(numbers.at("executions")),
                         change_cells(numbers.at("error.mse")), pictures);
    }
  }
  if (!summary.at("list").empty()) out += "\n| frame | draw | what | |\n| --- | --- | --- | --- |\n";
  for (const json& entry : summary.at("list")) {
    out += fmt::format("| {} | {} | {} | {} |\n", entry.value("frame", 0), table_text(entry.value("draw", "")),
                       entry.value("what", ""), table_text(entry.value("details", "")));
  }
  if (summary.contains("unlisted")) out += fmt::format("\nAnd {} more.\n", summary.value("unlisted", 0));
  return out;
}

}  // namespace

std::string yesterday_name(std::string_view capture) {
  return std::string(capture) + ", yesterday";
}

json difference_in_worker(const std::filesystem::path& yesterday, const std::filesystem::path& today,
                          const std::filesystem::path& worker, const ChildLimits& limits) {
  ChildLimits own = limits;
  own.confinement.emplace();
  own.confinement->readable = {yesterday.string(), today.string()};
  std::string text;
  const ChildOutcome outcome = run_child({worker.string(), "diff", yesterday.string(), today.string(), "--json"}, own,
                                         {}, [&](std::string_view line) {
                                           text += line;
                                           text += '\n';
                                           return text.size() < kMaxDifferenceBytes;
                                         });
  const bool said = outcome.kind == ChildOutcome::Kind::exited && (outcome.code == 0 || outcome.code == 1);
  if (!said) {
    throw InputError("difference of two captures", outcome.reason.empty() ? "it is too large" : outcome.reason,
                     printable(outcome.error_tail, 300));
  }
  return parse_json_document(text, "difference of two captures", "what the worker said");
}

json against_summary(const json& difference, const std::string& yesterday, const std::string& today) {
  json summary = {
      {"today", today},
      {"yesterday", yesterday},
      {"same", false},
      {"frames", 0},
      {"draws", {{"before", 0}, {"after", 0}, {"equal", 0}, {"added", 0}, {"gone", 0}, {"changed", 0}, {"moved", 0}}},
      {"meshes", {{"changed", 0}}},
      {"materials", {{"changed", 0}}},
      {"textures", {{"changed", 0}}},
      {"list", json::array()}};
  const JsonField top(difference, "difference of two captures");
  summary["same"] = top.member("same").truth();
  const JsonField frames = top.member("frames");
  summary["frames"] = frames.array_size();
  json& draws = summary["draws"];
  for (std::size_t i = 0; i < frames.array_size(); ++i) {
    const JsonField frame = frames.element(i);
    const std::uint32_t number = frame.member("frame").u32();
    add_to(draws["before"], frame.member("draws_a").u32());
    add_to(draws["after"], frame.member("draws_b").u32());
    add_to(draws["equal"], frame.member("equal").u32());
    for (const char* what : {"added", "gone"}) {
      const JsonField some = frame.member(what);
      add_to(draws[what], some.array_size());
      for (std::size_t k = 0; k < some.array_size(); ++k)
        list(summary, number, what, some.element(k).member("name").text(), "");
    }
    const JsonField changed = frame.member("changed");
    add_to(draws["changed"], changed.array_size());
    for (std::size_t k = 0; k < changed.array_size(); ++k) add_change(summary, number, changed.element(k));
  }
  return summary;
}

void judge_against(NightRecord& night, const GateOptions& options) {
  if (!night.facts.contains("against")) return;
  for (auto& [capture, summary] : night.facts["against"].items()) {
    std::vector<Pair> pairs;
    NightCell* first = nullptr;
    for (NightCell& cell : night.cells) {
      if (night.captures.at(cell.capture).name != capture) continue;
      if (first == nullptr) first = &cell;
      for (const NightCell& other : night.cells) {
        if (other.technique == cell.technique && night.captures.at(other.capture).name == yesterday_name(capture) &&
            !cell.frames.empty() && !other.frames.empty())
          pairs.push_back({&cell, &other});
      }
    }
    if (first == nullptr) continue;
    if (summary.contains("problem")) {
      first->gates.push_back({"against draws", GateOutcome::skipped, summary.at("problem").get<std::string>()});
      continue;
    }
    summary["techniques"] = json::array();
    for (const Pair& pair : pairs) {
      if (pair.today->status == CellStatus::new_) pair.today->status = CellStatus::passed;
      judge_pair(pair, options);
      summary["techniques"].push_back(measured(pair));
    }
    const json& draws = summary.at("draws");
    const double before = draws.at("before"), after = draws.at("after");
    add_gate(*first, "draws", before, after, options.against.at("draws"));
    const double materials = summary.at("materials").at("changed");
    add_gate(*first, "materials", before, before + materials, options.against.at("materials"));
    if (pairs.empty()) continue;
    const double triangles_before = number_of(cell_numbers(*pairs.front().yesterday), "counters.triangles");
    const double triangles = number_of(cell_numbers(*pairs.front().today), "counters.triangles");
    if (std::isnan(triangles_before) || std::isnan(triangles)) continue;
    summary["triangles"] = {{"before", triangles_before}, {"after", triangles}};
    add_gate(*first, "triangles", triangles_before, triangles, options.against.at("triangles"));
  }
}

std::string against_markdown(const NightRecord& night, const std::string& address) {
  if (!night.facts.contains("against")) return "";
  std::string out;
  for (const auto& [capture, summary] : night.facts.at("against").items())
    out += markdown_of(capture, summary, address);
  return out;
}

}  // namespace subpixel::server
