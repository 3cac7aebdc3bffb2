// `subpixel nightly trend` and `subpixel nightly bisect`: numbers over nights, and which commit moved one.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds them to the verb `nightly`.
void add_trend_verbs(CLI::App& nightly, std::function<int()>& action);

}  // namespace subpixel::cli
