// A night: captures by techniques, what was measured, and how it was judged against a baseline. The store, the gates,
// the summaries and the page all read this form.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "replay/results/results.hpp"

namespace subpixel::server {

enum class GateOutcome { passed, failed, skipped };
std::string_view to_text(GateOutcome outcome);

struct GateResult {
  std::string gate;  // "memory", "images", "error mse", ...
  GateOutcome outcome = GateOutcome::passed;
  std::string detail;  // what was compared; for `skipped` why it was not
};

// Milliseconds of one technique over all frames of a capture: the sum of the totals and the sum of the spreads.
struct TimeSpan {
  double ms = 0, spread_ms = 0;
};

// One measurement of a capture by all techniques in turn, as one of them sees it: its ms over all frames, and those of
// the techniques that it is compared with.
struct TimeRound {
  double own = 0;
  std::map<std::string, double> references;
};

// A technique's time and, by technique, those of the same run that it is compared with. Only the ratios mean anything
// on another day.
struct CellTime {
  TimeSpan own;
  std::map<std::string, TimeSpan> references;
  std::vector<TimeRound> rounds;  // measured for the test of time_test.hpp
  double instructions = 0;        // over all frames, in user space; 0: the machine does not count them
};

// new_: measured, but not in the baseline. missing: in the baseline, but not measured.
enum class CellStatus { unjudged, passed, failed, new_, missing };
std::string_view to_text(CellStatus status);
CellStatus cell_status_from_text(std::string_view text);

struct NightFrame {
  std::int64_t id = 0;         // of the store
  replay::FrameResult result;  // images by content hash
  std::string difference;      // blob of the difference to the baseline's image; empty when there is none
};

struct NightCell {
  std::int64_t id = 0;
  std::uint32_t capture = 0;  // index into the night's captures
  std::string technique;      // "streaming:samples=8:surfaces=3"
  CellStatus status = CellStatus::unjudged;
  std::vector<GateResult> gates;
  CellTime time;
  std::vector<NightFrame> frames;
};

struct NightCapture {
  std::string name, source, hash, problem;
  std::optional<replay::ResultsHead> head;
};

enum class NightStatus { running, passed, failed, interrupted };
std::string_view to_text(NightStatus status);
NightStatus night_status_from_text(std::string_view text);

struct NightRecord {
  std::int64_t id = 0;
  std::string name;
  NightStatus status = NightStatus::running;
  std::string reason;
  std::string started_utc, finished_utc;
  std::string build;
  std::string commit;                               // of what was measured; empty: not known
  nlohmann::json facts = nlohmann::json::object();  // of the machine that night: noise, load, rounds
  nlohmann::json config;
  std::optional<std::string> baseline;         // name
  std::optional<std::int64_t> baseline_night;  // none: nothing was approved under that name
  std::vector<NightCapture> captures;
  std::vector<NightCell> cells;
};

struct CellCounts {
  std::uint32_t passed = 0, failed = 0, new_ = 0, missing = 0;
};
CellCounts count_cells(const NightRecord& night);

// The name of a cell's technique: with `samples` where there is a choice of them and the parameters that are not the
// registry's default, in the command line's syntax. A new parameter with a default does not change it.
std::string technique_key(const std::string& technique, const replay::ParameterValues& parameters);

nlohmann::json to_json(const CellTime& time);
CellTime cell_time_from_json(const nlohmann::json& document);
nlohmann::json to_json(const std::vector<GateResult>& gates);
std::vector<GateResult> gates_from_json(const nlohmann::json& document);

}  // namespace subpixel::server
