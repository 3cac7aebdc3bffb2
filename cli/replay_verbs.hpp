// The verbs `techniques`, `replay` and `worker`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds the subcommands. Parsing one stores what to run in `action`, which returns the exit code and throws UsageError,
// InputError or DeviceError.
void add_replay_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
