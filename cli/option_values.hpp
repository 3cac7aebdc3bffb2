// Values of options that several verbs take.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <utility>

#include "replay/results/limits.hpp"

namespace subpixel::cli {

// For CLI::Option::transform: a whole number in decimal digits that `limit` holds.
CLI::Validator within(const replay::Limit& limit);

// "0-9" or, for one frame, "3". Throws UsageError; whether the capture has them is for who reads it.
std::pair<std::uint32_t, std::uint32_t> parse_frames(const std::string& text);

// "3:msaa": a frame and the name of a technique. Throws UsageError; whether there are such is for who reads it.
std::pair<std::uint32_t, std::string> parse_frame_of_technique(const std::string& text);

// "12,34": a pixel from the top left corner. Throws UsageError; whether the image has it is for who reads it.
std::pair<std::uint32_t, std::uint32_t> parse_pixel(const std::string& text);

}  // namespace subpixel::cli
