// Reads .spcap (SPEC.md) from anywhere: nothing in the file is believed before it is checked.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "capture_format/capture.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {

// The capture in `bytes`. What is returned obeys every rule of checks.hpp, index values included, so all offsets,
// counts and references in it can be used unchecked. Throws InputError naming byte offset, chunk and field of the
// first thing wrong: a foreign file, another version, a truncation, extra bytes, a flipped bit, a broken rule, a limit.
// Strips and fans have become triangle lists; chunks of kinds that a later minor version may add are named in a notice.
Capture decode_capture(std::span<const std::byte> bytes, const ReadLimits& limits = {});

// The same of a file; errors also name the path.
Capture read_capture(const std::filesystem::path& path, const ReadLimits& limits = {});

// What is whole of a capture whose end is missing or damaged, as a crash while recording leaves it.
struct Recovered {
  Capture capture;      // obeys the same rules; its frames are the first ones of what was recorded
  std::string stopped;  // what ended the reading; empty when all chunks were whole
};

// Throws InputError when not even the metadata can be read.
Recovered recover_capture(std::span<const std::byte> bytes, const ReadLimits& limits = {});
Recovered recover_capture(const std::filesystem::path& path, const ReadLimits& limits = {});

}  // namespace subpixel::capture
