#include "capture_format/reading/chunk_reader.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <new>
#include <utility>

#include "base/error.hpp"

namespace subpixel::capture {
namespace {

static_assert(std::endian::native == std::endian::little);

template <typename T>
T load(std::span<const std::byte> bytes, std::uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

bool has_magic(std::span<const std::byte> bytes, std::uint64_t offset, std::span<const unsigned char> magic) {
  return std::memcmp(bytes.data() + offset, magic.data(), magic.size()) == 0;
}

// A fuzzer can't guess checksums, so they hold in every build but its own.
bool checksum_holds(std::uint64_t stored, std::uint64_t computed) {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  static_cast<void>(stored), static_cast<void>(computed);
  return true;
#else
  return stored == computed;
#endif
}

std::size_t place_in_order(ChunkType type) {
  return static_cast<std::size_t>(std::find(kChunkOrder.begin(), kChunkOrder.end(), type) - kChunkOrder.begin());
}

// The chunk header at `offset`, which the caller knows to lie inside the file; its payload must end by `end`.
ChunkHeader load_header(std::span<const std::byte> file, std::uint64_t offset, std::uint64_t end,
                        const FileKind& kind) {
  ChunkHeader header;
  header.type = load<ChunkType>(file, offset);
  header.id = load<std::uint32_t>(file, offset + 4);
  header.codec = load<Codec>(file, offset + 8);
  header.stored_bytes = load<std::uint64_t>(file, offset + 16);
  header.decoded_bytes = load<std::uint64_t>(file, offset + 24);
  header.checksum = load<std::uint64_t>(file, offset + 32);
  const std::string name = chunk_name(header.type, header.id);
  const bool known = is_known(header.type);
  if (!known && kind.version < 3) fail_reading("unknown chunk type", offset, name, "type");
  if (known && header.codec > Codec::zlib) fail_reading("unknown codec", offset + 8, name, "codec");
  if (header.codec == Codec::zlib && kind.version < 2) {
    fail_reading("version 1 knows no zlib", offset + 8, name, "codec");
  }
  if (load<std::uint32_t>(file, offset + 12) != 0) fail_reading("not 0", offset + 12, name, "reserved");
  const std::uint64_t available = end - offset - kChunkHeaderBytes;
  if (header.stored_bytes > available) {
    fail_reading(
        std::to_string(header.stored_bytes) + " bytes are said to follow, " + std::to_string(available) + " do",
        offset + 16, name, "stored_bytes");
  }
  if (header.codec == Codec::raw && header.decoded_bytes != header.stored_bytes) {
    fail_reading("differs from stored_bytes of an uncompressed chunk", offset + 24, name, "decoded_bytes");
  }
  // Deflate makes at most 258 bytes of 2 bits: what promises more lies, and takes no memory.
  constexpr std::uint64_t kMostInflation = 1032;
  if (header.codec == Codec::zlib && header.decoded_bytes / kMostInflation > header.stored_bytes) {
    fail_reading("more than zlib can make of " + std::to_string(header.stored_bytes) + " bytes", offset + 24, name,
                 "decoded_bytes");
  }
  return header;
}

// Chunks of one type are numbered 0, 1, 2, ..., and before version 3 types stand in kChunkOrder.
class ChunkOrder {
 public:
  explicit ChunkOrder(std::uint32_t version) : version_(version) {}

  void require(const ChunkAt& chunk) {
    const ChunkHeader& header = chunk.header;
    const std::string name = chunk_name(header.type, header.id);
    const std::size_t place = place_in_order(header.type);
    if (place == kChunkOrder.size()) return;  // of a kind that is skipped
    if (version_ < 3 && place < last_place_) {
      fail_reading("stands after a later kind of chunk", chunk.offset, name, "type");
    }
    if (header.type == ChunkType::index) fail_reading("the index stands last", chunk.offset, name, "type");
    if (header.id != next_[place]) fail_reading("out of sequence", chunk.offset + 4, name, "id");
    ++next_[place];
    last_place_ = place;
  }

 private:
  std::uint32_t version_;
  std::array<std::uint32_t, kChunkOrder.size()> next_{};
  std::size_t last_place_ = 0;
};

// The chunk at `offset` of a file whose chunks end at `end`, its padding looked at and its decoded size added to
// those before it.
ChunkAt next_chunk(std::span<const std::byte> file, std::uint64_t offset, std::uint64_t end, const FileKind& kind,
                   const ReadLimits& limits, std::uint64_t& decoded_bytes) {
  if (end - offset < kChunkHeaderBytes) fail_reading("no room for a chunk header", offset, "", "");
  const ChunkAt chunk{load_header(file, offset, end, kind), offset, kind.checksum};
  const std::string name = chunk_name(chunk.header.type, chunk.header.id);
  if (is_known(chunk.header.type)) {
    if (chunk.header.decoded_bytes > limits.decoded_bytes - decoded_bytes) {
      fail_reading("more than " + std::to_string(limits.decoded_bytes) + " bytes in all", offset + 24, name,
                   "decoded_bytes");
    }
    decoded_bytes += chunk.header.decoded_bytes;
  }
  const std::uint64_t payload_end = offset + kChunkHeaderBytes + chunk.header.stored_bytes;
  if (aligned(payload_end) > end) fail_reading("no room for the padding", payload_end, name, "padding");
  for (std::uint64_t i = payload_end; i < aligned(payload_end); ++i) {
    if (file[i] != std::byte{0}) fail_reading("not 0", i, name, "padding");
  }
  return chunk;
}

std::uint64_t checked_footer(std::span<const std::byte> file, Checksum checksum) {
  const std::uint64_t footer = file.size() - kFooterBytes;
  if (!has_magic(file, footer + 24, kEndMagic)) {
    fail_reading("the end is missing: the file is truncated or has bytes after its end", footer + 24, "footer",
                 "end_magic");
  }
  if (load<std::uint64_t>(file, footer + 8) != file.size()) {
    fail_reading("differs from the file's " + std::to_string(file.size()) + " bytes", footer + 8, "footer",
                 "file_bytes");
  }
  if (!checksum_holds(load<std::uint64_t>(file, footer + 16),
                      checksum_of(file.first(kHeaderBytes), file.subspan(footer, 16), checksum))) {
    fail_reading("header or footer is damaged", footer + 16, "footer", "checksum");
  }
  const auto index_offset = load<std::uint64_t>(file, footer);
  if (index_offset < kHeaderBytes || index_offset % kAlignment != 0 || index_offset > footer ||
      footer - index_offset < kChunkHeaderBytes) {
    fail_reading(std::to_string(index_offset) + " is outside the file's chunks", footer, "footer", "index_offset");
  }
  return index_offset;
}

void require_index(std::span<const std::byte> file, std::uint64_t offset, const std::vector<ChunkAt>& chunks,
                   const FileKind& kind) {
  const std::uint64_t footer = file.size() - kFooterBytes;
  const ChunkAt index{load_header(file, offset, footer, kind), offset, kind.checksum};
  const std::string name = chunk_name(index.header.type, index.header.id);
  if (index.header.type != ChunkType::index || index.header.id != 0)
    fail_reading("not the index", offset, name, "type");
  if (index.header.codec != Codec::raw) fail_reading("the index is never compressed", offset + 8, name, "codec");
  if (aligned(offset + kChunkHeaderBytes + index.header.stored_bytes) != footer) {
    fail_reading("the index does not end at the footer", offset + 16, name, "stored_bytes");
  }
  if (index.header.stored_bytes != chunks.size() * kIndexEntryBytes) {
    fail_reading("the index does not list the file's " + std::to_string(chunks.size()) + " chunks", offset + 16, name,
                 "stored_bytes");
  }
  const std::vector<std::byte> entries = decode_chunk(file, index);
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const std::uint64_t at = i * kIndexEntryBytes;
    if (load<ChunkType>(entries, at) != chunks[i].header.type ||
        load<std::uint32_t>(entries, at + 4) != chunks[i].header.id ||
        load<std::uint64_t>(entries, at + 8) != chunks[i].offset) {
      fail_reading("differs from the chunk that is there", offset + kChunkHeaderBytes + at, name,
                   "entry " + std::to_string(i));
    }
  }
}

FileKind checked_kind(std::span<const std::byte> file) {
  FileKind kind;
  kind.version = load<std::uint32_t>(file, 8);
  if (kind.version < kOldestVersion || kind.version > kNewestVersion) {
    fail_reading("version " + std::to_string(kind.version) + ", this program reads " + std::to_string(kOldestVersion) +
                     " to " + std::to_string(kNewestVersion),
                 8, "header", "version");
  }
  const auto flags = load<std::uint32_t>(file, 12);
  if (kind.version == 1 && flags != 0) fail_reading("not 0", 12, "header", "flags");
  if (flags > static_cast<std::uint32_t>(Checksum::crc32)) {
    fail_reading(std::to_string(flags) + " is no checksum", 12, "header", "flags");
  }
  kind.checksum = static_cast<Checksum>(flags);
  return kind;
}

std::vector<std::byte> decode_zstd(std::span<const std::byte> stored, const ChunkAt& chunk, const std::string& name) {
  // The frame's own size is asked first: memory is taken only when it says the same as the header.
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != chunk.header.decoded_bytes) {
    fail_reading("differs from the compressed payload's own size", chunk.offset + 24, name, "decoded_bytes");
  }
  std::vector<std::byte> decoded(chunk.header.decoded_bytes);
  const std::size_t got = ZSTD_decompress(decoded.data(), decoded.size(), stored.data(), stored.size());
  if (ZSTD_isError(got) != 0) {
    fail_reading(std::string("zstd: ") + ZSTD_getErrorName(got), chunk.offset + kChunkHeaderBytes, name, "payload");
  }
  if (got != decoded.size()) {
    fail_reading("the payload decodes to " + std::to_string(got) + " bytes", chunk.offset + 24, name, "decoded_bytes");
  }
  return decoded;
}

// One zlib stream (RFC 1950), which must fill exactly decoded_bytes and end with the stored bytes.
std::vector<std::byte> decode_zlib(std::span<const std::byte> stored, const ChunkAt& chunk, const std::string& name) {
  const std::uint64_t payload = chunk.offset + kChunkHeaderBytes;
  z_stream stream{};
  if (::inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> ended(&stream, &::inflateEnd);
  // A byte more than should come, so that a stream that goes on is seen to. zlib counts in 32 bits: parts of 1 GiB.
  std::vector<std::byte> decoded(chunk.header.decoded_bytes + 1);
  constexpr std::size_t kPart = std::size_t{1} << 30;
  std::size_t read = 0, written = 0;
  int status = Z_OK;
  while (status == Z_OK) {
    const std::size_t in = std::min(kPart, stored.size() - read), out = std::min(kPart, decoded.size() - written);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(stored.data() + read));  // zlib only reads it
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(decoded.data() + written);
    stream.avail_out = static_cast<uInt>(out);
    status = ::inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    written += out - stream.avail_out;
    if (written > chunk.header.decoded_bytes) {
      fail_reading("the payload decodes to more", chunk.offset + 24, name, "decoded_bytes");
    }
  }
  if (status == Z_BUF_ERROR) fail_reading("zlib: the stream does not end", payload + read, name, "payload");
  if (status == Z_NEED_DICT) fail_reading("zlib: a dictionary is asked for", payload, name, "payload");
  if (status != Z_STREAM_END) {
    fail_reading(std::string("zlib: ") + (stream.msg != nullptr ? stream.msg : "damaged"), payload + read, name,
                 "payload");
  }
  if (read != stored.size()) {
    fail_reading(std::to_string(stored.size() - read) + " bytes follow the zlib stream", payload + read, name,
                 "payload");
  }
  if (written != chunk.header.decoded_bytes) {
    fail_reading("the payload decodes to " + std::to_string(written) + " bytes", chunk.offset + 24, name,
                 "decoded_bytes");
  }
  decoded.pop_back();
  return decoded;
}

}  // namespace

std::uint64_t checksum_of(std::span<const std::byte> first, std::span<const std::byte> second, Checksum kind) {
  if (kind == Checksum::xxh3_64) return xxh3_64_of(first, second);
  const auto* a = reinterpret_cast<const Bytef*>(first.data());
  const auto* b = reinterpret_cast<const Bytef*>(second.data());
  // A null pointer asks zlib for the initial value, which is that of no bytes.
  const uLong of_first = ::crc32_z(0, first.empty() ? nullptr : a, first.size());
  return second.empty() ? of_first : ::crc32_z(of_first, b, second.size());
}

bool is_known(ChunkType type) {
  return place_in_order(type) < kChunkOrder.size();
}

std::string chunk_name(ChunkType type, std::uint32_t id) {
  const auto code = static_cast<std::uint32_t>(type);
  std::string name;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>(code >> (8 * i) & 0xff);
    name += c >= ' ' && c <= '~' ? c : '?';
  }
  return name + " " + std::to_string(id);
}

void fail_reading(const std::string& why, std::uint64_t offset, const std::string& chunk, std::string_view field) {
  std::string where = "byte " + std::to_string(offset);
  if (!chunk.empty()) where += ", chunk " + chunk;
  if (!field.empty()) where += ", field " + std::string(field);
  throw InputError("the capture can't be read", why, where);
}

FileKind file_kind(std::span<const std::byte> file) {
  if (file.size() < kMagic.size() || !has_magic(file, 0, kMagic)) {
    fail_reading("this is no .spcap capture", 0, "header", "magic");
  }
  if (file.size() < kHeaderBytes) {
    fail_reading("the file is truncated to " + std::to_string(file.size()) + " bytes", file.size(), "", "");
  }
  return checked_kind(file);
}

ChunkList list_chunks(std::span<const std::byte> file, const ReadLimits& limits) {
  const FileKind kind = file_kind(file);
  if (file.size() < kHeaderBytes + kChunkHeaderBytes + kFooterBytes) {
    fail_reading("the file is truncated to " + std::to_string(file.size()) + " bytes", file.size(), "", "");
  }
  const std::uint64_t index_offset = checked_footer(file, kind.checksum);

  std::vector<ChunkAt> chunks;
  ChunkOrder order(kind.version);
  std::uint64_t decoded_bytes = 0;
  for (std::uint64_t offset = kHeaderBytes; offset < index_offset;) {
    chunks.push_back(next_chunk(file, offset, index_offset, kind, limits, decoded_bytes));
    order.require(chunks.back());
    offset = aligned(offset + kChunkHeaderBytes + chunks.back().header.stored_bytes);
  }
  require_index(file, index_offset, chunks, kind);
  return {kind.version, std::move(chunks)};
}

WholeChunks list_whole_chunks(std::span<const std::byte> file, const ReadLimits& limits) {
  const FileKind kind = file_kind(file);
  WholeChunks whole{{kind.version, {}}, ""};
  ChunkOrder order(kind.version);
  std::uint64_t decoded_bytes = 0;
  try {
    for (std::uint64_t offset = kHeaderBytes; offset < file.size();) {
      const ChunkAt chunk = next_chunk(file, offset, file.size(), kind, limits, decoded_bytes);
      if (chunk.header.type == ChunkType::index) break;
      order.require(chunk);
      whole.list.chunks.push_back(chunk);
      offset = aligned(offset + kChunkHeaderBytes + chunk.header.stored_bytes);
    }
  } catch (const InputError& error) {
    whole.stopped = error.what();
  }
  return whole;
}

void verify_chunk(std::span<const std::byte> file, const ChunkAt& chunk) {
  const auto stored = file.subspan(chunk.offset + kChunkHeaderBytes, chunk.header.stored_bytes);
  const auto head = file.subspan(chunk.offset, kChunkHeaderBytes - 8);
  if (!checksum_holds(chunk.header.checksum, checksum_of(head, stored, chunk.checksum))) {
    fail_reading("the chunk's bytes are damaged", chunk.offset + 32, chunk_name(chunk.header.type, chunk.header.id),
                 "checksum");
  }
}

std::vector<std::byte> decode_chunk(std::span<const std::byte> file, const ChunkAt& chunk) {
  const std::string name = chunk_name(chunk.header.type, chunk.header.id);
  const auto stored = file.subspan(chunk.offset + kChunkHeaderBytes, chunk.header.stored_bytes);
  verify_chunk(file, chunk);
  if (chunk.header.codec == Codec::raw) return {stored.begin(), stored.end()};
  if (chunk.header.codec == Codec::zlib) return decode_zlib(stored, chunk, name);
  return decode_zstd(stored, chunk, name);
}

const std::byte* FieldReader::take(std::size_t size, std::string_view field) {
  if (size > payload_.size() - at_) fail(field, "the chunk ends before it");
  const std::byte* from = payload_.data() + at_;
  at_ += size;
  return from;
}

bool FieldReader::flag(std::string_view field) {
  const auto value = get<std::uint32_t>(field);
  if (value > 1) fail(field, std::to_string(value) + " is neither 0 nor 1");
  return value == 1;
}

std::string FieldReader::text(std::string_view field) {
  const auto size = get<std::uint32_t>(field);
  if (size > kMaxTextBytes) fail(field, "longer than " + std::to_string(kMaxTextBytes) + " bytes");
  const auto* from = reinterpret_cast<const char*>(take(size, field));
  return {from, from + size};
}

std::uint32_t FieldReader::count(std::string_view field, std::uint32_t most, std::size_t record_bytes) {
  const auto value = get<std::uint32_t>(field);
  if (value > most) fail(field, std::to_string(value) + " is more than " + std::to_string(most));
  if (value > (payload_.size() - at_) / record_bytes) {
    fail(field, std::to_string(value) + " records do not fit the chunk");
  }
  return value;
}

void FieldReader::finish() {
  if (at_ != payload_.size()) {
    fail("end", std::to_string(payload_.size() - at_) + " bytes follow the last field");
  }
}

void FieldReader::fail(std::string_view field, const std::string& why) const {
  const std::string record = kind_.empty() ? "" : std::string(kind_) + " " + std::to_string(number_) + ", ";
  // A compressed payload has no file offset of its own: the chunk's is given, and where in the decoded payload it is.
  const std::string chunk = chunk_name(chunk_.header.type, chunk_.header.id) + ", decoded byte " + std::to_string(at_) +
                            (record.empty() ? "" : ", " + record.substr(0, record.size() - 2));
  fail_reading(why, chunk_.offset, chunk, field);
}

}  // namespace subpixel::capture
