// Today's capture of a tag against yesterday's: what the night does before it judges them (against.cpp).
#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "server/nightly/against.hpp"

namespace subpixel::server {
namespace {

// Stores the difference of the pictures that both have.
void compare_frames(NightCell& today, const NightCell& yesterday, const CompareImages& compare) {
  for (NightFrame& frame : today.frames) {
    const auto then = std::ranges::find(yesterday.frames, frame.result.frame,
                                        [](const NightFrame& other) { return other.result.frame; });
    if (then == yesterday.frames.end()) continue;
    const auto before = then->result.images.find("image");
    const auto now = frame.result.images.find("image");
    if (before == then->result.images.end() || now == frame.result.images.end() || before->second == now->second)
      continue;
    compare(frame, before->second);
  }
}

}  // namespace

void compare_days(NightRecord& night, const std::vector<PlannedCapture>& planned, const std::filesystem::path& worker,
                  const ChildLimits& limits, const CompareImages& compare,
                  const std::function<void(const std::string& line)>& say) {
  if (!night.facts.contains("against")) return;
  for (auto& [name, summary] : night.facts["against"].items()) {
    if (summary.contains("problem")) continue;
    const auto of_name = [&](const std::string& wanted) {
      return std::ranges::find(planned, wanted, [](const PlannedCapture& one) { return one.capture.name; });
    };
    const auto today = of_name(name), yesterday = of_name(yesterday_name(name));
    say(fmt::format("{}: today's draws against yesterday's", name));
    try {
      summary = against_summary(difference_in_worker(yesterday->path, today->path, worker, limits),
                                yesterday->capture.hash, today->capture.hash);
    } catch (const Error& error) {
      summary["problem"] = error.what();
      continue;
    }
    for (NightCell& cell : night.cells) {
      if (night.captures.at(cell.capture).name != name) continue;
      for (const NightCell& other : night.cells) {
        if (other.technique != cell.technique || night.captures.at(other.capture).name != yesterday_name(name))
          continue;
        compare_frames(cell, other, compare);
      }
    }
  }
}

}  // namespace subpixel::server
