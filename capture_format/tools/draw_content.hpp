// What a capture's draws are by content: hashes of what they show, and where it is. Private to the tools.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/tools/draw_streams.hpp"

namespace subpixel::capture {

// 128 bits of XXH3: equal hashes are taken as equal content, as the writer does.
using Hash = std::pair<std::uint64_t, std::uint64_t>;

// The smallest box of points along the axes, in doubles so that sizes of floats can't overflow.
struct Box {
  std::array<double, 3> low, high;  // low above high where there is no point

  Box();
  void add(const std::array<double, 3>& point);
  bool empty() const { return low[0] > high[0]; }
  double diagonal() const;               // of one that is not empty
  std::array<double, 3> middle() const;  // the same
};

// How far a face of `a` is from that of `b`, the farthest of the six; infinite when one is empty.
double distance(const Box& a, const Box& b);

struct MeshContent {
  std::array<Hash, kStreamsOfDraw.size()> streams;  // of the values at the triangles' corners
  std::array<bool, kStreamsOfDraw.size()> present;
  std::uint64_t triangles = 0;
  Hash all;
  Box box;  // of the corners that are finite, before the transform
};

// Everything is computed once, however many draws and frames share it. The capture must be one that was read, and
// outlive this.
class DrawContents {
 public:
  explicit DrawContents(const Capture& capture);

  const Capture& capture() const { return capture_; }

  const MeshContent& mesh(const Draw& draw);
  const Hash& material(std::uint32_t number) const { return materials_[number]; }

  // Nothing where the material has none.
  std::optional<Hash> texture(std::uint32_t number) const {
    return number == kNone ? std::nullopt : std::optional(textures_[number]);
  }

  // Of the world matrices of all instances, in their order.
  Hash placement(const Draw& draw) const;

  // Of all instances in world space. As long as the draw's triangles times its instances.
  Box world_box(const Draw& draw) const;

 private:
  using StreamKey = std::tuple<std::uint32_t, VertexFormat, std::uint64_t, std::uint32_t>;
  using MeshKey = std::tuple<std::array<StreamKey, kStreamsOfDraw.size()>, std::uint32_t, IndexType, std::uint64_t,
                             std::uint32_t, std::int32_t>;

  MeshContent read_mesh(const Draw& draw) const;
  Hash material_hash(const Material& material) const;

  const Capture& capture_;
  std::vector<Hash> textures_, materials_;
  std::map<MeshKey, MeshContent> meshes_;
};

// How far the farthest point of the mesh's box went between the transforms of `a` and of `b`, of all instances; nothing
// when these are not as many, or the mesh is empty.
std::optional<double> moved_distance(const Capture& in_a, const Draw& a, const Capture& in_b, const Draw& b,
                                     const Box& mesh);

}  // namespace subpixel::capture
