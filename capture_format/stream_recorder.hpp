// Records frames into a file as they come, for engines: memory stays small, and a crash leaves the frames before it.
// recorder.hpp is the same in memory; docs/recording.md has examples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {

struct StreamOptions {
  int zstd_level = 1;                         // 0: payloads are stored as they are
  std::uint64_t queued_bytes = 256ull << 20;  // that may wait to be written before calls wait
  std::uint64_t kept_bytes = 256ull << 20;    // of buffers that stay in memory; others are read back when needed
  std::uint64_t most_bytes = ReadLimits{}.decoded_bytes;  // of all records, uncompressed: what readers take
};

// Compressing and writing happen in a thread of its own. The file is PATH.part until finish() makes it PATH; when the
// process ends without, `subpixel repair PATH.part PATH` keeps every frame that was written. An older .part is never
// written over: the new one is then called PATH.2.part, and so on.
//
// Order of calls: as of Recorder. What is wrong is refused at the call that brings it, with UsageError naming the
// field, and std::bad_alloc says that memory ran out; either way nothing was added, and the recorder stays usable. Only
// a frame that end_frame() throws on is gone, with its draws; buffers, textures and materials keep their numbers. When
// the file can't be written (a full disk), the next call throws InputError, and so do all after it. Not for several
// threads at once.
class StreamRecorder {
 public:
  StreamRecorder(const Metadata& metadata, const std::filesystem::path& path, const StreamOptions& options = {});
  ~StreamRecorder();
  StreamRecorder(const StreamRecorder&) = delete;
  StreamRecorder& operator=(const StreamRecorder&) = delete;

  // The number to use in Draw and VertexStream. Bytes added before give the number they got then: an engine may hand
  // over what it draws from anew for every frame, and what has changed is stored as one more buffer.
  std::uint32_t add_buffer(const std::string& name, std::span<const std::byte> bytes);

  // The number to use in Material. Equal textures with equal samplers are one.
  std::uint32_t add_texture(const Texture& texture);

  // The number to use in Draw.
  std::uint32_t add_material(Material material);

  // Starts a frame with the given size, matrices, lights and time; its draws must be empty.
  void begin_frame(Frame frame);
  void draw(Draw draw);

  // Whether or not it throws, no frame is begun then, and the next one may be.
  void end_frame();

  // Writes what is left, and gives the file its name. Nothing may be called after it. Materials that no frame draws
  // with and for which there is no room any more are left out.
  void finish();

  // Where the frames are until then.
  const std::filesystem::path& part_path() const { return part_path_; }

 private:
  class Writer;  // the thread
  struct Chunk;
  using Numbers = std::map<std::string, std::uint32_t>;  // by content hash

  std::uint32_t data_number(const std::string& hash, std::span<const std::byte> bytes, std::list<Chunk>& chunks,
                            Numbers& fresh) const;
  std::list<Chunk> materials_to_write() const;
  void forget_written_materials(std::size_t chunks);
  std::span<const std::byte> bytes_of(std::uint32_t buffer);
  void keep(std::map<std::uint32_t, std::vector<std::byte>> one);

  StreamOptions options_;
  std::filesystem::path path_, part_path_;
  std::unique_ptr<Writer> writer_;
  Numbers data_, buffers_, textures_;
  std::vector<std::uint64_t> buffer_bytes_;
  std::vector<std::uint32_t> buffer_data_;                // which DATA chunk
  std::map<std::uint32_t, std::vector<std::byte>> kept_;  // bytes of the newest buffers
  std::uint64_t kept_total_ = 0;
  std::uint32_t texture_count_ = 0, material_count_ = 0, material_chunks_ = 0, frame_count_ = 0;
  std::vector<Material> new_materials_;  // since the last frame
  std::optional<Frame> frame_;
  IndexChecker indices_;
};

}  // namespace subpixel::capture
