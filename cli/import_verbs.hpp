// import, and import-worker which it runs.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

void add_import_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
