// A night in words: for a terminal or a wiki, for CI, for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "server/nightly/night.hpp"

namespace subpixel::server {

// The verdict in one line: "night 7 of quick failed: 2 of 40 cells; compared with main (night 3)".
std::string headline(const NightRecord& night);
// How quiet the machine was and how often cells were timed; empty for a night without times.
std::string noise_text(const NightRecord& night);
// The grid, what failed and why, and the times as ratios.
std::string to_markdown(const NightRecord& night);
// What failed and what two captures differ in, for a comment on a pull request; `address` of a service that has the
// night, or empty.
std::string to_comment(const NightRecord& night, const std::string& address);
// One suite for each capture, one case for each cell and gate.
std::string to_junit(const NightRecord& night);
// What failed as SARIF 2.1.0, a result for each cell and gate at the first line of `config_file`, so that services that
// show annotations show them there.
nlohmann::json to_sarif(const NightRecord& night, const std::string& config_file);
// {id, name, status, ..., captures: [...], cells: [{capture, technique, status, gates, time}]}; without frames.
nlohmann::json to_json(const NightRecord& night);

}  // namespace subpixel::server
