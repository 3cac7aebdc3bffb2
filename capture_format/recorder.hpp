// What an engine links to record its own frames; docs/recording.md has an example.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/checks.hpp"

namespace subpixel::capture {

// Order of calls: resources may be added at any time, but before the draw that refers to them; draw() only between
// begin_frame() and end_frame(). Everything is copied, so the caller's memory is free after each call. What is wrong is
// refused at the call that brings it, with UsageError naming the field, and std::bad_alloc says that memory ran out;
// either way nothing was added, and the recorder stays usable. Only a frame that end_frame() throws on is gone, with
// its draws; what was added for it keeps its numbers. Not for several threads at once.
class Recorder {
 public:
  explicit Recorder(Metadata metadata);

  // The number to use in Draw and VertexStream. Bytes added before give the number they got then, so an engine may
  // hand over its buffers anew for every frame.
  std::uint32_t add_buffer(std::string name, std::span<const std::byte> bytes);

  // The number to use in Material. Equal textures with equal samplers are one.
  std::uint32_t add_texture(Texture texture);

  // The number to use in Draw.
  std::uint32_t add_material(Material material);

  // Starts a frame with the given size, matrices, lights and time; its draws must be empty.
  void begin_frame(Frame frame);

  // Adds a draw call to the frame begun.
  void draw(Draw draw);

  // Whether or not it throws, no frame is begun then, and the next one may be.
  void end_frame();

  // The frames ended so far with all resources.
  const Capture& capture() const { return capture_; }

  // The same without a copy; the recorder is empty then.
  Capture take();

  // Writes the frames ended so far; throws InputError when the file can't be written, UsageError inside a frame.
  void save(const std::filesystem::path& path) const;

 private:
  Capture capture_;
  std::optional<Frame> frame_;
  std::vector<std::uint64_t> buffer_bytes_;
  IndexChecker indices_;
  std::map<std::string, std::uint32_t> buffers_, textures_;  // by content hash
};

}  // namespace subpixel::capture
