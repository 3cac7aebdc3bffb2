// Splits the bytes of a .spcap file into checked, decompressed chunks, and reads fields of a chunk's payload.
// Private to the reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "capture_format/chunk.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {

struct ChunkAt {
  ChunkHeader header;
  std::uint64_t offset = 0;  // of the chunk's header in the file
  Checksum checksum = Checksum::xxh3_64;
};

struct ChunkList {
  std::uint32_t version = kOldestVersion;
  std::vector<ChunkAt> chunks;  // all but the index, in file order; of version 3 also of kinds that are not known
};

// The checksum of two stretches of bytes as if they were one; CRC-32 is in the low 32 bits, the others are 0.
std::uint64_t checksum_of(std::span<const std::byte> first, std::span<const std::byte> second, Checksum kind);

bool is_known(ChunkType type);

std::string chunk_name(ChunkType type, std::uint32_t id);

// Throws InputError("the capture can't be read", why, "byte N, chunk C, field F"); empty parts are left out.
[[noreturn]] void fail_reading(const std::string& why, std::uint64_t offset, const std::string& chunk,
                               std::string_view field);

// Checks everything outside payloads: magic, version, flags, footer, index against
// the chunks themselves, order and numbering, sizes against the file, padding, and that the decoded sizes together
// stay within the limits. Payload checksums are left to decode_chunk().
ChunkList list_chunks(std::span<const std::byte> file, const ReadLimits& limits);

// The chunks that are whole from the file's beginning on, their payloads not looked at; what ended them, empty when the
// index did.
struct WholeChunks {
  ChunkList list;
  std::string stopped;
};

// Of a file whose end may be missing or damaged, which says nothing of what stands before. Throws when it isn't a
// capture of a version that is known.
WholeChunks list_whole_chunks(std::span<const std::byte> file, const ReadLimits& limits);

// Throws when the chunk's checksum does not hold.
void verify_chunk(std::span<const std::byte> file, const ChunkAt& chunk);

// The payload of a chunk from list_chunks(), its checksum verified, decompressed to exactly its decoded size.
std::vector<std::byte> decode_chunk(std::span<const std::byte> file, const ChunkAt& chunk);

// Reads a payload field by field. Each read names its field and throws when the payload ends before it.
class FieldReader {
 public:
  FieldReader(std::span<const std::byte> payload, const ChunkAt& chunk) : payload_(payload), chunk_(chunk) {}

  template <typename T>
  requires std::is_trivially_copyable_v<T> T get(std::string_view field) {
    T value;
    std::memcpy(&value, take(sizeof value, field), sizeof value);
    return value;
  }

  // 0 or 1.
  bool flag(std::string_view field);

  // A text of at most kMaxTextBytes; whether it is UTF-8 is for checks.hpp.
  std::string text(std::string_view field);

  // A count of records of at least `record_bytes` each: refused unless so many can still follow.
  std::uint32_t count(std::string_view field, std::uint32_t most, std::size_t record_bytes);

  // Names the record that following fields belong to, for messages: "draw 17, ".
  void enter(std::string_view kind, std::uint32_t number) { kind_ = kind, number_ = number; }
  void leave() { kind_ = {}; }

  // Throws unless the payload is used up.
  void finish();

  [[noreturn]] void fail(std::string_view field, const std::string& why) const;

 private:
  const std::byte* take(std::size_t size, std::string_view field);

  std::span<const std::byte> payload_;
  const ChunkAt& chunk_;
  std::size_t at_ = 0;
  std::string_view kind_;
  std::uint32_t number_ = 0;
};

}  // namespace subpixel::capture
