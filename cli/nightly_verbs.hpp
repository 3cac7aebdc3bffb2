// `subpixel nightly` and `baseline`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds the verbs; the one that is chosen sets `action`.
void add_nightly_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
