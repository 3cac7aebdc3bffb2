#include "scenes/import/gltf_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "scenes/builder/camera.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr std::size_t kMostPlaces = std::size_t{1} << 20;  // of nodes: what a frame may have of draws

glm::dvec3 vec3_of(const std::vector<double>& v) {
  return {v[0], v[1], v[2]};
}

// Unit; the identity for a quaternion of no length.
glm::dvec4 normalised(const glm::dvec4& q) {
  const double length = glm::length(q);
  return length > 0 ? q / length : glm::dvec4(0, 0, 0, 1);
}

}  // namespace

glm::dmat4 rotation_matrix(const glm::dvec4& q) {
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  glm::dmat4 m(1.0);
  m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
  m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
  m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
  return m;
}

glm::dmat4 local_matrix(const GltfNode& node) {
  if (node.matrix) return *node.matrix;
  return translation(node.translation) * rotation_matrix(node.rotation) * scaling(node.scale);
}

std::vector<GltfNode> read_nodes(const GltfDocument& document) {
  const std::size_t count = document.count("nodes");
  std::vector<GltfNode> nodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    const GltfElement from = document.item("nodes", i);
    GltfNode& node = nodes[i];
    node.name = to_utf8(from.text("name", ""));
    for (const GltfElement& child : from.elements("children")) node.children.push_back(child.as_index(count));
    if (from.has("matrix")) {
      const std::vector<double> numbers = from.numbers("matrix", 16);
      glm::dmat4 matrix(1.0);
      for (std::size_t k = 0; k < 16; ++k) matrix[static_cast<int>(k / 4)][static_cast<int>(k % 4)] = numbers[k];
      node.matrix = matrix;
    }
    if (from.has("translation")) node.translation = vec3_of(from.numbers("translation", 3));
    if (from.has("scale")) node.scale = vec3_of(from.numbers("scale", 3));
    if (from.has("rotation")) {
      const std::vector<double> q = from.numbers("rotation", 4);
      node.rotation = normalised({q[0], q[1], q[2], q[3]});
    }
    if (const auto weights = from.find("weights")) node.weights = from.numbers("weights", weights->size());
  }
  return nodes;
}

std::vector<std::size_t> scene_roots(const GltfDocument& document, const std::vector<GltfNode>& nodes,
                                     std::vector<std::string>& notices) {
  std::vector<std::size_t> roots;
  const std::size_t scenes = document.count("scenes");
  if (scenes == 0) {
    std::vector<bool> is_child(nodes.size());
    for (const GltfNode& node : nodes) {
      for (const std::size_t child : node.children) is_child[child] = true;
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!is_child[i]) roots.push_back(i);
    }
    return roots;
  }
  const std::size_t chosen = document.root().find_index("scene", scenes).value_or(0);
  const GltfElement scene = document.item("scenes", chosen);
  for (const GltfElement& root : scene.elements("nodes")) roots.push_back(root.as_index(nodes.size()));
  if (scenes > 1) notices.push_back(fmt::format("ignored: {} other scenes; scene {} is shown", scenes - 1, chosen));
  return roots;
}

std::vector<GltfPlace> placed_nodes(const GltfDocument& document, const std::vector<GltfNode>& nodes,
                                    const std::vector<std::size_t>& roots) {
  struct Visit {
    GltfPlace place;
    std::size_t next_child;
  };
  std::vector<GltfPlace> places;
  std::vector<bool> is_ancestor(nodes.size());
  std::vector<Visit> path;  // no recursion: files decide how deep trees are
  const auto enter = [&](std::size_t node, const glm::dmat4& parent) {
    if (is_ancestor[node]) document.item("nodes", node).fail("the node is its own ancestor");
    if (places.size() == kMostPlaces) document.item("nodes", node).fail("more nodes in the tree than can be drawn");
    is_ancestor[node] = true;
    path.push_back({{node, parent * local_matrix(nodes[node])}, 0});
    places.push_back(path.back().place);
  };
  for (const std::size_t root : roots) {
    enter(root, glm::dmat4(1.0));
    while (!path.empty()) {
      Visit& visit = path.back();
      const std::vector<std::size_t>& children = nodes[visit.place.node].children;
      if (visit.next_child == children.size()) {
        is_ancestor[visit.place.node] = false;
        path.pop_back();
      } else {
        const std::size_t child = children[visit.next_child++];
        enter(child, glm::dmat4(visit.place.world));
      }
    }
  }
  return places;
}

GltfAnimation::GltfAnimation(const GltfDocument& document, std::size_t index, std::vector<std::string>& notices) {
  static constexpr std::string_view kScalar[] = {"SCALAR"};
  const GltfElement animation = document.item("animations", index);
  const std::vector<GltfElement> samplers = animation.elements("samplers");
  for (const GltfElement& from : animation.elements("channels")) {
    const GltfElement target = from.member("target");
    const std::optional<std::size_t> node = target.find_index("node", document.count("nodes"));
    const std::string path = target.text("path");
    Channel channel;
    if (path == "translation") {
      channel.path = Path::translation;
    } else if (path == "rotation") {
      channel.path = Path::rotation;
    } else if (path == "scale") {
      channel.path = Path::scale;
    } else if (path == "weights") {
      channel.path = Path::weights;
    }
    if (!node || (channel.path == Path::translation && path != "translation")) {
      notices.push_back("ignored: " + target.path() + ", which animates " + (node ? to_utf8(path) : "no node"));
      continue;
    }
    channel.node = *node;
    const GltfElement& sampler = samplers[from.index("sampler", samplers.size())];
    const std::string interpolation = sampler.text("interpolation", "LINEAR");
    if (interpolation == "STEP") {
      channel.interpolation = Interpolation::step;
    } else if (interpolation == "CUBICSPLINE") {
      channel.interpolation = Interpolation::cubic;
    } else if (interpolation != "LINEAR") {
      sampler.member("interpolation").fail("neither LINEAR, STEP nor CUBICSPLINE");
    }
    const std::size_t accessors = document.count("accessors");
    channel.times = document.values(sampler.index("input", accessors), sampler, kScalar).numbers;
    const GltfValues values = document.values(sampler.index("output", accessors), sampler, {});
    channel.values = values.numbers;
    if (channel.times.empty()) sampler.fail("no key");
    for (std::size_t i = 0; i < channel.times.size(); ++i) {
      if (!(channel.times[i] >= 0 && channel.times[i] <= 1e6) || (i > 0 && channel.times[i] <= channel.times[i - 1])) {
        sampler.fail(fmt::format("time {} of key {} does not follow the one before", channel.times[i], i));
      }
    }
    const std::size_t keys = channel.times.size() * (channel.interpolation == Interpolation::cubic ? 3 : 1);
    channel.components = channel.values.size() / keys;
    const std::size_t wanted = channel.path == Path::rotation ? 4 : 3;
    if (channel.components * keys != channel.values.size() ||
        (channel.path == Path::weights ? channel.components == 0 : channel.components != wanted)) {
      sampler.fail(fmt::format("{} numbers for {} keys", channel.values.size(), channel.times.size()));
    }
    duration_s_ = std::max(duration_s_, channel.times.back());
    channels_.push_back(std::move(channel));
  }
}

// Appendix C. Before the first and after the last key the value stays.
std::vector<double> GltfAnimation::value_at(const Channel& channel, double time_s) {
  const std::size_t width = channel.components;
  const bool cubic = channel.interpolation == Interpolation::cubic;
  const std::size_t key_width = cubic ? 3 * width : width, value_at_key = cubic ? width : 0;
  const auto value = [&](std::size_t key, std::size_t part, std::size_t c) {
    return channel.values[key * key_width + part + c];
  };
  const auto next_key = std::ranges::upper_bound(channel.times, time_s);
  const auto next = static_cast<std::size_t>(next_key - channel.times.begin());
  std::vector<double> result(width);
  if (next == 0 || next == channel.times.size() || channel.interpolation == Interpolation::step) {
    for (std::size_t c = 0; c < width; ++c) result[c] = value(next == 0 ? 0 : next - 1, value_at_key, c);
    return result;
  }
  const std::size_t last = next - 1;
  const double span = channel.times[next] - channel.times[last], t = (time_s - channel.times[last]) / span;
  if (cubic) {
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t c = 0; c < width; ++c) {
      result[c] = (2 * t3 - 3 * t2 + 1) * value(last, width, c) + span * (t3 - 2 * t2 + t) * value(last, 2 * width, c) +
                  (3 * t2 - 2 * t3) * value(next, width, c) + span * (t3 - t2) * value(next, 0, c);
    }
    return result;
  }
  double from_weight = 1 - t, to_weight = t;
  if (channel.path == Path::rotation) {  // spherical, along the shorter arc
    double cosine_between = 0;
    for (std::size_t c = 0; c < 4; ++c) cosine_between += value(last, 0, c) * value(next, 0, c);
    const double angle = std::acos(std::clamp(std::abs(cosine_between), 0.0, 1.0));
    if (angle > 1e-6) {
      from_weight = std::sin((1 - t) * angle) / std::sin(angle);
      to_weight = std::sin(t * angle) / std::sin(angle);
    }
    if (cosine_between < 0) to_weight = -to_weight;
  }
  for (std::size_t c = 0; c < width; ++c) {
    result[c] = from_weight * value(last, 0, c) + to_weight * value(next, 0, c);
  }
  return result;
}

void GltfAnimation::apply(double time_s, std::vector<GltfNode>& nodes) const {
  for (const Channel& channel : channels_) {
    const std::vector<double> value = value_at(channel, time_s);
    GltfNode& node = nodes[channel.node];
    switch (channel.path) {
      case Path::translation:
        node.translation = vec3_of(value);
        break;
      case Path::rotation:
        node.rotation = normalised({value[0], value[1], value[2], value[3]});
        break;
      case Path::scale:
        node.scale = vec3_of(value);
        break;
      case Path::weights:
        node.weights = value;
        break;
    }
    if (channel.path != Path::weights) node.matrix.reset();
  }
}

}  // namespace subpixel::capture
