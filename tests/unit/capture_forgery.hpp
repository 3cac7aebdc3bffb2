// Files whose checksums hold but whose contents lie.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "capture_format/chunk.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {

// An uncompressed file that can be changed field by field and signed again.
class Forgery {
 public:
  explicit Forgery(const Capture& capture = small_capture()) : bytes_(encode_capture(capture, {.zstd_level = 0})) {}

  // Offset of a chunk's header.
  std::size_t chunk(ChunkType type, std::uint32_t id = 0) const {
    std::size_t offset = kHeaderBytes;
    while (get<ChunkType>(offset) != type || get<std::uint32_t>(offset + 4) != id) {
      offset = aligned(offset + kChunkHeaderBytes + get<std::uint64_t>(offset + 16));
    }
    return offset;
  }

  template <typename T>
  T get(std::size_t offset) const {
    T value;
    std::memcpy(&value, bytes_.data() + offset, sizeof value);
    return value;
  }
  template <typename T>
  void set(std::size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof value);
  }

  // Sets a field of a chunk's payload and makes its checksum right.
  template <typename T>
  void set_payload(ChunkType type, std::uint32_t id, std::size_t offset, T value) {
    const std::size_t at = chunk(type, id);
    set(at + kChunkHeaderBytes + offset, value);
    sign(at);
  }

  // Makes a chunk one of another kind, in the index too, and signs both.
  void set_type(ChunkType type, std::uint32_t id, std::uint32_t other) {
    const std::size_t at = chunk(type, id), index = chunk(ChunkType::index);
    set(at, other);
    sign(at);
    const std::size_t entries = get<std::uint64_t>(index + 16) / 16;
    for (std::size_t i = 0; i < entries; ++i) {
      const std::size_t entry = index + kChunkHeaderBytes + 16 * i;
      if (get<std::uint64_t>(entry + 8) == at) set(entry, other);
    }
    sign(index);
  }

  // Puts a payload of the same size in the place of a chunk's own.
  void replace_payload(ChunkType type, std::uint32_t id, std::span<const std::byte> payload) {
    const std::size_t at = chunk(type, id);
    ASSERT_EQ(get<std::uint64_t>(at + 16), payload.size());
    std::copy(payload.begin(), payload.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at + kChunkHeaderBytes));
    sign(at);
  }

  // Says another version in the header, and makes the footer's checksum right.
  void set_version(std::uint32_t version) {
    set(8, version);
    sign_footer();
  }

  void sign_footer() {
    const std::span<const std::byte> all(bytes_);
    const std::size_t footer = bytes_.size() - kFooterBytes;
    set(footer + 16, xxh3_64_of(all.first(kHeaderBytes), all.subspan(footer, 16)));
  }

  void sign(std::size_t chunk_offset) {
    const std::span<const std::byte> all(bytes_);
    const auto stored = get<std::uint64_t>(chunk_offset + 16);
    if (stored > bytes_.size()) return;  // the lie is the size itself
    set(chunk_offset + 32, xxh3_64_of(all.subspan(chunk_offset, 32), all.subspan(chunk_offset + 40, stored)));
  }

  // Where in the first frame's payload a pattern of bytes stands, which must be there once.
  template <typename T>
  std::size_t find_in_frame(const T& pattern) const {
    const std::size_t from = chunk(ChunkType::frame) + kChunkHeaderBytes;
    const std::size_t size = get<std::uint64_t>(chunk(ChunkType::frame) + 16);
    for (std::size_t i = 0; i + sizeof pattern <= size; ++i) {
      if (std::memcmp(bytes_.data() + from + i, &pattern, sizeof pattern) == 0) return i;
    }
    ADD_FAILURE() << "pattern not found";
    return 0;
  }

  // The data number of a texture.
  std::uint32_t texture_data(std::uint32_t id) const {
    const std::size_t name = chunk(ChunkType::texture, id) + kChunkHeaderBytes;
    return get<std::uint32_t>(name + 4 + get<std::uint32_t>(name) + 16);
  }

  std::span<const std::byte> bytes() const { return bytes_; }
  std::string refused() const { return refusal(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

#define EXPECT_REFUSED(forgery, text) \
  EXPECT_NE((forgery).refused().find(text), std::string::npos) << "refused with: " << (forgery).refused()

}  // namespace subpixel::capture
