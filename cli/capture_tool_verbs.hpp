// trim and diff.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds the verbs to `app`; the one on the command line sets `action`.
void add_capture_tool_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
