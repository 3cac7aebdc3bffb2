// Files as a writer of one's own would make them, from SPEC.md: any version, checksum and codec, and chunks of any
// content.
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <stdexcept>

#include "capture_format/chunk.hpp"
#include "capture_format/reading/chunk_reader.hpp"
#include "capture_format/record_writer.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {

using Bytes = std::vector<std::byte>;

template <typename T>
T load(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

inline Bytes deflated(std::span<const std::byte> payload, int level = 6) {
  uLongf size = ::compressBound(payload.size());
  Bytes out(size);
  const auto* from = reinterpret_cast<const Bytef*>(payload.data());
  EXPECT_EQ(::compress2(reinterpret_cast<Bytef*>(out.data()), &size, from, payload.size(), level), Z_OK);
  out.resize(size);
  return out;
}

struct Part {
  ChunkHeader header;
  Bytes stored;
};

struct ForeignFile {
  std::uint32_t version = 2, flags = 1;
  std::vector<Part> chunks;

  Checksum checksum() const { return flags == 1 ? Checksum::crc32 : Checksum::xxh3_64; }

  Bytes bytes() const {
    ByteWriter out, index;
    for (const unsigned char c : kMagic) out.put(c);
    out.put(version);
    out.put(flags);
    const auto add = [&](const Part& part) {
      ByteWriter header;
      header.put(part.header.type);
      header.put(part.header.id);
      header.put(part.header.codec);
      header.put(std::uint32_t{0});
      header.put(std::uint64_t{part.stored.size()});
      header.put(part.header.decoded_bytes);
      header.put(checksum_of(header.bytes, part.stored, checksum()));
      out.raw(header.bytes);
      out.raw(part.stored);
      out.bytes.resize(aligned(out.bytes.size()));
    };
    for (const Part& part : chunks) {
      index.put(part.header.type);
      index.put(part.header.id);
      index.put(std::uint64_t{out.bytes.size()});
      add(part);
    }
    const std::uint64_t index_offset = out.bytes.size();
    add({{ChunkType::index, 0, Codec::raw, 0, index.bytes.size()}, index.bytes});
    ByteWriter footer;
    footer.put(index_offset);
    footer.put(std::uint64_t{out.bytes.size() + kFooterBytes});
    footer.put(checksum_of(std::span(out.bytes).first(kHeaderBytes), footer.bytes, checksum()));
    for (const unsigned char c : kEndMagic) footer.put(c);
    out.raw(footer.bytes);
    return out.bytes;
  }

  Part& part(ChunkType type, std::uint32_t id = 0) {
    for (Part& each : chunks) {
      if (each.header.type == type && each.header.id == id) return each;
    }
    throw std::out_of_range("no such chunk");
  }
};

// The chunks of a file as they are stored.
inline ForeignFile parts_of(const Bytes& bytes) {
  ForeignFile file;
  file.version = load<std::uint32_t>(bytes, 8);
  file.flags = load<std::uint32_t>(bytes, 12);
  const auto end = load<std::uint64_t>(bytes, bytes.size() - kFooterBytes);
  for (std::uint64_t at = kHeaderBytes; at < end;) {
    Part part{{load<ChunkType>(bytes, at), load<std::uint32_t>(bytes, at + 4), load<Codec>(bytes, at + 8)}, {}};
    const auto size = load<std::uint64_t>(bytes, at + 16);
    part.header.decoded_bytes = load<std::uint64_t>(bytes, at + 24);
    const auto payload = std::span(bytes).subspan(at + kChunkHeaderBytes, size);
    part.stored.assign(payload.begin(), payload.end());
    file.chunks.push_back(std::move(part));
    at = aligned(at + kChunkHeaderBytes + size);
  }
  return file;
}

// Its chunks in `codec`, whether or not that makes them smaller.
inline ForeignFile foreign(const Capture& capture, Codec codec, std::uint32_t flags = 1) {
  ForeignFile file = parts_of(encode_capture(capture, {.zstd_level = 0}));
  file.flags = flags;
  for (Part& part : file.chunks) {
    part.header.codec = codec;
    if (codec == Codec::zlib) part.stored = deflated(part.stored);
  }
  return file;
}

}  // namespace subpixel::capture
