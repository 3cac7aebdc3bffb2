// Nodes of a glTF scene: their transforms at a time, which the file's animation may change (sections 3.5, 3.7.3
// and 3.11). Private to gltf.cpp.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/import/gltf_document.hpp"

namespace subpixel::capture {

struct GltfNode {
  std::string name;
  std::vector<std::size_t> children;
  std::optional<glm::dmat4> matrix;  // instead of the three:
  glm::dvec3 translation{0, 0, 0};
  glm::dvec4 rotation{0, 0, 0, 1};  // unit quaternion, real part last
  glm::dvec3 scale{1, 1, 1};
  std::vector<double> weights;  // of morph targets; empty: the mesh's
};

glm::dmat4 local_matrix(const GltfNode& node);
glm::dmat4 rotation_matrix(const glm::dvec4& quaternion);

// One of the file's animations.
class GltfAnimation {
 public:
  // Throws InputError naming the channel that is wrong. Channels that animate what is not known are left out with a
  // notice.
  GltfAnimation(const GltfDocument& document, std::size_t index, std::vector<std::string>& notices);

  double duration_s() const { return duration_s_; }
  void apply(double time_s, std::vector<GltfNode>& nodes) const;

 private:
  enum class Path { translation, rotation, scale, weights };
  enum class Interpolation { linear, step, cubic };
  struct Channel {
    std::size_t node = 0;
    Path path = Path::translation;
    Interpolation interpolation = Interpolation::linear;
    std::vector<double> times;   // strictly ascending, at least one
    std::size_t components = 3;  // of one key's value
    std::vector<double> values;  // components for each key; cubic: in-tangent, value, out-tangent
  };

  static std::vector<double> value_at(const Channel& channel, double time_s);

  std::vector<Channel> channels_;
  double duration_s_ = 0;
};

// All nodes of the file.
std::vector<GltfNode> read_nodes(const GltfDocument& document);

// A node of the scene in the order of the file's tree, parents first. A node may stand in several places.
struct GltfPlace {
  std::size_t node = 0;
  glm::dmat4 world{1.0};
};

// The chosen scene (its `scene`, else the first; without scenes all nodes that are no child). Throws InputError for a
// node that is its own ancestor.
std::vector<std::size_t> scene_roots(const GltfDocument& document, const std::vector<GltfNode>& nodes,
                                     std::vector<std::string>& notices);
std::vector<GltfPlace> placed_nodes(const GltfDocument& document, const std::vector<GltfNode>& nodes,
                                    const std::vector<std::size_t>& roots);

}  // namespace subpixel::capture
