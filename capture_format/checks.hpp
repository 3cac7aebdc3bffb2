// The rules a capture's parts obey, in one place: the reader and the recorder throw on the first broken one, the
// validator collects them all.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Called for each broken rule with the field ("position.offset") and the reason. It may throw.
using Report = std::function<void(std::string_view field, const std::string& why)>;

bool is_utf8(std::string_view text);

void check_metadata(const Metadata& metadata, const Report& report);
void check_buffer(const Buffer& buffer, const Report& report);
void check_texture(const Texture& texture, const Report& report);
// Of a texture that has so many bytes, whether or not they are there.
void check_texture(const Texture& texture, std::uint64_t bytes, const Report& report);

// Texture numbers are checked against `texture_count`.
void check_material(const Material& material, std::size_t texture_count, const Report& report);

// Everything of a frame but its draws: size, matrices, lights, all finite.
void check_frame(const Frame& frame, const Report& report);

// The number of a frame's draws and of their triangles.
void check_draw_list(const Frame& frame, const Report& report);

// What the references and ranges of a draw are held to.
struct DrawBounds {
  std::span<const std::uint64_t> buffer_bytes;  // of each buffer
  std::size_t materials = 0;
};

std::vector<std::uint64_t> sizes_of(const std::vector<Buffer>& buffers);

// Everything of a draw but the values of its indices: references, ranges inside buffers, counts.
void check_draw(const DrawBounds& bounds, const Draw& draw, const Report& report);

// Whether every index of a draw but those that restart it, base_vertex added, is below vertex_count. Draws whose other
// rules are broken must not be given to it. Ranges met before cost nothing, so one checker serves all frames of one
// capture, whose buffers may grow in number but not change.
class IndexChecker {
 public:
  // `bytes_of` gives the bytes of a buffer, and is asked only for ranges that were not met before.
  void check(const Draw& draw, const std::function<std::span<const std::byte>(std::uint32_t buffer)>& bytes_of,
             const Report& report);
  void check(const Capture& capture, const Draw& draw, const Report& report);

 private:
  struct Range {
    std::uint32_t lowest, highest;
  };
  using Key = std::tuple<std::uint32_t, IndexType, std::uint64_t, std::uint32_t, bool>;  // ..., offset, count, restart

  std::map<Key, Range> ranges_;
  std::uint64_t indices_read_ = 0;
};

}  // namespace subpixel::capture
