// The verbs `generate`, `info`, `validate` and `repair`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds the subcommands. Parsing one stores what to run in `action`, which returns the exit code and throws UsageError
// or InputError.
void add_capture_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
