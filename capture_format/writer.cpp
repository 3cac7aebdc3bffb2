#include "capture_format/writer.hpp"

#include <map>
#include <span>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/chunk_writer.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/record_writer.hpp"

namespace subpixel::capture {
namespace {

// Each different byte string gets one DATA chunk, numbered in the order of first use.
class DataChunks {
 public:
  explicit DataChunks(ChunkWriter& file) : file_(file) {}

  std::uint32_t add(std::span<const std::byte> bytes) {
    const auto [found, is_new] = ids_.try_emplace(content_hash_hex(bytes), static_cast<std::uint32_t>(ids_.size()));
    if (is_new) file_.chunk(ChunkType::data, found->second, bytes);
    return found->second;
  }

 private:
  ChunkWriter& file_;
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
  const std::vector<std::uint64_t> sizes = sizes_of(capture.buffers);
  IndexChecker indices;
  for (std::size_t f = 0; f < capture.frames.size(); ++f) {
    const std::string part = "frame " + std::to_string(f);
    check_frame(capture.frames[f], refuse(part));
    check_draw_list(capture.frames[f], refuse(part));
    for (std::size_t d = 0; d < capture.frames[f].draws.size(); ++d) {
      const Report report = refuse(part + ", draw " + std::to_string(d));
      check_draw({sizes, capture.materials.size()}, capture.frames[f].draws[d], report);
      indices.check(capture, capture.frames[f].draws[d], report);
    }
  }
}

}  // namespace

std::vector<std::byte> encode_capture(const Capture& capture, const EncodeOptions& options) {
  require_valid(capture);
  const RecordWriter records(needed_version(capture));
  std::vector<std::byte> bytes;
  ChunkWriter file(records.version(), options.zstd_level,
                   [&](std::span<const std::byte> more) { bytes.insert(bytes.end(), more.begin(), more.end()); });
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
  file.finish();
  return bytes;
}

void write_capture(const Capture& capture, const std::filesystem::path& path, const EncodeOptions& options) {
  write_file_atomically(path, encode_capture(capture, options), MissingFolder::refuse);
}

}  // namespace subpixel::capture
