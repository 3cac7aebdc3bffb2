// The chunks of a .spcap file in the order they come, then its index and footer (SPEC.md). Private to what writes
// files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "capture_format/chunk.hpp"
#include "capture_format/record_writer.hpp"

namespace subpixel::capture {

// Takes the next bytes of the file.
using ByteSink = std::function<void(std::span<const std::byte>)>;

class ChunkWriter {
 public:
  // zstd_level 0 stores payloads as they are. The file header goes to `sink` at once.
  ChunkWriter(std::uint32_t version, int zstd_level, ByteSink sink);

  // Returns the offset of the chunk in the file.
  std::uint64_t chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload);

  void finish();

 private:
  void put(std::span<const std::byte> bytes);
  void put_chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload, int level);

  int level_;
  ByteSink sink_;
  ByteWriter header_, index_;
  std::uint64_t at_ = 0;  // bytes written
};

}  // namespace subpixel::capture
