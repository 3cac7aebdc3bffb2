// The frame of a .spcap file: header, chunk headers and footer, as SPEC.md gives them. Private to reader and writer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace subpixel::capture {

// As PNG does: a high bit, both line ends and ctrl-Z, so that a text-mode copy damages the magic visibly.
inline constexpr std::array<unsigned char, 8> kMagic{0x89, 'S', 'P', 'C', 'A', 'P', '\n', 0x1a};
inline constexpr std::array<unsigned char, 8> kEndMagic{'S', 'P', 'C', 'A', 'P', 'E', 'N', 'D'};
inline constexpr std::uint32_t kOldestVersion = 1, kNewestVersion = 3;

inline constexpr std::uint64_t kHeaderBytes = 16;       // magic, version, flags
inline constexpr std::uint64_t kChunkHeaderBytes = 40;  // type, id, codec, reserved, stored, decoded, checksum
inline constexpr std::uint64_t kIndexEntryBytes = 16;   // type, id, offset
inline constexpr std::uint64_t kFooterBytes = 32;       // index offset, file bytes, checksum, end magic
inline constexpr std::uint64_t kAlignment = 8;          // chunks begin at multiples of this

constexpr std::uint32_t four_cc(const char (&name)[5]) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<unsigned char>(name[i]);
  return code;
}

// In the order they stand in a file of version 1 or 2, and in one written at once.
enum class ChunkType : std::uint32_t {
  metadata = four_cc("META"),
  data = four_cc("DATA"),
  buffer = four_cc("BUFR"),
  texture = four_cc("TEXR"),
  material = four_cc("MATL"),
  frame = four_cc("FRAM"),
  index = four_cc("INDX"),
};
inline constexpr std::array kChunkOrder{ChunkType::metadata, ChunkType::data,  ChunkType::buffer, ChunkType::texture,
                                        ChunkType::material, ChunkType::frame, ChunkType::index};

enum class Codec : std::uint32_t { raw = 0, zstd = 1, zlib = 2 };
enum class Checksum : std::uint32_t { xxh3_64 = 0, crc32 = 1 };  // the file header's flags

// What a file's header says of all its chunks.
struct FileKind {
  std::uint32_t version = kOldestVersion;
  Checksum checksum = Checksum::xxh3_64;
};

struct ChunkHeader {
  ChunkType type{};
  std::uint32_t id = 0;
  Codec codec = Codec::raw;
  std::uint64_t stored_bytes = 0;
  std::uint64_t decoded_bytes = 0;
  std::uint64_t checksum = 0;  // of the 32 header bytes before it and the stored payload
};

constexpr std::uint64_t aligned(std::uint64_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

// XXH3-64 of two stretches of bytes as if they were one: the checksum of what is written here. A reader knows another
// besides (reading/chunk_reader.hpp).
std::uint64_t xxh3_64_of(std::span<const std::byte> first, std::span<const std::byte> second);

}  // namespace subpixel::capture
