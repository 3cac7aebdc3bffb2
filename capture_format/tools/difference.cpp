#include "capture_format/tools/difference.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <vector>

#include "base/printable.hpp"
#include "capture_format/tools/draw_content.hpp"
#include "capture_format/tools/draw_matching.hpp"
#include "capture_format/tools/draw_streams.hpp"

namespace subpixel::capture {
namespace {

using nlohmann::json;

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

json texture_fields(const DrawContents& in_a, const Material& a, const DrawContents& in_b, const Material& b) {
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

json changed_draw(const DrawContents& in_a, const Drawn& a, const DrawContents& in_b, const Drawn& b, MatchedBy by) {
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
    const std::optional<double> distance =
        moved_distance(in_a.capture(), *a.draw, in_b.capture(), *b.draw, a.mesh->box);
    moved = {{"transform", a.draw->transform != b.draw->transform},
             {"instances", {a.draw->instance_count, b.draw->instance_count}},
             {"distance", distance ? json(*distance) : json(nullptr)}};
  }
  json material = json::array(), textures = json::array();
  if (a.material != b.material) {
    const Material& of_a = in_a.capture().materials[a.draw->material];
    const Material& of_b = in_b.capture().materials[b.draw->material];
    material = material_fields(of_a, of_b);
    textures = texture_fields(in_a, of_a, in_b, of_b);
  }
  return {{"name", a.draw->name},
          {"renamed", a.draw->name == b.draw->name ? json(nullptr) : json(b.draw->name)},
          {"matched_by", name_of(by)},
          {"moved", moved},
          {"mesh", mesh},
          {"material", material},
          {"textures", textures}};
}

json frame_difference(std::size_t number, DrawContents& in_a, const Frame& a, DrawContents& in_b, const Frame& b) {
  const std::vector<Drawn> of_a = drawn(in_a, a), of_b = drawn(in_b, b);
  const DrawMatching matching(in_a, of_a, in_b, of_b);
  json added = json::array(), gone = json::array(), changed = json::array();
  std::size_t equal = 0;
  std::array<std::size_t, kWaysToMatch.size()> matched{};
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const std::optional<DrawMatching::Match> match = matching.of_a()[i];
    if (!match) {
      gone.push_back({{"draw", i}, {"name", of_a[i].draw->name}});
      continue;
    }
    ++matched[static_cast<std::size_t>(match->by)];
    const Drawn &x = of_a[i], &y = of_b[match->in_b];
    if (x.draw->name == y.draw->name && x.mesh->all == y.mesh->all && x.material == y.material &&
        x.placement == y.placement) {
      ++equal;
      continue;
    }
    changed.push_back(changed_draw(in_a, x, in_b, y, match->by));
    changed.back()["a"] = i;
    changed.back()["b"] = match->in_b;
  }
  for (std::size_t i = 0; i < of_b.size(); ++i) {
    if (!matching.is_taken(i)) added.push_back({{"draw", i}, {"name", of_b[i].draw->name}});
  }
  json matched_by = json::object();
  for (const MatchedBy way : kWaysToMatch) matched_by[name_of(way)] = matched[static_cast<std::size_t>(way)];
  const json fields = frame_fields(a, b);
  const std::size_t reordered = matching.reordered();
  return {{"frame", number},
          {"same", fields.empty() && added.empty() && gone.empty() && changed.empty() && reordered == 0},
          {"fields", fields},
          {"draws_a", of_a.size()},
          {"draws_b", of_b.size()},
          {"equal", equal},
          {"matched_by", matched_by},
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

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
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
  if (draw["matched_by"] != name_of(MatchedBy::name)) add("by " + draw["matched_by"].get<std::string>());
  if (!draw["renamed"].is_null()) add("renamed " + shown(draw["renamed"]));
  if (!draw["moved"].is_null()) {
    const json& instances = draw["moved"]["instances"];
    const json& distance = draw["moved"]["distance"];
    add(instances[0] != instances[1] ? "instances " + instances[0].dump() + " -> " + instances[1].dump()
        : distance.is_null()         ? "moved"
                                     : "moved " + short_number(distance.get<double>()));
  }
  if (!draw["mesh"].empty()) add("mesh (" + joined(draw["mesh"]) + ")");
  if (!draw["material"].empty()) add("material (" + joined(draw["material"]) + ")");
  if (!draw["textures"].empty()) add("textures (" + joined(draw["textures"]) + ")");
  return text + what;
}

// Nothing where all were matched by their names.
std::string matched_text(const json& matched_by) {
  std::string text;
  bool is_by_other = false;
  for (const MatchedBy way : kWaysToMatch) {
    const char* const name = name_of(way);
    if (matched_by[name] == 0) continue;
    text += (text.empty() ? "  matched: " : ", ") + matched_by[name].dump() + " by " + name;
    is_by_other = is_by_other || way != MatchedBy::name;
  }
  return is_by_other ? text + "\n" : "";
}

}  // namespace

json difference(const Capture& a, const Capture& b, std::optional<std::pair<std::uint32_t, std::uint32_t>> frames) {
  DrawContents in_a(a), in_b(b);
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
    text += matched_text(frame["matched_by"]);
    if (frame["reordered"] != 0) text += "  " + frame["reordered"].dump() + " draws stand elsewhere in the order\n";
    for (const json& draw : frame["changed"]) text += "  " + changed_text(draw) + "\n";
    for (const json& draw : frame["gone"]) text += "  gone: " + draw_text(draw) + "\n";
    for (const json& draw : frame["added"]) text += "  added: " + draw_text(draw) + "\n";
  }
  return text;
}

}  // namespace subpixel::capture
