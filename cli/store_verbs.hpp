// The verb `store`: upkeep of a data folder.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// As add_service_verbs().
void add_store_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
