#include "capture_format/tools/difference.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "base/hash.hpp"
#include "base/printable.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/tools/draw_streams.hpp"

namespace subpixel::capture {
namespace {

using nlohmann::json;

// 128 bits of XXH3: equal hashes are taken as equal content, as the writer does.
using Hash = std::pair<std::uint64_t, std::uint64_t>;

class Hasher {
 public:
  template <typename T>
  void add(const std::vector<T>& values) {
    hasher_.add(std::as_bytes(std::span(values)));
  }
  template <typename T>
  void add_value(const T& value) {
    hasher_.add(std::as_bytes(std::span(&value, 1)));
  }
  // Of equal numbers, which -0 and 0 are.
  void add_numbers(std::span<const float> values) {
    for (const float value : values) add_value(value + 0.0f);
  }
  Hash hash() const {
    const ContentHash hash = hasher_.hash();
    return {hash.high, hash.low};
  }

 private:
  ContentHasher hasher_;
};

struct Mesh {
  std::array<Hash, kStreamsOfDraw.size()> streams;  // of the values at the triangles' corners
  std::array<bool, kStreamsOfDraw.size()> present;
  std::uint64_t triangles = 0;
  Hash all;
};

// What a capture's draws are by content. Everything is computed once, however many draws and frames share it.
class Contents {
 public:
  explicit Contents(const Capture& capture) : capture_(capture) {
    for (const Texture& texture : capture.textures) {
      Hasher hasher;
      hasher.add(texture.bytes);
      hasher.add_value(std::array{static_cast<std::uint32_t>(texture.encoding), std::uint32_t{texture.srgb},
                                  texture.width, texture.height});
      hasher.add_value(texture.sampler);
      textures_.push_back(hasher.hash());
    }
    for (const Material& material : capture.materials) materials_.push_back(material_hash(material));
  }

  const Capture& capture() const { return capture_; }

  const Mesh& mesh(const Draw& draw) {
    MeshKey key{{}, draw.index_buffer, draw.index_type, draw.index_offset, draw.index_count, draw.base_vertex};
    for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
      const VertexStream& stream = draw.*kStreamsOfDraw[i].member;
      if (stream.buffer == kNone) {
        std::get<0>(key)[i] = {kNone, VertexFormat{}, 0, 0};
      } else {
        std::get<0>(key)[i] = {stream.buffer, stream.format, stream.offset, stream.stride};
      }
    }
    const auto [found, is_new] = meshes_.try_emplace(key);
    if (is_new) found->second = read_mesh(draw);
    return found->second;
  }

  const Hash& material(std::uint32_t number) const { return materials_[number]; }

  // Nothing where the material has none.
  std::optional<Hash> texture(std::uint32_t number) const {
    return number == kNone ? std::nullopt : std::optional(textures_[number]);
  }

  Hash placement(const Draw& draw) const {
    Hasher hasher;
    hasher.add(world_transforms(capture_, draw));
    return hasher.hash();
  }

 private:
  using StreamKey = std::tuple<std::uint32_t, VertexFormat, std::uint64_t, std::uint32_t>;
  using MeshKey = std::tuple<std::array<StreamKey, kStreamsOfDraw.size()>, std::uint32_t, IndexType, std::uint64_t,
                             std::uint32_t, std::int32_t>;

  Mesh read_mesh(const Draw& draw) const {
    Mesh mesh;
    std::vector<std::uint32_t> corners = decode_indices(capture_, draw);
    mesh.triangles = corners.size() / 3;
    // Only what lies between the first and the last vertex that is read is decoded: large buffers hold many meshes.
    std::uint32_t first = 0, count = 0;
    if (!corners.empty()) {
      const auto [lowest, highest] = std::minmax_element(corners.begin(), corners.end());
      first = *lowest;
      count = *highest - first + 1;
    }
    Hasher all;
    for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
      VertexStream stream = draw.*kStreamsOfDraw[i].member;
      mesh.present[i] = stream.buffer != kNone;
      Hasher hasher;
      hasher.add_value(mesh.present[i]);
      if (mesh.present[i]) {
        stream.offset += std::uint64_t{first} * stream.stride;
        const std::uint32_t components = kStreamsOfDraw[i].components;
        const std::vector<float> values = decode_stream(capture_, stream, count, components);
        std::vector<float> in_order(corners.size() * components);
        for (std::size_t c = 0; c < corners.size(); ++c) {
          std::copy_n(&values[std::size_t{corners[c] - first} * components], components, &in_order[c * components]);
        }
        hasher.add(in_order);
      }
      mesh.streams[i] = hasher.hash();
      all.add_value(mesh.streams[i]);
    }
    mesh.all = all.hash();
    return mesh;
  }

  Hash material_hash(const Material& m) const {
    Hasher hasher;
    hasher.add_value(
        std::array{static_cast<std::uint32_t>(m.alpha_mode), std::uint32_t{m.two_sided}, std::uint32_t{m.unlit}});
    hasher.add_numbers(m.base_colour);
    hasher.add_numbers(std::array{m.alpha_cutoff, m.metallic, m.roughness, m.normal_scale});
    hasher.add_numbers(m.emissive);
    for (const UvMapping* uv : {&m.base_colour_uv, &m.metallic_roughness_uv, &m.normal_uv, &m.emissive_uv}) {
      hasher.add_value(uv->set);
      hasher.add_numbers(uv->matrix);
    }
    for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
      const std::optional<Hash> content = texture(m.*slot.member);
      hasher.add_value(content.has_value());
      hasher.add_value(content.value_or(Hash{}));
    }
    return hasher.hash();
  }

  const Capture& capture_;
  std::vector<Hash> textures_, materials_;
  std::map<MeshKey, Mesh> meshes_;
};

// Collects {field, a, b} of what differs.
class Fields {
 public:
  template <typename T>
  void compare(const char* name, const T& a, const T& b) {
    if (a != b) list.push_back({{"field", name}, {"a", a}, {"b", b}});
  }
  json list = json::array();
};

json number(AlphaMode mode) {
  return mode == AlphaMode::opaque ? "opaque" : mode == AlphaMode::test ? "test" : "blend";
}
json number(ClipDepth depth) {
  return depth == ClipDepth::zero_to_one ? "0 to 1" : depth == ClipDepth::one_to_zero ? "1 to 0" : "-1 to 1";
}
json mapping(const UvMapping& uv) {
  return {{"set", uv.set}, {"matrix", uv.matrix}};
}
json light(const DirectionalLight& sun) {
  return {{"direction", sun.direction}, {"irradiance", sun.irradiance}, {"shadows", sun.shadows}};
}
json light(const PointLight& point) {
  json cone = nullptr;
  if (point.cone) {
    cone = {{"direction", point.cone->direction},
            {"inner_cosine", point.cone->inner_cosine},
            {"outer_cosine", point.cone->outer_cosine}};
  }
  return {{"position", point.position}, {"intensity", point.intensity}, {"range", point.range}, {"cone", cone}};
}

json material_fields(const Material& a, const Material& b) {
  Fields fields;
  fields.compare("base_colour", a.base_colour, b.base_colour);
  fields.compare("alpha_mode", number(a.alpha_mode), number(b.alpha_mode));
  fields.compare("alpha_cutoff", a.alpha_cutoff, b.alpha_cutoff);
  fields.compare("metallic", a.metallic, b.metallic);
  fields.compare("roughness", a.roughness, b.roughness);
  fields.compare("emissive", a.emissive, b.emissive);
  fields.compare("two_sided", a.two_sided, b.two_sided);
  fields.compare("normal_scale", a.normal_scale, b.normal_scale);
  fields.compare("unlit", a.unlit, b.unlit);
  fields.compare("base_colour_uv", mapping(a.base_colour_uv), mapping(b.base_colour_uv));
  fields.compare("metallic_roughness_uv", mapping(a.metallic_roughness_uv), mapping(b.metallic_roughness_uv));
  fields.compare("normal_uv", mapping(a.normal_uv), mapping(b.normal_uv));
  fields.compare("emissive_uv", mapping(a.emissive_uv), mapping(b.emissive_uv));
  return fields.list;
}

json texture_fields(const Contents& in_a, const Material& a, const Contents& in_b, const Material& b) {
  const auto name = [](const Capture& capture, std::uint32_t texture) {
    return texture == kNone ? json(nullptr) : json(capture.textures[texture].name);
  };
  json list = json::array();
  for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
    const std::uint32_t of_a = a.*slot.member, of_b = b.*slot.member;
    if (in_a.texture(of_a) == in_b.texture(of_b)) continue;
    list.push_back({{"field", slot.name}, {"a", name(in_a.capture(), of_a)}, {"b", name(in_b.capture(), of_b)}});
  }
  return list;
}

json frame_fields(const Frame& a, const Frame& b) {
  Fields fields;
  fields.compare("name", a.name, b.name);
  fields.compare("time_s", a.time_s, b.time_s);
  fields.compare("view", a.view, b.view);
  fields.compare("projection", a.projection, b.projection);
  fields.compare("clip_depth", number(a.clip_depth), number(b.clip_depth));
  fields.compare("clip_y_up", a.clip_y_up, b.clip_y_up);
  fields.compare("width", a.width, b.width);
  fields.compare("height", a.height, b.height);
  fields.compare("exposure", a.exposure, b.exposure);
  fields.compare("sky", a.sky, b.sky);
  fields.compare("ambient", a.ambient, b.ambient);
  fields.compare("sun", a.sun ? light(*a.sun) : json(nullptr), b.sun ? light(*b.sun) : json(nullptr));
  const std::size_t lights = std::max(a.point_lights.size(), b.point_lights.size());
  for (std::size_t i = 0; i < lights; ++i) {
    const auto of = [i](const Frame& frame) {
      return i < frame.point_lights.size() ? light(frame.point_lights[i]) : json(nullptr);
    };
    fields.compare(("point_lights[" + std::to_string(i) + "]").c_str(), of(a), of(b));
  }
  return fields.list;
}

// A draw as it is matched.
struct Drawn {
  const Draw* draw;
  const Mesh* mesh;
  Hash material, placement;
};

std::vector<Drawn> drawn(Contents& contents, const Frame& frame) {
  std::vector<Drawn> all;
  all.reserve(frame.draws.size());
  for (const Draw& draw : frame.draws) {
    all.push_back({&draw, &contents.mesh(draw), contents.material(draw.material), contents.placement(draw)});
  }
  return all;
}

class Matching {
 public:
  Matching(const std::vector<Drawn>& a, const std::vector<Drawn>& b)
      : a_(a), b_(b), match_(a.size()), taken_(b.size(), false) {
    const auto name = [](const Drawn& d) { return d.draw->name; };
    pass([&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.material, d.placement); });
    follow();
    pass([&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.material); });
    pass([&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.placement); });
    pass([&](const Drawn& d) { return std::tuple(name(d), d.material, d.placement); });
    pass([&](const Drawn& d) { return std::tuple(name(d), d.mesh->all); });
    pass(name);
    pass([&](const Drawn& d) { return std::tuple(d.mesh->all, d.placement); });
  }

  const std::vector<std::optional<std::size_t>>& of_a() const { return match_; }
  bool is_taken(std::size_t in_b) const { return taken_[in_b]; }

  // Matched draws less those of the longest run that is in the same order in both.
  std::size_t reordered() const {
    std::vector<std::size_t> last;  // the smallest that a run of each length can end with
    std::size_t matched = 0;
    for (const std::optional<std::size_t>& in_b : match_) {
      if (!in_b) continue;
      ++matched;
      const auto longer = std::lower_bound(last.begin(), last.end(), *in_b);
      if (longer == last.end()) {
        last.push_back(*in_b);
      } else {
        *longer = *in_b;
      }
    }
    return matched - last.size();
  }

 private:
  // Matches draws that stand next to matched ones in both frames and are alike: of many draws of one name and mesh,
  // content alone can't tell which of them moved.
  void follow() {
    const auto match_if_alike = [&](std::size_t i, std::size_t j) {
      if (match_[i] || taken_[j] || a_[i].draw->name != b_[j].draw->name) return;
      if (a_[i].mesh->all != b_[j].mesh->all && a_[i].material != b_[j].material &&
          a_[i].placement != b_[j].placement) {
        return;
      }
      match_[i] = j;
      taken_[j] = true;
    };
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const std::size_t j = i == 0 ? 0 : match_[i - 1] ? *match_[i - 1] + 1 : b_.size();
      if (j < b_.size()) match_if_alike(i, j);
    }
    for (std::size_t i = a_.size(); i-- > 0;) {
      const std::size_t after = i + 1 == a_.size() ? b_.size() : match_[i + 1].value_or(0);
      if (after > 0) match_if_alike(i, after - 1);
    }
  }

  // Matches what has the same key, the first with the first.
  template <typename KeyOf>
  void pass(KeyOf key_of) {
    std::map<decltype(key_of(a_[0])), std::pair<std::vector<std::size_t>, std::size_t>> left;
    for (std::size_t i = 0; i < b_.size(); ++i) {
      if (!taken_[i]) left[key_of(b_[i])].first.push_back(i);
    }
    for (std::size_t i = 0; i < a_.size() && !left.empty(); ++i) {
      if (match_[i]) continue;
      const auto found = left.find(key_of(a_[i]));
      if (found == left.end() || found->second.second == found->second.first.size()) continue;
      match_[i] = found->second.first[found->second.second++];
      taken_[*match_[i]] = true;
    }
  }

  const std::vector<Drawn>&a_, &b_;
  std::vector<std::optional<std::size_t>> match_;
  std::vector<bool> taken_;
};

json changed_draw(const Contents& in_a, const Drawn& a, const Contents& in_b, const Drawn& b) {
  json mesh = json::array();
  if (a.mesh->triangles != b.mesh->triangles) mesh.push_back("triangles");
  for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
    // With other triangles all values are others; what is said then is which streams came or went.
    const bool differs = a.mesh->triangles != b.mesh->triangles ? a.mesh->present[i] != b.mesh->present[i]
                                                                : a.mesh->streams[i] != b.mesh->streams[i];
    if (differs) mesh.push_back(kStreamsOfDraw[i].name);
  }
  json moved = nullptr;
  if (a.placement != b.placement) {
    moved = {{"transform", a.draw->transform != b.draw->transform},
             {"instances", {a.draw->instance_count, b.draw->instance_count}}};
  }
  json material = json::array(), textures = json::array();
  if (a.material != b.material) {
    const Material& of_a = in_a.capture().materials[a.draw->material];
    const Material& of_b = in_b.capture().materials[b.draw->material];
    material = material_fields(of_a, of_b);
    textures = texture_fields(in_a, of_a, in_b, of_b);
  }
  return {{"name", a.draw->name}, {"renamed", a.draw->name == b.draw->name ? json(nullptr) : json(b.draw->name)},
          {"moved", moved},       {"mesh", mesh},
          {"material", material}, {"textures", textures}};
}

json frame_difference(std::size_t number, Contents& in_a, const Frame& a, Contents& in_b, const Frame& b) {
  const std::vector<Drawn> of_a = drawn(in_a, a), of_b = drawn(in_b, b);
  const Matching matching(of_a, of_b);
  json added = json::array(), gone = json::array(), changed = json::array();
  std::size_t equal = 0;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const std::optional<std::size_t> match = matching.of_a()[i];
    if (!match) {
      gone.push_back({{"draw", i}, {"name", of_a[i].draw->name}});
      continue;
    }
    const Drawn &x = of_a[i], &y = of_b[*match];
    if (x.draw->name == y.draw->name && x.mesh->all == y.mesh->all && x.material == y.material &&
        x.placement == y.placement) {
      ++equal;
      continue;
    }
    changed.push_back(changed_draw(in_a, x, in_b, y));
    changed.back()["a"] = i;
    changed.back()["b"] = *match;
  }
  for (std::size_t i = 0; i < of_b.size(); ++i) {
    if (!matching.is_taken(i)) added.push_back({{"draw", i}, {"name", of_b[i].draw->name}});
  }
  const json fields = frame_fields(a, b);
  const std::size_t reordered = matching.reordered();
  return {{"frame", number},
          {"same", fields.empty() && added.empty() && gone.empty() && changed.empty() && reordered == 0},
          {"fields", fields},
          {"draws_a", of_a.size()},
          {"draws_b", of_b.size()},
          {"equal", equal},
          {"reordered", reordered},
          {"added", added},
          {"gone", gone},
          {"changed", changed}};
}

// A value short enough for a line; arrays of more than four numbers are only said to differ.
std::string shown(const json& value) {
  if (value.is_string()) return "'" + printable(value.get<std::string>(), 60) + "'";
  if (value.is_null()) return "none";
  if (value.is_array() && value.size() > 4) return "";
  if (value.is_object()) return "";
  return value.dump();
}

std::string field_text(const json& field) {
  std::string name = field["field"].get<std::string>();
  const std::string a = shown(field["a"]), b = shown(field["b"]);
  if (a.empty() && b.empty()) return name;
  return name + " " + (a.empty() ? "some" : a) + " -> " + (b.empty() ? "some" : b);
}

std::string joined(const json& fields) {
  std::string text;
  for (const json& field : fields) {
    text += (text.empty() ? "" : ", ") + (field.is_string() ? field.get<std::string>() : field_text(field));
  }
  return text;
}

std::string draw_text(const json& draw) {
  return "draw " + draw["draw"].dump() + " " + printable(draw["name"].get<std::string>(), 120);
}

std::string changed_text(const json& draw) {
  std::string text = "draw " + draw["a"].dump();
  if (draw["a"] != draw["b"]) text += " -> " + draw["b"].dump();
  text += " " + printable(draw["name"].get<std::string>(), 120) + ":";
  std::string what;
  const auto add = [&what](const std::string& more) { what += (what.empty() ? " " : "; ") + more; };
  if (!draw["renamed"].is_null()) add("renamed " + shown(draw["renamed"]));
  if (!draw["moved"].is_null()) {
    const json& instances = draw["moved"]["instances"];
    add(instances[0] == instances[1] ? "moved" : "instances " + instances[0].dump() + " -> " + instances[1].dump());
  }
  if (!draw["mesh"].empty()) add("mesh (" + joined(draw["mesh"]) + ")");
  if (!draw["material"].empty()) add("material (" + joined(draw["material"]) + ")");
  if (!draw["textures"].empty()) add("textures (" + joined(draw["textures"]) + ")");
  return text + what;
}

}  // namespace

json difference(const Capture& a, const Capture& b, std::optional<std::pair<std::uint32_t, std::uint32_t>> frames) {
  Contents in_a(a), in_b(b);
  Fields fields;
  fields.compare("metres_per_unit", a.metadata.metres_per_unit, b.metadata.metres_per_unit);
  const std::size_t in_both = std::min(a.frames.size(), b.frames.size());
  const std::size_t first = frames ? frames->first : 0, end = frames ? frames->second + std::size_t{1} : in_both;
  json list = json::array();
  bool is_same = fields.list.empty() && (frames || a.frames.size() == b.frames.size());
  for (std::size_t f = first; f < end; ++f) {
    list.push_back(frame_difference(f, in_a, a.frames[f], in_b, b.frames[f]));
    is_same = is_same && list.back()["same"].get<bool>();
  }
  return {{"same", is_same},
          {"fields", fields.list},
          {"frames_a", a.frames.size()},
          {"frames_b", b.frames.size()},
          {"frames", list}};
}

std::string difference_text(const json& difference) {
  std::string text;
  if (difference["same"].get<bool>()) return "the same: " + std::to_string(difference["frames"].size()) + " frames\n";
  for (const json& field : difference["fields"]) text += field_text(field) + "\n";
  if (difference["frames_a"] != difference["frames_b"]) {
    text += "frames " + difference["frames_a"].dump() + " -> " + difference["frames_b"].dump() + "\n";
  }
  for (const json& frame : difference["frames"]) {
    text += "frame " + frame["frame"].dump() + ": ";
    if (frame["same"].get<bool>()) {
      text += "the same, " + frame["equal"].dump() + " draws\n";
      continue;
    }
    text += "draws " + frame["draws_a"].dump() + " -> " + frame["draws_b"].dump() + ": " + frame["equal"].dump() +
            " equal, " + std::to_string(frame["changed"].size()) + " changed, " +
            std::to_string(frame["added"].size()) + " added, " + std::to_string(frame["gone"].size()) + " gone\n";
    for (const json& field : frame["fields"]) text += "  " + field_text(field) + "\n";
    if (frame["reordered"] != 0) text += "  " + frame["reordered"].dump() + " draws stand elsewhere in the order\n";
    for (const json& draw : frame["changed"]) text += "  " + changed_text(draw) + "\n";
    for (const json& draw : frame["gone"]) text += "  gone: " + draw_text(draw) + "\n";
    for (const json& draw : frame["added"]) text += "  added: " + draw_text(draw) + "\n";
  }
  return text;
}

}  // namespace subpixel::capture
