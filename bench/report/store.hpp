// The runs of a plan on disk: one results file each, as `subpixel replay --json` writes them, so that `subpixel advise`
// reads them too.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/report/measured.hpp"

namespace subpixel::report {

struct MeasureOptions {
  std::filesystem::path folder;       // results, captures, references
  std::filesystem::path source_root;  // where the park's description is
  bool fresh = false;                 // measures again what is stored
  std::optional<bool> timed = {};     // only runs of several repeats, or only those whose times nobody reads
  std::function<void(const std::string& line)> progress;
};

// Replays every run of the plan and stores it when it is whole. Where a call before this one was broken off, the runs
// it stored stay; where it wasn't, all are measured anew and the old files go to `previous/`. A run is never put
// together from two calls, since its times are ratios. A scene whose models are not installed is left out and said.
// Throws what replay and import throw.
void measure(const std::vector<RunPlan>& plan, const MeasureOptions& options);

// Whether times of the run are read: errors and counts may be measured on a busy machine.
bool is_timed(const RunPlan& run);

// What is stored of the plan. Throws InputError for a damaged file.
Measured read_measured(const std::vector<RunPlan>& plan, const std::filesystem::path& folder);

// Copies what is stored of the plan to `to`, where nothing else of that kind stays: the numbers behind a page, to lie
// beside it. Nothing when `to` is `folder`.
void publish(const std::vector<RunPlan>& plan, const std::filesystem::path& folder, const std::filesystem::path& to);

// Whether stored results are those that the plan asks for.
bool answers(const replay::Results& results, const RunPlan& plan);

}  // namespace subpixel::report
