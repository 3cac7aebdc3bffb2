// Two captures of one night: today's of a tag against yesterday's, the one stored before it. Frames are matched by
// number and draws by what they draw (capture_format/tools/difference.hpp), which a worker process of `subpixel diff`
// says; what was measured is compared cell by cell.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "process/child_process.hpp"
#include "server/nightly/config.hpp"
#include "server/nightly/gates.hpp"
#include "server/nightly/night.hpp"
#include "server/nightly/planned_capture.hpp"

namespace subpixel::server {

// The name of yesterday's capture beside today's of the name `capture`.
std::string yesterday_name(std::string_view capture);

// What `subpixel diff --json` says, summed over the frames that both have, and the first of what was added, is gone or
// changed by name: {today, yesterday, same, frames, draws: {before, after, equal, added, gone, changed, moved},
// materials: {changed}, textures: {changed}, meshes: {changed}, triangles: null, list: [{frame, what, draw, details}]}.
// `today` and `yesterday` are the captures' hashes. Throws InputError when `difference` is not of that form.
nlohmann::json against_summary(const nlohmann::json& difference, const std::string& yesterday,
                               const std::string& today);

// What `worker diff YESTERDAY TODAY --json` says of two captures, which are anybody's: in a confined process of its
// own. Throws InputError when it can't say anything.
nlohmann::json difference_in_worker(const std::filesystem::path& yesterday, const std::filesystem::path& today,
                                    const std::filesystem::path& worker, const ChildLimits& limits);

// Puts into night.facts["against"], which has a member for each such capture of the night, their summaries or why there
// is none, and stores by `compare` how the pictures of both days differ. `say` takes one line for people.
void compare_days(NightRecord& night, const std::vector<PlannedCapture>& planned, const std::filesystem::path& worker,
                  const ChildLimits& limits, const CompareImages& compare,
                  const std::function<void(const std::string& line)>& say);

// Adds the gates "against ..." to the cells of every capture that night.facts["against"] has a summary of: draws,
// triangles and materials to the first, memory, executions and error to each, and to the summary what was measured of
// both (`triangles`, `techniques`). Call it after judge().
void judge_against(NightRecord& night, const GateOptions& options);

// The summaries of a night as Markdown, for a wiki or a pull request; empty when there are none. `address` is the
// service that has the night: with it, pictures are linked.
std::string against_markdown(const NightRecord& night, const std::string& address);

}  // namespace subpixel::server
