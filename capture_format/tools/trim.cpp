#include "capture_format/tools/trim.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/printable.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/tools/draw_selection.hpp"
#include "capture_format/tools/draw_streams.hpp"

namespace subpixel::capture {
namespace {

std::size_t draws_in(const Capture& capture) {
  std::size_t count = 0;
  for (const Frame& frame : capture.frames) count += frame.draws.size();
  return count;
}

void keep_frames(Capture& capture, std::pair<std::uint32_t, std::uint32_t> range) {
  const auto [first, last] = range;
  const std::size_t count = capture.frames.size();
  if (first > last || last >= count) {
    throw UsageError("frames",
                     std::to_string(first) + "-" + std::to_string(last) + " is not within 0-" +
                         std::to_string(std::max<std::size_t>(count, 1) - 1),
                     "--frames");
  }
  capture.frames.erase(capture.frames.begin() + last + 1, capture.frames.end());
  capture.frames.erase(capture.frames.begin(), capture.frames.begin() + first);
}

void keep_draws(Capture& capture, const TrimOptions& options) {
  DrawSelection selection(options.keep ? *options.keep : *options.drop, options.keep ? "--draws" : "--without");
  for (Frame& frame : capture.frames) {
    const std::vector<bool> selected = selection.of(frame);
    std::vector<Draw> kept;
    for (std::size_t d = 0; d < frame.draws.size(); ++d) {
      if (selected[d] == options.keep.has_value()) kept.push_back(std::move(frame.draws[d]));
    }
    frame.draws = std::move(kept);
  }
  selection.require_all_met();
  if (draws_in(capture) == 0) throw UsageError("draws", "none is left", options.keep ? "--draws" : "--without");
}

// The members of `all` that are in `used`, and where each went.
template <typename T>
std::map<std::uint32_t, std::uint32_t> keep_used(std::vector<T>& all, const std::set<std::uint32_t>& used) {
  std::map<std::uint32_t, std::uint32_t> numbers;
  std::vector<T> kept;
  for (const std::uint32_t number : used) {
    numbers.emplace(number, static_cast<std::uint32_t>(kept.size()));
    kept.push_back(std::move(all[number]));
  }
  all = std::move(kept);
  return numbers;
}

void drop_unused_materials(Capture& capture) {
  std::set<std::uint32_t> materials, textures;
  for (const Frame& frame : capture.frames) {
    for (const Draw& draw : frame.draws) materials.insert(draw.material);
  }
  const auto material_numbers = keep_used(capture.materials, materials);
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) draw.material = material_numbers.at(draw.material);
  }
  for (const Material& material : capture.materials) {
    for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
      if (material.*slot.member != kNone) textures.insert(material.*slot.member);
    }
  }
  const auto texture_numbers = keep_used(capture.textures, textures);
  for (Material& material : capture.materials) {
    for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
      if (material.*slot.member != kNone) material.*slot.member = texture_numbers.at(material.*slot.member);
    }
  }
}

using Place = std::tuple<std::uint32_t, VertexFormat, std::uint64_t, std::uint32_t>;
using VertexSet = std::pair<std::array<Place, kStreamsOfDraw.size()>, std::uint32_t>;

VertexSet vertex_set(const Draw& draw) {
  VertexSet set{{}, draw.vertex_count};
  for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
    const VertexStream& stream = draw.*kStreamsOfDraw[i].member;
    set.first[i] = {stream.buffer, stream.format, stream.offset, stream.stride};
  }
  return set;
}

struct Range {
  std::uint32_t lowest = kNone, highest = 0;  // lowest above highest: nothing

  void add(const Range& other) {
    lowest = std::min(lowest, other.lowest);
    highest = std::max(highest, other.highest);
  }
  bool empty() const { return lowest > highest; }
};

// The vertices that draws name, those of strips too which make no triangle: they have to be there. Ranges of indices
// that were met before cost nothing.
class VertexReads {
 public:
  explicit VertexReads(const Capture& capture) : capture_(capture) {}

  Range of(const Draw& draw) {
    const Key key{draw.index_buffer, draw.index_type,  draw.index_offset,
                  draw.index_count,  draw.base_vertex, draw.restart};
    const auto [found, is_new] = ranges_.try_emplace(key);
    if (is_new) {
      for (const std::uint32_t vertex : named_vertices(capture_, draw)) found->second.add({vertex, vertex});
    }
    return found->second;
  }

 private:
  using Key = std::tuple<std::uint32_t, IndexType, std::uint64_t, std::uint32_t, std::int32_t, bool>;
  const Capture& capture_;
  std::map<Key, Range> ranges_;
};

// Draws that share all their streams go on sharing them: a replay has such vertices once.
void narrow_vertices(Capture& capture) {
  VertexReads reads(capture);
  std::map<VertexSet, Range> read;
  std::map<VertexSet, std::int32_t> lowest_base;
  for (const Frame& frame : capture.frames) {
    for (const Draw& draw : frame.draws) {
      const VertexSet set = vertex_set(draw);
      read[set].add(reads.of(draw));
      const auto [base, is_new] = lowest_base.try_emplace(set, draw.base_vertex);
      base->second = std::min(base->second, draw.base_vertex);
    }
  }
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) {
      const VertexSet set = vertex_set(draw);
      const Range& range = read.at(set);
      // A base that leaves its 32 bits would be none.
      if (range.empty() ||
          std::int64_t{lowest_base.at(set)} - range.lowest < std::numeric_limits<std::int32_t>::min()) {
        continue;
      }
      for (const StreamOfDraw& each : kStreamsOfDraw) {
        VertexStream& stream = draw.*each.member;
        if (stream.buffer != kNone) stream.offset += std::uint64_t{range.lowest} * stream.stride;
      }
      // Draws without triangles keep their place at 0: it is no vertex that would have to move along.
      draw.base_vertex = draw.index_count == 0 && draw.index_type == IndexType::none
                             ? 0
                             : static_cast<std::int32_t>(std::int64_t{draw.base_vertex} - range.lowest);
      draw.vertex_count = range.highest - range.lowest + 1;
    }
  }
}

// Calls `act` with each range of bytes that the draw reads: its buffer, its offset and how many bytes.
template <typename Act>
void each_range(Draw& draw, Act act) {
  for (const StreamOfDraw& each : kStreamsOfDraw) {
    VertexStream& stream = draw.*each.member;
    if (stream.buffer == kNone) continue;
    const std::uint64_t bytes =
        draw.vertex_count == 0 ? 0
                               : std::uint64_t{draw.vertex_count - 1} * stream.stride + element_bytes(stream.format);
    act(stream.buffer, stream.offset, bytes);
  }
  if (draw.index_type != IndexType::none) {
    act(draw.index_buffer, draw.index_offset, std::uint64_t{draw.index_count} * index_bytes(draw.index_type));
  }
  if (draw.instance_buffer != kNone) {
    act(draw.instance_buffer, draw.instance_offset, std::uint64_t{draw.instance_count} * sizeof(Matrix4));
  }
}

// Buffers of equal bytes become one: a file has their bytes once, which parts of each might not be.
void unite_equal_buffers(Capture& capture) {
  std::map<std::string, std::uint32_t> first_of;  // by content
  std::vector<std::uint32_t> numbers;
  for (const Buffer& buffer : capture.buffers) {
    numbers.push_back(first_of.emplace(content_hash_hex(buffer.bytes), numbers.size()).first->second);
  }
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) {
      each_range(draw, [&](std::uint32_t& buffer, std::uint64_t&, std::uint64_t) { buffer = numbers[buffer]; });
    }
  }
}

// Ranges of one buffer that stay, and where they go.
class KeptBytes {
 public:
  void add(std::uint64_t offset, std::uint64_t bytes) {
    if (bytes > 0) ranges_.emplace_back(offset, offset + bytes);
  }

  // Merges what overlaps. Whole multiples of 16 bytes go, so that what was aligned stays so.
  void settle() {
    std::sort(ranges_.begin(), ranges_.end());
    std::uint64_t end = 0, removed = 0;
    for (const auto& [first, last] : ranges_) {
      if (first > end || pieces_.empty()) {
        removed += (first - end) / kAlignment * kAlignment;
        pieces_.push_back({first, std::max(first, end), removed});
      }
      end = std::max(end, last);
      pieces_.back().end = end;
    }
    ranges_.clear();
  }

  std::uint64_t moved(std::uint64_t offset) const {
    const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                                        [](std::uint64_t at, const Piece& piece) { return at < piece.begin; });
    return offset - std::prev(after)->removed;
  }

  std::vector<std::byte> cut(const std::vector<std::byte>& bytes) const {
    std::vector<std::byte> kept;
    for (const Piece& piece : pieces_) {
      kept.resize(piece.begin - piece.removed);  // bytes between two ranges that alignment keeps are 0
      kept.insert(kept.end(), bytes.begin() + static_cast<std::ptrdiff_t>(piece.begin),
                  bytes.begin() + static_cast<std::ptrdiff_t>(piece.end));
    }
    return kept;
  }

 private:
  static constexpr std::uint64_t kAlignment = 16;
  struct Piece {
    std::uint64_t begin, end, removed;  // bytes that go before it
  };
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges_;
  std::vector<Piece> pieces_;
};

void drop_unread_bytes(Capture& capture) {
  std::map<std::uint32_t, KeptBytes> kept;
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) {
      each_range(draw, [&](std::uint32_t buffer, std::uint64_t offset, std::uint64_t bytes) {
        kept[buffer].add(offset, bytes);
      });
    }
  }
  std::set<std::uint32_t> used;
  for (auto& [number, bytes] : kept) {
    bytes.settle();
    capture.buffers[number].bytes = bytes.cut(capture.buffers[number].bytes);
    used.insert(number);
  }
  const auto numbers = keep_used(capture.buffers, used);
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) {
      each_range(draw, [&](std::uint32_t& buffer, std::uint64_t& offset, std::uint64_t bytes) {
        offset = bytes == 0 ? 0 : kept.at(buffer).moved(offset);
        buffer = numbers.at(buffer);
      });
    }
  }
}

}  // namespace

Capture trim(Capture capture, const TrimOptions& options) {
  if (options.keep && options.drop) throw UsageError("draws", "--draws and --without exclude each other", "--without");
  if (!options.frames && !options.keep && !options.drop) {
    throw UsageError("can't trim", "nothing is said to be left out: --frames, --draws or --without", "");
  }
  const std::size_t frames_before = capture.frames.size();
  if (options.frames) keep_frames(capture, *options.frames);
  const std::size_t draws_before = draws_in(capture);
  if (options.keep || options.drop) keep_draws(capture, options);
  drop_unused_materials(capture);
  unite_equal_buffers(capture);
  narrow_vertices(capture);
  drop_unread_bytes(capture);

  std::string notice = "trimmed:";
  if (options.frames) {
    const auto [first, last] = *options.frames;
    notice += first == last ? " frame " : " frames " + std::to_string(first) + " to ";
    notice += std::to_string(last) + " of " + std::to_string(frames_before);
  }
  if (options.keep || options.drop) {
    notice += std::string(options.frames ? ";" : "") + " " + std::to_string(draws_in(capture)) + " of " +
              std::to_string(draws_before) + " draws, " + (options.keep ? "those of " : "without ") +
              printable(options.keep ? *options.keep : *options.drop, 200);
  }
  std::vector<std::string>& notices = capture.metadata.notices;
  if (notices.size() >= kMaxNotices) notices.pop_back();
  notices.push_back(std::move(notice));
  return capture;
}

}  // namespace subpixel::capture
