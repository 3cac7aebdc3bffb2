// Reads .spcap (SPEC.md) from anywhere: nothing in the file is believed before it is checked.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "capture_format/capture.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {

// The capture in `bytes`. What is returned obeys every rule of checks.hpp, index values included, so all offsets,
// counts and references in it can be used unchecked. Throws InputError naming byte offset, chunk and field of the
// first thing wrong: a foreign file, another version, a truncation, extra bytes, a flipped bit, a broken rule, a limit.
Capture decode_capture(std::span<const std::byte> bytes, const ReadLimits& limits = {});

// The same of a file; errors also name the path.
Capture read_capture(const std::filesystem::path& path, const ReadLimits& limits = {});

}  // namespace subpixel::capture
