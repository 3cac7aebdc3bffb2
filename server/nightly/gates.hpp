// Judges a night against a baseline. No device, no store: what was measured goes in, a verdict for each cell comes out.
//
// On the same driver, driver version, device and CPU model replays are equal bit for bit, so memory, lighting
// executions, counters and images must be those of the baseline. Elsewhere they may differ by the stated tolerances.
// Error has bounds of its own. Times are compared only as ratios to the msaa and noaa of the same round
// (time_test.hpp).
#pragma once

#include <functional>
#include <optional>

#include "server/nightly/config.hpp"
#include "server/nightly/night.hpp"

namespace subpixel::server {

struct ImageDifference {
  double mse = 0;
  double largest = 0;        // of any channel, of 0..1
  std::uint64_t pixels = 0;  // that differ
};

// How the image of `tonight` differs from the baseline's, named by its hash; nothing when they can't be compared.
using CompareImages = std::function<std::optional<ImageDifference>(NightFrame& tonight, const std::string& baseline)>;

// Rounds of nights after the baseline that passed, by capture and technique.
using EarlierRounds = std::map<std::pair<std::string, std::string>, std::vector<TimeRound>>;

// Fills in `status` and `gates` of every cell and appends the cells that only the baseline has, as `missing`. Without a
// baseline only those gates are judged that need none. May be called again with other times.
void judge(NightRecord& tonight, const NightRecord* baseline, const GateOptions& options, const CompareImages& compare,
           const EarlierRounds& earlier = {});

// What `nights` add to the rounds of `baseline`: of those that were compared with it, the cells whose time passed, of
// the same capture, size and machine as the baseline's.
EarlierRounds earlier_rounds(const NightRecord& baseline, const std::vector<NightRecord>& nights);

// What decides whether two replays are equal bit for bit: driver, its version, device and CPU model, in words.
std::string machine_text(const replay::ResultsHead& head);

// The times of `cell` and of the cells of the same capture it is compared with: msaa with 8 samples, else the first
// msaa, and noaa.
CellTime cell_time(const NightCell& cell, const std::vector<NightCell>& of_same_capture);

}  // namespace subpixel::server
