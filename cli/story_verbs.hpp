// The verb that tells what happens in a pixel.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace subpixel::cli {

// Adds the subcommand. Parsing it stores what to run in `action`, which returns the exit code and throws what
// replay::tell_pixel() throws.
void add_story_verbs(CLI::App& app, std::function<int()>& action);

}  // namespace subpixel::cli
