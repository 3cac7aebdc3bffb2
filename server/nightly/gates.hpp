// Judges a night against a baseline. No device, no store: what was measured goes in, a verdict for each cell comes out.
//
// On the same driver, driver version, device and CPU model replays are equal bit for bit, so memory, lighting
// executions, counters and images must be those of the baseline. Elsewhere they may differ by the stated tolerances.
// Error has bounds of its own. Times are compared only as ratios to the msaa and noaa of the same run.
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

// Fills in `status` and `gates` of every cell and appends the cells that only the baseline has, as `missing`. Without a
// baseline only those gates are judged that need none. May be called again with other times.
void judge(NightRecord& tonight, const NightRecord* baseline, const GateOptions& options, const CompareImages& compare);

// The times of `cell` and of the cells of the same capture it is compared with: msaa with 8 samples, else the first
// msaa, and noaa.
CellTime cell_time(const NightCell& cell, const std::vector<NightCell>& of_same_capture);

// True when the time of `tonight` is above `baseline` in all ratios both have, by more than their spreads and the share
// `slower`. `detail` gets the ratios in words.
bool is_slower(const CellTime& tonight, const CellTime& baseline, double slower, std::string& detail);

}  // namespace subpixel::server
