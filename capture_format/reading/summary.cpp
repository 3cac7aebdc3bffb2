#include "capture_format/reading/summary.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>

#include "base/printable.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/texture_reads.hpp"

namespace subpixel::capture {
namespace {

nlohmann::json count_and_bytes(std::span<const std::uint64_t> sizes) {
  return {{"count", sizes.size()}, {"bytes", std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0})}};
}

std::uint64_t triangles_of(const Frame& frame) {
  std::uint64_t triangles = 0;
  for (const Draw& draw : frame.draws) triangles += triangle_count(draw);
  return triangles;
}

// What the draws of all frames use.
struct Used {
  std::set<std::uint32_t> materials;
  std::size_t draws = 0, instanced = 0, coloured = 0, second_uvs = 0;
  std::size_t sun_shadows = 0, spots = 0;  // frames
};

Used used_by(const Capture& capture) {
  Used used;
  for (const Frame& frame : capture.frames) {
    used.sun_shadows += frame.sun && frame.sun->shadows ? 1 : 0;
    used.spots +=
        std::ranges::any_of(frame.point_lights, [](const PointLight& light) { return light.cone.has_value(); });
    used.draws += frame.draws.size();
    for (const Draw& draw : frame.draws) {
      used.materials.insert(draw.material);
      used.instanced += draw.instance_count > 1 ? 1 : 0;
      used.coloured += draw.colour.buffer != kNone ? 1 : 0;
      used.second_uvs += draw.uv2.buffer != kNone && reads_uv_set(capture.materials[draw.material], 1) ? 1 : 0;
    }
  }
  return used;
}

constexpr std::size_t kNamedMaterials = 5, kNameBytes = 60;

// "2 of 9 materials: leaf, material 4"
std::string material_reason(const Capture& capture, const std::vector<std::uint32_t>& those, std::size_t all) {
  std::string text = std::to_string(those.size()) + " of " + std::to_string(all) + " materials: ";
  for (std::size_t i = 0; i < those.size() && i < kNamedMaterials; ++i) {
    const std::string& name = capture.materials[those[i]].name;
    text += i > 0 ? ", " : "";
    text += name.empty() ? "material " + std::to_string(those[i]) : printable(name, kNameBytes);
  }
  if (those.size() > kNamedMaterials) text += " and " + std::to_string(those.size() - kNamedMaterials) + " more";
  return text;
}

}  // namespace

std::vector<UsedFeature> used_features(const Capture& capture) {
  const Used used = used_by(capture);
  std::vector<UsedFeature> features;
  const auto of_materials = [&](const char* name, auto predicate) {
    std::vector<std::uint32_t> those;
    std::ranges::copy_if(used.materials, std::back_inserter(those),
                         [&](std::uint32_t i) { return predicate(capture.materials[i]); });
    if (!those.empty()) features.push_back({name, material_reason(capture, those, used.materials.size())});
  };
  const auto of_reads = [&](const char* name, auto predicate) {
    of_materials(name, [&](const Material& m) { return std::ranges::any_of(texture_reads(m), predicate); });
  };
  const auto counted = [&](const char* name, std::size_t number, std::size_t all, const char* of) {
    if (number > 0) features.push_back({name, std::to_string(number) + " of " + std::to_string(all) + " " + of});
  };
  of_materials("textures", [](const Material& m) {
    return m.base_colour_texture != kNone || m.metallic_roughness_texture != kNone || m.emissive_texture != kNone;
  });
  of_materials("alpha test", [](const Material& m) { return m.alpha_mode == AlphaMode::test; });
  of_materials("normal maps", [](const Material& m) { return m.normal_texture != kNone; });
  of_materials("emissive", [](const Material& m) { return m.emissive != Float3{0, 0, 0}; });
  of_materials("metal", [](const Material& m) { return m.metallic > 0; });
  of_materials("two-sided", [](const Material& m) { return m.two_sided; });
  of_materials("blending", [](const Material& m) { return m.alpha_mode == AlphaMode::blend; });
  counted("instancing", used.instanced, used.draws, "draws");
  counted("shadows", used.sun_shadows, capture.frames.size(), "frames have a sun that casts them");
  counted("spot lights", used.spots, capture.frames.size(), "frames");
  counted("vertex colours", used.coloured, used.draws, "draws");
  counted("second UV set", used.second_uvs, used.draws, "draws");
  of_reads("texture transforms", [](const TextureRead& read) { return read.uv->matrix != UvMapping{}.matrix; });
  of_reads("samplers", [&](const TextureRead& read) { return capture.textures[read.texture].sampler != Sampler{}; });
  of_materials("unlit", [](const Material& m) { return m.unlit; });
  return features;
}

nlohmann::json summarize(const Capture& capture, const std::string& hash, std::uint64_t file_bytes) {
  std::vector<std::uint64_t> texture_bytes;
  for (const Texture& texture : capture.textures) texture_bytes.push_back(texture.bytes.size());
  return summarize(capture, sizes_of(capture.buffers), texture_bytes, hash, file_bytes);
}

nlohmann::json summarize(const Capture& capture, std::span<const std::uint64_t> buffer_bytes,
                         std::span<const std::uint64_t> texture_bytes, const std::string& hash,
                         std::uint64_t file_bytes) {
  nlohmann::json frames = nlohmann::json::array();
  std::uint64_t triangles = 0;
  std::size_t draws = 0;
  std::size_t lights = 0;
  for (const Frame& frame : capture.frames) {
    frames.push_back({{"name", frame.name},
                      {"time_s", frame.time_s},
                      {"width", frame.width},
                      {"height", frame.height},
                      {"draws", frame.draws.size()},
                      {"triangles", triangles_of(frame)},
                      {"point_lights", frame.point_lights.size()}});
    triangles = std::max(triangles, triangles_of(frame));
    draws = std::max(draws, frame.draws.size());
    lights = std::max(lights, frame.point_lights.size());
  }
  nlohmann::json features = nlohmann::json::array(), reasons = nlohmann::json::object();
  for (const UsedFeature& feature : used_features(capture)) {
    features.push_back(feature.name);
    reasons[feature.name] = feature.why;
  }
  return {{"title", capture.metadata.title},
          {"application", capture.metadata.application},
          {"tool", capture.metadata.tool},
          {"licence", capture.metadata.licence},
          {"metres_per_unit", capture.metadata.metres_per_unit},
          {"notices", capture.metadata.notices},
          {"hash", hash},
          {"file_bytes", file_bytes},
          {"frame_count", capture.frames.size()},
          {"width", capture.frames.empty() ? 0 : capture.frames[0].width},
          {"height", capture.frames.empty() ? 0 : capture.frames[0].height},
          {"triangles", triangles},
          {"draws", draws},
          {"point_lights", lights},
          {"buffers", count_and_bytes(buffer_bytes)},
          {"textures", count_and_bytes(texture_bytes)},
          {"materials", capture.materials.size()},
          {"features", features},
          {"feature_reasons", reasons},
          {"frames", frames}};
}

}  // namespace subpixel::capture
