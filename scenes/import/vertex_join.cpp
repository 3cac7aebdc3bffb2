#include "scenes/import/vertex_join.hpp"

#include <bit>
#include <cstdint>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace subpixel::capture {
namespace {

// All attributes of one vertex as the bits of doubles, to compare and to hash.
class VertexBits {
 public:
  explicit VertexBits(const Mesh& mesh) : mesh_(mesh) {
    read(0, bits_);
    width_ = bits_.size();
    bits_.reserve(mesh.positions.size() * width_);
    for (std::size_t i = 1; i < mesh.positions.size(); ++i) read(i, bits_);
  }

  std::string_view of(std::uint32_t vertex) const {
    return {reinterpret_cast<const char*>(bits_.data() + vertex * width_), width_ * sizeof(std::uint64_t)};
  }

 private:
  void read(std::size_t i, std::vector<std::uint64_t>& bits) const {
    const auto put = [&](const auto& list) {
      if (list.empty()) return;
      for (int c = 0; c < list[i].length(); ++c) {
        const double value = static_cast<double>(list[i][c]);
        bits.push_back(std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value));  // -0 is 0
      }
    };
    put(mesh_.positions);
    put(mesh_.normals);
    put(mesh_.uvs);
    put(mesh_.tangents);
    put(mesh_.uvs2);
    put(mesh_.colours);
  }

  const Mesh& mesh_;
  std::vector<std::uint64_t> bits_;
  std::size_t width_ = 0;
};

}  // namespace

void join_equal_vertices(Mesh& mesh) {
  if (mesh.positions.empty()) return;
  const VertexBits bits(mesh);
  std::unordered_map<std::string_view, std::uint32_t> numbers;
  Mesh joined;
  const auto take = [](auto& to, const auto& from, std::uint32_t vertex) {
    if (!from.empty()) to.push_back(from[vertex]);
  };
  for (const std::uint32_t vertex : mesh.indices) {
    const auto [known, is_new] =
        numbers.try_emplace(bits.of(vertex), static_cast<std::uint32_t>(joined.positions.size()));
    if (is_new) {
      take(joined.positions, mesh.positions, vertex);
      take(joined.normals, mesh.normals, vertex);
      take(joined.uvs, mesh.uvs, vertex);
      take(joined.tangents, mesh.tangents, vertex);
      take(joined.uvs2, mesh.uvs2, vertex);
      take(joined.colours, mesh.colours, vertex);
    }
    joined.indices.push_back(known->second);
  }
  mesh = std::move(joined);
}

}  // namespace subpixel::capture
