// A night in words: for a terminal or a wiki, for CI, for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "server/nightly/night.hpp"

namespace subpixel::server {

// The verdict in one line: "night 7 of quick failed: 2 of 40 cells; compared with main (night 3)".
std::string headline(const NightRecord& night);
// The grid, what failed and why, and the times as ratios.
std::string to_markdown(const NightRecord& night);
// One suite for each capture, one case for each cell and gate.
std::string to_junit(const NightRecord& night);
// {id, name, status, ..., captures: [...], cells: [{capture, technique, status, gates, time}]}; without frames.
nlohmann::json to_json(const NightRecord& night);

}  // namespace subpixel::server
