// Which commit moved a number of a cell: git bisect over the commits between two nights, each built by a command of the
// user's and replayed as the night was.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/nightly/run_night.hpp"
#include "server/nightly/trends.hpp"

namespace subpixel::server {

struct BisectRequest {
  NightRecord night;  // with configuration and facts: what is replayed
  std::string capture, technique, number;
  double from = 0, to = 0;                 // the number at `good` and at `bad`; a commit has the one that is nearer
  std::string good, bad;                   // commits
  std::filesystem::path repository, data;  // `data`: the folder of the night's captures
  // A shell command, run in a check-out of the commit that takes the place of {commit}. The last line that it prints is
  // the path of the program `subpixel` of that commit, or of a folder of shaders (SUBPIXEL_SHADERS) for this program.
  std::string command;
};

struct BisectStep {
  std::string commit;
  std::optional<double> value;  // absent: it could not be built or replayed
  std::string verdict;          // "good", "bad", "skip" or why it was skipped
};

struct BisectResult {
  std::string first_bad;  // empty when skipped commits hide it
  std::string subject;    // its first line
  std::vector<BisectStep> steps;
};

// Works in clones under `folder`, which is made. The repository is read only. Throws InputError for commits that the
// repository does not have.
BisectResult bisect(const BisectRequest& request, const std::filesystem::path& folder, const NightOptions& options);

}  // namespace subpixel::server
