#include "capture_format/reading/reader.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/reading/chunk_reader.hpp"
#include "capture_format/reading/record_reader.hpp"
#include "capture_format/streams.hpp"

namespace subpixel::capture {
namespace {

// The bytes of DATA chunks, decoded at first use. Chunks are used more than once when contents were equal.
class DataChunks {
 public:
  DataChunks(std::span<const std::byte> file, const ReadLimits& limits)
      : file_(file), bytes_left_(limits.decoded_bytes) {}

  void add(const ChunkAt& chunk) { chunks_.push_back({chunk, false}); }

  std::vector<std::byte> take(FieldReader& in) {
    const auto number = in.get<std::uint32_t>("data");
    if (number >= chunks_.size()) {
      in.fail("data", std::to_string(number) + " is not below " + std::to_string(chunks_.size()));
    }
    Entry& entry = chunks_[number];
    // Sharing multiplies bytes in memory that the chunk sizes counted once.
    if (entry.chunk.header.decoded_bytes > bytes_left_) in.fail("data", "too many bytes in all buffers and textures");
    bytes_left_ -= entry.chunk.header.decoded_bytes;
    entry.used = true;
    return decode_chunk(file_, entry.chunk);
  }

  // Bytes nobody refers to were never verified, so there may be none.
  void require_all_used() const {
    for (const Entry& entry : chunks_) {
      if (!entry.used) {
        fail_reading("no buffer or texture refers to it", entry.chunk.offset,
                     chunk_name(entry.chunk.header.type, entry.chunk.header.id), "id");
      }
    }
  }

 private:
  struct Entry {
    ChunkAt chunk;
    bool used;
  };
  std::span<const std::byte> file_;
  std::uint64_t bytes_left_;
  std::vector<Entry> chunks_;
};

void require_fewer(const ChunkAt& chunk, std::size_t count, std::uint32_t most) {
  if (count >= most) {
    fail_reading("more than " + std::to_string(most) + " of this kind", chunk.offset,
                 chunk_name(chunk.header.type, chunk.header.id), "id");
  }
}

class CaptureReader {
 public:
  CaptureReader(std::span<const std::byte> file, std::uint32_t version, const ReadLimits& limits)
      : file_(file), version_(version), limits_(limits), records_(version), data_(file, limits) {}

  void read(const ChunkAt& chunk) {
    if (!is_known(chunk.header.type)) {
      verify_chunk(file_, chunk);
      skipped_.insert(chunk_name(chunk.header.type, chunk.header.id).substr(0, 4));
      return;
    }
    if (metadata_read_ == 0 && chunk.header.type != ChunkType::metadata && version_ >= 3) {
      fail_reading("stands before META", chunk.offset, chunk_name(chunk.header.type, chunk.header.id), "type");
    }
    if (chunk.header.type == ChunkType::data) {
      data_.add(chunk);
      return;
    }
    const std::vector<std::byte> payload = decode_chunk(file_, chunk);
    FieldReader in(payload, chunk);
    switch (chunk.header.type) {
      case ChunkType::metadata:
        require_fewer(chunk, metadata_read_, 1);
        capture_.metadata = records_.metadata(in);
        ++metadata_read_;
        break;
      case ChunkType::buffer:
        require_fewer(chunk, capture_.buffers.size(), kMaxBuffers);
        read_buffer(in);
        break;
      case ChunkType::texture:
        require_fewer(chunk, capture_.textures.size(), kMaxTextures);
        read_texture(in);
        break;
      case ChunkType::material:
        if (version_ < 3) require_fewer(chunk, materials_read_, 1);
        read_materials(in);
        break;
      case ChunkType::frame:
        require_fewer(chunk, capture_.frames.size(), kMaxFrames);
        capture_.frames.push_back(
            records_.frame(in, {buffer_bytes_, capture_.materials.size()},
                           [this](const Draw& draw, const Report& report) { indices_.check(capture_, draw, report); }));
        break;
      case ChunkType::data:
      case ChunkType::index:
        fail_reading("not expected here", chunk.offset, chunk_name(chunk.header.type, chunk.header.id), "type");
    }
    in.finish();
  }

  Capture finish() {
    if (metadata_read_ == 0) fail_reading("chunk META is missing", 0, "", "");
    if (materials_read_ == 0) fail_reading("chunk MATL is missing", 0, "", "");
    data_.require_all_used();
    return finish_recovered();
  }

  // What was read so far, whatever is missing of it.
  Capture finish_recovered() {
    if (metadata_read_ == 0) fail_reading("chunk META is missing", 0, "", "");
    add_skip_notice(capture_.metadata, skipped_);
    make_triangle_lists(capture_, limits_.decoded_bytes);
    return std::move(capture_);
  }

 private:
  void read_buffer(FieldReader& in) {
    Buffer buffer = records_.buffer(in, [this](FieldReader& fields) { return data_.take(fields); });
    check_buffer(buffer, fail_in(in));
    buffer_bytes_.push_back(buffer.bytes.size());
    capture_.buffers.push_back(std::move(buffer));
  }

  void read_texture(FieldReader& in) {
    Texture texture = records_.texture(in, [this](FieldReader& fields) { return data_.take(fields); });
    check_texture(texture, fail_in(in));
    capture_.textures.push_back(std::move(texture));
  }

  void read_materials(FieldReader& in) {
    std::vector<Material> more = records_.materials(in, capture_.textures.size());
    if (more.size() > kMaxMaterials - capture_.materials.size()) {
      in.fail("materials", "more than " + std::to_string(kMaxMaterials) + " in all");
    }
    std::move(more.begin(), more.end(), std::back_inserter(capture_.materials));
    ++materials_read_;
  }

  std::span<const std::byte> file_;
  std::uint32_t version_;
  ReadLimits limits_;
  RecordReader records_;
  Capture capture_;
  DataChunks data_;
  std::vector<std::uint64_t> buffer_bytes_;
  IndexChecker indices_;
  std::set<std::string> skipped_;  // kinds of chunks that are not known
  std::size_t metadata_read_ = 0;
  std::size_t materials_read_ = 0;
};

std::vector<std::byte> file_bytes(const std::filesystem::path& path, const ReadLimits& limits) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw InputError("the capture can't be read", "the file can't be opened", path.string());
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);  // fails on folders and devices
  if (error) throw InputError("the capture can't be read", error.message(), path.string());
  if (size > limits.file_bytes) {
    throw InputError("the capture can't be read", "larger than " + std::to_string(limits.file_bytes) + " bytes",
                     path.string());
  }
  std::vector<std::byte> bytes(size);
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
    throw InputError("the capture can't be read", "the file ends early", path.string());
  }
  return bytes;
}

// `name` in front of what reading its bytes throws.
template <typename Read>
auto reading(const std::filesystem::path& path, const ReadLimits& limits, Read read) {
  const std::vector<std::byte> bytes = file_bytes(path, limits);
  try {
    return read(bytes);
  } catch (const InputError& error) {
    throw InputError(path.string(), error.what(), "");
  }
}

}  // namespace

Capture decode_capture(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const ChunkList list = list_chunks(bytes, limits);
  CaptureReader reader(bytes, list.version, limits);
  for (const ChunkAt& chunk : list.chunks) reader.read(chunk);
  return reader.finish();
}

Capture read_capture(const std::filesystem::path& path, const ReadLimits& limits) {
  return reading(path, limits, [&](std::span<const std::byte> bytes) { return decode_capture(bytes, limits); });
}

Recovered recover_capture(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const WholeChunks whole = list_whole_chunks(bytes, limits);
  CaptureReader reader(bytes, whole.list.version, limits);
  std::string stopped = whole.stopped;
  try {
    for (const ChunkAt& chunk : whole.list.chunks) reader.read(chunk);
  } catch (const InputError& error) {
    stopped = error.what();
  }
  return {reader.finish_recovered(), std::move(stopped)};
}

Recovered recover_capture(const std::filesystem::path& path, const ReadLimits& limits) {
  return reading(path, limits, [&](std::span<const std::byte> bytes) { return recover_capture(bytes, limits); });
}

}  // namespace subpixel::capture
