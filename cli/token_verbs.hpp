// The verb `token`: who may call a service.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// As add_service_verbs().
void add_token_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
