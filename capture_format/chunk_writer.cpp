#include "capture_format/chunk_writer.hpp"

#include <zstd.h>

#include <array>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace subpixel::capture {

ChunkWriter::ChunkWriter(std::uint32_t version, int zstd_level, ByteSink sink)
    : level_(zstd_level), sink_(std::move(sink)) {
  for (const unsigned char c : kMagic) header_.put(c);
  header_.put(version);
  header_.put(std::uint32_t{0});
  put(header_.bytes);
}

std::uint64_t ChunkWriter::chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload) {
  const std::uint64_t offset = at_;
  index_.put(type);
  index_.put(id);
  index_.put(offset);
  put_chunk(type, id, payload, level_);
  return offset;
}

void ChunkWriter::finish() {
  const std::uint64_t index_offset = at_;
  put_chunk(ChunkType::index, 0, index_.bytes, 0);
  ByteWriter footer;
  footer.put(index_offset);
  footer.put(at_ + kFooterBytes);
  footer.put(xxh3_64_of(header_.bytes, footer.bytes));
  for (const unsigned char c : kEndMagic) footer.put(c);
  put(footer.bytes);
}

void ChunkWriter::put(std::span<const std::byte> bytes) {
  sink_(bytes);
  at_ += bytes.size();
}

void ChunkWriter::put_chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload, int level) {
  std::vector<std::byte> packed;
  if (level > 0 && !payload.empty()) {
    packed.resize(ZSTD_compressBound(payload.size()));
    const std::size_t got = ZSTD_compress(packed.data(), packed.size(), payload.data(), payload.size(), level);
    if (ZSTD_isError(got) != 0) throw InputError("can't compress the capture", ZSTD_getErrorName(got), "");
    packed.resize(got);
  }
  const bool smaller = !packed.empty() && packed.size() < payload.size();
  const std::span<const std::byte> stored = smaller ? std::span<const std::byte>(packed) : payload;
  ByteWriter header;
  header.put(type);
  header.put(id);
  header.put(smaller ? Codec::zstd : Codec::raw);
  header.put(std::uint32_t{0});
  header.put(std::uint64_t{stored.size()});
  header.put(std::uint64_t{payload.size()});
  header.put(xxh3_64_of(header.bytes, stored));
  put(header.bytes);
  put(stored);
  constexpr std::array<std::byte, kAlignment> kZeros{};
  put(std::span(kZeros).first(aligned(at_) - at_));
}

}  // namespace subpixel::capture
