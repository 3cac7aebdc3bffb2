// A capture on disk of which only what is asked for is read: a frame of a large one costs what the frame draws with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/mapped_file.hpp"
#include "capture_format/capture.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/reading/chunk_reader.hpp"
#include "capture_format/reading/record_reader.hpp"

namespace subpixel::capture {

class CaptureFile {
 public:
  // Checks header, footer, index and the chunks' headers, not their payloads: each is verified when it is read. The
  // file must not be cut short while this lives. Throws InputError as read_capture() does.
  explicit CaptureFile(const std::filesystem::path& path, const ReadLimits& limits = {});

  const Metadata& metadata() const { return metadata_; }
  std::size_t frame_count() const { return frames_.size(); }

  // Strips and fans as the triangle lists that they stand for, which is what a replay draws, or as they are in the
  // file, for what writes them again.
  enum class Triangles { lists, as_stored };

  // Frames `first` to `last` (below frame_count()), and those of `also` that are, with the buffers, textures and
  // materials they use, in the order of the file and numbered anew. The other frames are there by number but empty,
  // except that frame 0 always has its size, camera and lights. Throws InputError for what is wrong of all this.
  Capture load(std::size_t first, std::size_t last, Triangles triangles = Triangles::lists,
               std::span<const std::uint32_t> also = {}) const;

  // All frames and materials, and buffers and textures without their bytes, of which `buffer_bytes` and `texture_bytes`
  // are the sizes.
  struct Outline {
    Capture capture;
    std::vector<std::uint64_t> buffer_bytes, texture_bytes;
  };
  Outline outline() const;

 private:
  std::vector<std::byte> payload(const ChunkAt& chunk) const;
  std::vector<Material> materials() const;
  Frame frame(std::size_t number, std::size_t material_count) const;
  const ChunkAt& data_chunk(FieldReader& in) const;

  std::string name_;
  ReadLimits limits_;
  MappedFile file_;
  std::unique_ptr<RecordReader> records_;
  std::vector<ChunkAt> data_, buffers_, textures_, materials_, frames_;
  std::vector<std::uint64_t> buffer_bytes_;
  Metadata metadata_;
};

}  // namespace subpixel::capture
