// Writes a capture as .spcap (SPEC.md). Its counterpart is reader.hpp.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct EncodeOptions {
  int zstd_level = 3;  // 0: payloads are stored as they are
};

// The bytes of the file. The same capture gives the same bytes; compressed ones also depend on the zstd version.
// Buffers and textures of identical bytes are stored once. Throws InputError naming the part that breaks a rule of
// checks.hpp or passes a limit of limits.hpp: what is written can always be read.
std::vector<std::byte> encode_capture(const Capture& capture, const EncodeOptions& options = {});

// Writes the file whole or not at all: into a temporary file beside it, synced, then renamed over `path`. A device or a
// pipe at `path` is written to. Throws InputError when the capture is wrong or the file can't be written (no folder, no
// space, ...).
void write_capture(const Capture& capture, const std::filesystem::path& path, const EncodeOptions& options = {});

}  // namespace subpixel::capture
