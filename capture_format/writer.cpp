#include "capture_format/writer.hpp"

#include <zstd.h>

#include <map>
#include <span>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/chunk.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/record_writer.hpp"

namespace subpixel::capture {
namespace {

class FileWriter {
 public:
  FileWriter(std::uint32_t version, const EncodeOptions& options) : level_(options.zstd_level) {
    for (const unsigned char c : kMagic) out_.put(c);
    out_.put(version);
    out_.put(std::uint32_t{0});
  }

  void chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload) {
    index_.put(type);
    index_.put(id);
    index_.put(std::uint64_t{out_.bytes.size()});
    write_chunk(type, id, payload, level_);
  }

  std::vector<std::byte> finish() {
    const std::uint64_t index_offset = out_.bytes.size();
    write_chunk(ChunkType::index, 0, index_.bytes, 0);
    ByteWriter footer;
    footer.put(index_offset);
    footer.put(out_.bytes.size() + kFooterBytes);
    footer.put(xxh3_64_of(std::span(out_.bytes).first(kHeaderBytes), footer.bytes));
    for (const unsigned char c : kEndMagic) footer.put(c);
    out_.raw(footer.bytes);
    return std::move(out_.bytes);
  }

 private:
  void write_chunk(ChunkType type, std::uint32_t id, std::span<const std::byte> payload, int level) {
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
    out_.raw(header.bytes);
    out_.raw(stored);
    out_.bytes.resize(aligned(out_.bytes.size()));
  }

  ByteWriter out_;
  ByteWriter index_;
  int level_;
};

// Each different byte string gets one DATA chunk, numbered in the order of first use.
class DataChunks {
 public:
  explicit DataChunks(FileWriter& file) : file_(file) {}

  std::uint32_t add(std::span<const std::byte> bytes) {
    const auto [found, is_new] = ids_.try_emplace(content_hash_hex(bytes), static_cast<std::uint32_t>(ids_.size()));
    if (is_new) file_.chunk(ChunkType::data, found->second, bytes);
    return found->second;
  }

 private:
  FileWriter& file_;
  std::map<std::string, std::uint32_t> ids_;  // 128 bits of XXH3: equal hashes are taken as equal bytes
};

Report refuse(const std::string& part) {
  return [part](std::string_view field, const std::string& why) {
    throw InputError("can't write the capture", why, part + ", field " + std::string(field));
  };
}

void require_count(std::string_view what, std::size_t count, std::size_t most) {
  if (count > most) {
    throw InputError("can't write the capture", std::to_string(count) + " are more than " + std::to_string(most),
                     std::string(what));
  }
}

void require_valid(const Capture& capture) {
  require_count("buffers", capture.buffers.size(), kMaxBuffers);
  require_count("textures", capture.textures.size(), kMaxTextures);
  require_count("materials", capture.materials.size(), kMaxMaterials);
  require_count("frames", capture.frames.size(), kMaxFrames);
  check_metadata(capture.metadata, refuse("metadata"));
  for (std::size_t i = 0; i < capture.buffers.size(); ++i) {
    check_buffer(capture.buffers[i], refuse("buffer " + std::to_string(i)));
  }
  for (std::size_t i = 0; i < capture.textures.size(); ++i) {
    check_texture(capture.textures[i], refuse("texture " + std::to_string(i)));
  }
  for (std::size_t i = 0; i < capture.materials.size(); ++i) {
    check_material(capture.materials[i], capture.textures.size(), refuse("material " + std::to_string(i)));
  }
  IndexChecker indices;
  for (std::size_t f = 0; f < capture.frames.size(); ++f) {
    const std::string part = "frame " + std::to_string(f);
    check_frame(capture.frames[f], refuse(part));
    check_draw_list(capture.frames[f], refuse(part));
    for (std::size_t d = 0; d < capture.frames[f].draws.size(); ++d) {
      const Report report = refuse(part + ", draw " + std::to_string(d));
      check_draw(capture, capture.frames[f].draws[d], report);
      indices.check(capture, capture.frames[f].draws[d], report);
    }
  }
}

}  // namespace

std::vector<std::byte> encode_capture(const Capture& capture, const EncodeOptions& options) {
  require_valid(capture);
  const RecordWriter records(needed_version(capture));
  FileWriter file(records.version(), options);
  file.chunk(ChunkType::metadata, 0, records.metadata(capture.metadata));

  DataChunks data(file);
  std::vector<std::uint32_t> buffer_data;
  std::vector<std::uint32_t> texture_data;
  for (const Buffer& buffer : capture.buffers) buffer_data.push_back(data.add(buffer.bytes));
  for (const Texture& texture : capture.textures) texture_data.push_back(data.add(texture.bytes));

  for (std::uint32_t i = 0; i < capture.buffers.size(); ++i) {
    file.chunk(ChunkType::buffer, i, records.buffer(capture.buffers[i], buffer_data[i]));
  }
  for (std::uint32_t i = 0; i < capture.textures.size(); ++i) {
    file.chunk(ChunkType::texture, i, records.texture(capture.textures[i], texture_data[i]));
  }
  file.chunk(ChunkType::material, 0, records.materials(capture.materials));
  for (std::uint32_t i = 0; i < capture.frames.size(); ++i) {
    file.chunk(ChunkType::frame, i, records.frame(capture.frames[i]));
  }
  return file.finish();
}

void write_capture(const Capture& capture, const std::filesystem::path& path, const EncodeOptions& options) {
  write_file_atomically(path, encode_capture(capture, options), MissingFolder::refuse);
}

}  // namespace subpixel::capture
