#include "capture_format/reading/summary.hpp"

#include <algorithm>
#include <numeric>
#include <set>

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

}  // namespace

std::vector<std::string> used_features(const Capture& capture) {
  std::set<std::uint32_t> used;
  bool has_instances = false;
  bool has_shadows = false;
  bool has_spots = false;
  bool has_colours = false;
  bool has_uv2 = false;
  for (const Frame& frame : capture.frames) {
    has_shadows = has_shadows || (frame.sun && frame.sun->shadows);
    has_spots = has_spots || std::any_of(frame.point_lights.begin(), frame.point_lights.end(),
                                         [](const PointLight& light) { return light.cone.has_value(); });
    for (const Draw& draw : frame.draws) {
      used.insert(draw.material);
      has_instances = has_instances || draw.instance_count > 1;
      has_colours = has_colours || draw.colour.buffer != kNone;
      has_uv2 = has_uv2 || (draw.uv2.buffer != kNone && reads_uv_set(capture.materials[draw.material], 1));
    }
  }
  const auto any = [&](auto predicate) {
    return std::any_of(used.begin(), used.end(), [&](std::uint32_t i) { return predicate(capture.materials[i]); });
  };
  const auto any_read = [&](auto predicate) {
    return any([&](const Material& m) {
      const std::vector<TextureRead> reads = texture_reads(m);
      return std::any_of(reads.begin(), reads.end(), predicate);
    });
  };
  std::vector<std::string> features;
  const auto add = [&](const char* name, bool is_used) {
    if (is_used) features.emplace_back(name);
  };
  add("textures", any([](const Material& m) {
        return m.base_colour_texture != kNone || m.metallic_roughness_texture != kNone || m.emissive_texture != kNone;
      }));
  add("alpha test", any([](const Material& m) { return m.alpha_mode == AlphaMode::test; }));
  add("normal maps", any([](const Material& m) { return m.normal_texture != kNone; }));
  add("emissive", any([](const Material& m) { return m.emissive != Float3{0, 0, 0}; }));
  add("metal", any([](const Material& m) { return m.metallic > 0; }));
  add("two-sided", any([](const Material& m) { return m.two_sided; }));
  add("blending", any([](const Material& m) { return m.alpha_mode == AlphaMode::blend; }));
  add("instancing", has_instances);
  add("shadows", has_shadows);
  add("spot lights", has_spots);
  add("vertex colours", has_colours);
  add("second UV set", has_uv2);
  add("texture transforms", any_read([](const TextureRead& read) { return read.uv->matrix != UvMapping{}.matrix; }));
  add("samplers",
      any_read([&](const TextureRead& read) { return capture.textures[read.texture].sampler != Sampler{}; }));
  add("unlit", any([](const Material& m) { return m.unlit; }));
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
          {"features", used_features(capture)},
          {"frames", frames}};
}

}  // namespace subpixel::capture
