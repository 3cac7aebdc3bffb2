#include "capture_format/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "capture_format/limits.hpp"
#include "capture_format/streams.hpp"

namespace subpixel::capture {
namespace {

std::string below(std::uint64_t value, std::uint64_t bound) {
  return std::to_string(value) + " is not below " + std::to_string(bound);
}

void check_text(std::string_view field, const std::string& text, const Report& report) {
  if (text.size() > kMaxTextBytes) report(field, "longer than " + std::to_string(kMaxTextBytes) + " bytes");
  if (!is_utf8(text)) report(field, "not UTF-8");
}

void check_finite(std::string_view field, std::span<const float> values, const Report& report) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    report(field, "not finite");
  }
}

void check_not_negative(std::string_view field, std::span<const float> values, const Report& report) {
  check_finite(field, values, report);
  if (std::any_of(values.begin(), values.end(), [](float v) { return v < 0; })) report(field, "negative");
}

void check_unit(std::string_view field, std::span<const float> values, const Report& report) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return v >= 0 && v <= 1; })) {
    report(field, "outside 0 to 1");
  }
}

// `size` bytes at `offset` lie within `available`; written so that no sum can wrap.
bool fits(std::uint64_t offset, std::uint64_t size, std::uint64_t available) {
  return offset <= available && size <= available - offset;
}

void check_side(std::string_view field, std::uint32_t side, std::uint32_t most, const Report& report) {
  if (side == 0 || side > most) report(field, std::to_string(side) + " is outside 1 to " + std::to_string(most));
}

void check_stream(const DrawBounds& bounds, const Draw& draw, const VertexStream& stream, const std::string& name,
                  const Report& report) {
  if (stream.buffer == kNone) return;
  if (stream.buffer >= bounds.buffer_bytes.size()) {
    report(name + ".buffer", below(stream.buffer, bounds.buffer_bytes.size()));
    return;
  }
  if (stream.format > kLastVertexFormat) {
    report(name + ".format", std::to_string(static_cast<std::uint32_t>(stream.format)) + " is no vertex format");
    return;
  }
  const std::uint64_t element = element_bytes(stream.format);
  // A stride of 0 gives all vertices one value; positions must differ, which also bounds vertex_count by real bytes.
  if (stream.stride < element && (stream.stride != 0 || name == "position")) {
    report(name + ".stride", std::to_string(stream.stride) + " bytes is less than an element");
    return;
  }
  const std::uint64_t available = bounds.buffer_bytes[stream.buffer];
  if (draw.vertex_count == 0) return;
  const std::uint64_t span_bytes = std::uint64_t{draw.vertex_count - 1} * stream.stride + element;
  if (!fits(stream.offset, span_bytes, available)) {
    report(name + ".offset", std::to_string(draw.vertex_count) + " vertices at byte " + std::to_string(stream.offset) +
                                 " leave the buffer's " + std::to_string(available) + " bytes");
  }
}

// Other attributes may have any format: components it lacks are 0 and 1 (decode_stream). A colour of two components, or
// with negative ones in its very format, is a mistake.
void check_colour_format(const VertexStream& colour, const Report& report) {
  switch (colour.format) {
    case VertexFormat::float32x3:
    case VertexFormat::float32x4:
    case VertexFormat::float16x4:
    case VertexFormat::unorm8x4:
    case VertexFormat::unorm16x4:
    case VertexFormat::unorm10x3_2:
    case VertexFormat::float11x2_10:
    case VertexFormat::float16x3:
      return;
    default:
      if (colour.buffer != kNone) {
        report("colour.format", std::to_string(static_cast<std::uint32_t>(colour.format)) + " is no format of colours");
      }
  }
}

template <typename Enumeration>
void check_enumeration(std::string_view field, Enumeration value, Enumeration last, const char* what,
                       const Report& report) {
  if (value > last) report(field, std::to_string(static_cast<std::uint32_t>(value)) + " is no " + what);
}

void check_indices(const DrawBounds& bounds, const Draw& draw, const Report& report) {
  check_enumeration("topology", draw.topology, Topology::triangle_fan, "topology", report);
  if (draw.topology == Topology::triangle_list && draw.index_count % 3 != 0) {
    report("index_count", std::to_string(draw.index_count) + " is no multiple of 3");
  }
  if (draw.restart && (draw.topology == Topology::triangle_list || draw.index_type == IndexType::none)) {
    report("restart", "set on a draw that is no indexed strip or fan");
  }
  if (draw.index_type == IndexType::none) {
    if (draw.index_buffer != kNone) report("index_buffer", "set on a draw without indices");
    const std::int64_t last = std::int64_t{draw.base_vertex} + draw.index_count;
    if (draw.base_vertex < 0 || last > std::int64_t{draw.vertex_count}) {
      report("index_count", "vertices " + std::to_string(draw.base_vertex) + " to " + std::to_string(last) +
                                " are not all among the " + std::to_string(draw.vertex_count));
    }
    return;
  }
  if (draw.index_type > IndexType::uint8) {
    report("index_type", std::to_string(static_cast<std::uint32_t>(draw.index_type)) + " is no index type");
    return;
  }
  if (draw.index_buffer >= bounds.buffer_bytes.size()) {
    report("index_buffer", below(draw.index_buffer, bounds.buffer_bytes.size()));
    return;
  }
  const std::uint64_t available = bounds.buffer_bytes[draw.index_buffer];
  if (!fits(draw.index_offset, std::uint64_t{index_bytes(draw.index_type)} * draw.index_count, available)) {
    report("index_offset", std::to_string(draw.index_count) + " indices at byte " + std::to_string(draw.index_offset) +
                               " leave the buffer's " + std::to_string(available) + " bytes");
  }
}

void check_instances(const DrawBounds& bounds, const Draw& draw, const Report& report) {
  if (draw.instance_buffer == kNone) {
    if (draw.instance_count != 1) report("instance_count", "must be 1 without an instance buffer");
    return;
  }
  if (draw.instance_buffer >= bounds.buffer_bytes.size()) {
    report("instance_buffer", below(draw.instance_buffer, bounds.buffer_bytes.size()));
    return;
  }
  const std::uint64_t available = bounds.buffer_bytes[draw.instance_buffer];
  if (!fits(draw.instance_offset, std::uint64_t{draw.instance_count} * sizeof(Matrix4), available)) {
    report("instance_offset", std::to_string(draw.instance_count) + " matrices at byte " +
                                  std::to_string(draw.instance_offset) + " leave the buffer's " +
                                  std::to_string(available) + " bytes");
  }
}

void check_sampler(const Sampler& sampler, const Report& report) {
  check_enumeration("sampler.wrap_u", sampler.wrap_u, Wrap::mirrored_repeat, "wrap", report);
  check_enumeration("sampler.wrap_v", sampler.wrap_v, Wrap::mirrored_repeat, "wrap", report);
  check_enumeration("sampler.magnify", sampler.magnify, TexelFilter::nearest, "texel filter", report);
  check_enumeration("sampler.minify", sampler.minify, TexelFilter::nearest, "texel filter", report);
  check_enumeration("sampler.mip", sampler.mip, MipFilter::nearest_of_means, "mip filter", report);
}

void check_uv_mapping(const std::string& field, const UvMapping& mapping, const Report& report) {
  if (mapping.set > 1) report(field + ".set", std::to_string(mapping.set) + " is neither 0 nor 1");
  check_finite(field + ".matrix", mapping.matrix, report);
}

void check_cone(const SpotCone& cone, const Report& report) {
  check_finite("cone.direction", cone.direction, report);
  const Float3& d = cone.direction;
  if (d[0] == 0 && d[1] == 0 && d[2] == 0) report("cone.direction", "of length 0");
  const auto is_cosine = [](float value) { return value >= -1 && value <= 1; };
  if (!is_cosine(cone.inner_cosine)) report("cone.inner_cosine", "outside -1 to 1");
  if (!is_cosine(cone.outer_cosine)) report("cone.outer_cosine", "outside -1 to 1");
  if (!(cone.inner_cosine > cone.outer_cosine)) report("cone.inner_cosine", "not above outer_cosine");
}

template <typename Index>
std::pair<std::uint32_t, std::uint32_t> index_bounds(const std::byte* from, std::uint32_t count,
                                                     std::uint64_t left_out) {
  std::uint32_t lowest = kNone;
  std::uint32_t highest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    Index index;
    std::memcpy(&index, from + i * sizeof index, sizeof index);
    if (left_out == index) continue;
    lowest = std::min<std::uint32_t>(lowest, index);
    highest = std::max<std::uint32_t>(highest, index);
  }
  return {lowest, highest};
}

}  // namespace

std::vector<std::uint64_t> sizes_of(const std::vector<Buffer>& buffers) {
  std::vector<std::uint64_t> sizes;
  sizes.reserve(buffers.size());
  for (const Buffer& buffer : buffers) sizes.push_back(buffer.bytes.size());
  return sizes;
}

// Well-formed byte sequences as in the Unicode Standard, table 3-7.
bool is_utf8(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if (lead < 0x80) {
      ++i;
      continue;
    }
    std::size_t trailing = 0;
    unsigned char low = 0x80;
    unsigned char high = 0xbf;
    if (lead >= 0xc2 && lead <= 0xdf) {
      trailing = 1;
    } else if (lead >= 0xe0 && lead <= 0xef) {
      trailing = 2;
      if (lead == 0xe0) low = 0xa0;
      if (lead == 0xed) high = 0x9f;
    } else if (lead >= 0xf0 && lead <= 0xf4) {
      trailing = 3;
      if (lead == 0xf0) low = 0x90;
      if (lead == 0xf4) high = 0x8f;
    } else {
      return false;
    }
    if (text.size() - i <= trailing) return false;
    for (std::size_t k = 1; k <= trailing; ++k) {
      const auto byte = static_cast<unsigned char>(text[i + k]);
      if (byte < low || byte > high) return false;
      low = 0x80;
      high = 0xbf;
    }
    i += trailing + 1;
  }
  return true;
}

void check_metadata(const Metadata& metadata, const Report& report) {
  check_text("title", metadata.title, report);
  check_text("application", metadata.application, report);
  check_text("tool", metadata.tool, report);
  check_text("licence", metadata.licence, report);
  if (!(std::isfinite(metadata.metres_per_unit) && metadata.metres_per_unit > 0)) {
    report("metres_per_unit", "not a positive number");
  }
  if (metadata.notices.size() > kMaxNotices) {
    report("notices", std::to_string(metadata.notices.size()) + " are more than " + std::to_string(kMaxNotices));
  }
  for (std::size_t i = 0; i < metadata.notices.size(); ++i) {
    check_text("notices[" + std::to_string(i) + "]", metadata.notices[i], report);
  }
}

void check_buffer(const Buffer& buffer, const Report& report) {
  check_text("name", buffer.name, report);
}

void check_texture(const Texture& texture, const Report& report) {
  check_texture(texture, texture.bytes.size(), report);
}

void check_texture(const Texture& texture, std::uint64_t bytes, const Report& report) {
  check_text("name", texture.name, report);
  check_sampler(texture.sampler, report);
  if (texture.encoding == TextureEncoding::image_file) {
    if (texture.width != 0 || texture.height != 0) report("width", "set on a texture that is an image file");
    if (bytes == 0) report("bytes", "empty");
    return;
  }
  if (texture.encoding != TextureEncoding::rgba8) {
    report("encoding", std::to_string(static_cast<std::uint32_t>(texture.encoding)) + " is no texture encoding");
    return;
  }
  check_side("width", texture.width, kMaxTextureSide, report);
  check_side("height", texture.height, kMaxTextureSide, report);
  const std::uint64_t needed = 4ull * texture.width * texture.height;
  if (bytes != needed) {
    report("bytes", std::to_string(bytes) + " bytes instead of " + std::to_string(needed));
  }
}

void check_material(const Material& material, std::size_t texture_count, const Report& report) {
  check_text("name", material.name, report);
  check_unit("base_colour", material.base_colour, report);
  check_unit("alpha_cutoff", std::span(&material.alpha_cutoff, 1), report);
  check_unit("metallic", std::span(&material.metallic, 1), report);
  check_unit("roughness", std::span(&material.roughness, 1), report);
  check_not_negative("emissive", material.emissive, report);
  if (material.alpha_mode > AlphaMode::blend) {
    report("alpha_mode", std::to_string(static_cast<std::uint32_t>(material.alpha_mode)) + " is no alpha mode");
  }
  check_finite("normal_scale", std::span(&material.normal_scale, 1), report);
  check_uv_mapping("base_colour_uv", material.base_colour_uv, report);
  check_uv_mapping("metallic_roughness_uv", material.metallic_roughness_uv, report);
  check_uv_mapping("normal_uv", material.normal_uv, report);
  check_uv_mapping("emissive_uv", material.emissive_uv, report);
  const std::pair<std::string_view, std::uint32_t> textures[] = {
      {"base_colour_texture", material.base_colour_texture},
      {"metallic_roughness_texture", material.metallic_roughness_texture},
      {"normal_texture", material.normal_texture},
      {"emissive_texture", material.emissive_texture}};
  for (const auto& [field, texture] : textures) {
    if (texture != kNone && texture >= texture_count) report(field, below(texture, texture_count));
  }
}

void check_frame(const Frame& frame, const Report& report) {
  check_text("name", frame.name, report);
  if (!std::isfinite(frame.time_s)) report("time_s", "not finite");
  check_finite("view", frame.view, report);
  check_finite("projection", frame.projection, report);
  if (frame.clip_depth > ClipDepth::minus_one_to_one) {
    report("clip_depth", std::to_string(static_cast<std::uint32_t>(frame.clip_depth)) + " is no clip depth");
  }
  check_side("width", frame.width, kMaxFrameSide, report);
  check_side("height", frame.height, kMaxFrameSide, report);
  check_not_negative("exposure", std::span(&frame.exposure, 1), report);
  check_not_negative("sky", frame.sky, report);
  check_not_negative("ambient", frame.ambient, report);
  if (frame.sun) {
    check_finite("sun.direction", frame.sun->direction, report);
    const Float3& d = frame.sun->direction;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) report("sun.direction", "of length 0");
    check_not_negative("sun.irradiance", frame.sun->irradiance, report);
  }
  if (frame.point_lights.size() > kMaxPointLights) {
    report("point_lights",
           std::to_string(frame.point_lights.size()) + " are more than " + std::to_string(kMaxPointLights));
  }
  for (std::size_t i = 0; i < frame.point_lights.size(); ++i) {
    const PointLight& light = frame.point_lights[i];
    // The field's name is put together only when it is needed: lights are many.
    const auto named = [&](std::string_view field, const std::string& why) {
      report("point_lights[" + std::to_string(i) + "]." + std::string(field), why);
    };
    check_finite("position", light.position, named);
    check_not_negative("intensity", light.intensity, named);
    if (!(std::isfinite(light.range) && light.range > 0)) named("range", "not a positive number");
    if (light.cone) check_cone(*light.cone, named);
  }
}

void check_draw_list(const Frame& frame, const Report& report) {
  if (frame.draws.size() > kMaxDraws) {
    report("draws", std::to_string(frame.draws.size()) + " are more than " + std::to_string(kMaxDraws));
    return;
  }
  std::uint64_t triangles = 0;  // cannot wrap: 2^20 draws of less than 2^31 x 2^32 are stopped as soon as they pass
  for (const Draw& draw : frame.draws) {
    triangles += triangle_count(draw);
    if (triangles > kMaxTriangles) {
      report("draws", "more than " + std::to_string(kMaxTriangles) + " triangles, instances counted");
      return;
    }
  }
}

void check_draw(const DrawBounds& bounds, const Draw& draw, const Report& report) {
  check_text("name", draw.name, report);
  if (draw.material >= bounds.materials) report("material", below(draw.material, bounds.materials));
  if (draw.position.buffer == kNone) report("position.buffer", "absent");
  check_stream(bounds, draw, draw.position, "position", report);
  check_stream(bounds, draw, draw.normal, "normal", report);
  check_stream(bounds, draw, draw.uv, "uv", report);
  check_stream(bounds, draw, draw.tangent, "tangent", report);
  check_stream(bounds, draw, draw.uv2, "uv2", report);
  check_stream(bounds, draw, draw.colour, "colour", report);
  check_colour_format(draw.colour, report);
  check_indices(bounds, draw, report);
  check_instances(bounds, draw, report);
}

void IndexChecker::check(const Capture& capture, const Draw& draw, const Report& report) {
  check(
      draw, [&](std::uint32_t buffer) { return std::span<const std::byte>(capture.buffers[buffer].bytes); }, report);
}

void IndexChecker::check(const Draw& draw,
                         const std::function<std::span<const std::byte>(std::uint32_t buffer)>& bytes_of,
                         const Report& report) {
  if (draw.index_type == IndexType::none || draw.index_count == 0) return;
  const Key key{draw.index_buffer, draw.index_type, draw.index_offset, draw.index_count, draw.restart};
  auto found = ranges_.find(key);
  if (found == ranges_.end()) {
    if (draw.index_count > kMaxIndicesChecked - indices_read_) {
      report("index_count",
             "the draws' different index ranges hold more than " + std::to_string(kMaxIndicesChecked) + " indices");
      return;
    }
    const std::byte* from = bytes_of(draw.index_buffer).data() + draw.index_offset;
    constexpr std::uint64_t kNoIndex = ~std::uint64_t{0};
    const std::uint64_t cut = draw.restart ? restart_index(draw.index_type).value_or(kNone) : kNoIndex;
    const auto [lowest, highest] =
        draw.index_type == IndexType::uint8    ? index_bounds<std::uint8_t>(from, draw.index_count, cut)
        : draw.index_type == IndexType::uint16 ? index_bounds<std::uint16_t>(from, draw.index_count, cut)
                                               : index_bounds<std::uint32_t>(from, draw.index_count, cut);
    found = ranges_.emplace(key, Range{lowest, highest}).first;
    indices_read_ += draw.index_count;
  }
  if (found->second.lowest > found->second.highest) return;  // nothing but restarts
  const std::int64_t lowest = std::int64_t{found->second.lowest} + draw.base_vertex;
  const std::int64_t highest = std::int64_t{found->second.highest} + draw.base_vertex;
  if (lowest < 0 || highest >= std::int64_t{draw.vertex_count}) {
    report("index_buffer", "indices " + std::to_string(lowest) + " to " + std::to_string(highest) +
                               " (base_vertex added) are not all among the " + std::to_string(draw.vertex_count) +
                               " vertices");
  }
}

}  // namespace subpixel::capture
