#include "capture_format/record_writer.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace subpixel::capture {
namespace {

static_assert(std::endian::native == std::endian::little);

bool needs_version_2(const Material& material) {
  const Material plain;
  return material.normal_scale != plain.normal_scale || material.unlit || material.base_colour_uv != UvMapping{} ||
         material.metallic_roughness_uv != UvMapping{} || material.normal_uv != UvMapping{} ||
         material.emissive_uv != UvMapping{};
}

std::uint32_t version_of(const Texture& texture) {
  if (texture.sampler.mip > MipFilter::none) return 3;
  return texture.sampler != Sampler{} ? 2 : 1;
}

std::uint32_t version_of(const VertexStream& stream) {
  if (stream.buffer == kNone || stream.format <= VertexFormat::unorm16x2) return 1;
  return stream.format <= VertexFormat::unorm16x4 ? 2 : 3;
}

std::uint32_t version_of(const Draw& draw) {
  std::uint32_t version = draw.uv2.buffer != kNone || draw.colour.buffer != kNone ? 2 : 1;
  for (const VertexStream* stream : {&draw.position, &draw.normal, &draw.uv, &draw.tangent, &draw.uv2, &draw.colour}) {
    version = std::max(version, version_of(*stream));
  }
  return draw.topology != Topology::triangle_list || draw.index_type == IndexType::uint8 ? 3 : version;
}

std::uint32_t version_of(const Frame& frame) {
  const bool has_cones = std::any_of(frame.point_lights.begin(), frame.point_lights.end(),
                                     [](const PointLight& light) { return light.cone.has_value(); });
  std::uint32_t version = has_cones ? 2 : 1;
  for (const Draw& draw : frame.draws) version = std::max(version, version_of(draw));
  return version;
}

void put_uv_mapping(ByteWriter& out, const UvMapping& mapping) {
  out.put(mapping.set);
  out.put(mapping.matrix);
}

void put_stream(ByteWriter& out, const VertexStream& stream) {
  out.put(stream.buffer);
  out.put(stream.format);
  out.put(stream.offset);
  out.put(stream.stride);
}

}  // namespace

std::uint32_t needed_version(const Capture& capture) {
  const bool needs_2 = !capture.metadata.notices.empty() ||
                       std::any_of(capture.materials.begin(), capture.materials.end(),
                                   [](const Material& material) { return needs_version_2(material); });
  std::uint32_t version = needs_2 ? 2 : 1;
  for (const Texture& texture : capture.textures) version = std::max(version, version_of(texture));
  for (const Frame& frame : capture.frames) version = std::max(version, version_of(frame));
  return version;
}

std::vector<std::byte> RecordWriter::metadata(const Metadata& metadata) const {
  ByteWriter out;
  out.text(metadata.title);
  out.text(metadata.application);
  out.text(metadata.tool);
  out.text(metadata.licence);
  out.put(metadata.metres_per_unit);
  if (has_version_2()) {
    out.put(static_cast<std::uint32_t>(metadata.notices.size()));
    for (const std::string& notice : metadata.notices) out.text(notice);
  }
  return std::move(out.bytes);
}

std::vector<std::byte> RecordWriter::buffer(const Buffer& buffer, std::uint32_t data) const {
  ByteWriter out;
  out.text(buffer.name);
  out.put(data);
  return std::move(out.bytes);
}

std::vector<std::byte> RecordWriter::texture(const Texture& texture, std::uint32_t data) const {
  ByteWriter out;
  out.text(texture.name);
  out.put(texture.encoding);
  out.put(std::uint32_t{texture.srgb});
  out.put(texture.width);
  out.put(texture.height);
  out.put(data);
  if (has_version_2()) {
    out.put(texture.sampler.wrap_u);
    out.put(texture.sampler.wrap_v);
    out.put(texture.sampler.magnify);
    out.put(texture.sampler.minify);
    out.put(texture.sampler.mip);
  }
  return std::move(out.bytes);
}

std::vector<std::byte> RecordWriter::materials(const std::vector<Material>& materials) const {
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(materials.size()));
  for (const Material& material : materials) put_material(out, material);
  return std::move(out.bytes);
}

void RecordWriter::put_material(ByteWriter& out, const Material& material) const {
  out.text(material.name);
  out.put(material.base_colour);
  out.put(material.base_colour_texture);
  out.put(material.alpha_mode);
  out.put(material.alpha_cutoff);
  out.put(material.metallic);
  out.put(material.roughness);
  out.put(material.metallic_roughness_texture);
  out.put(material.normal_texture);
  out.put(material.emissive);
  out.put(material.emissive_texture);
  out.put(std::uint32_t{material.two_sided});
  if (has_version_2()) {
    out.put(material.normal_scale);
    out.put(std::uint32_t{material.unlit});
    for (const UvMapping* mapping :
         {&material.base_colour_uv, &material.metallic_roughness_uv, &material.normal_uv, &material.emissive_uv}) {
      put_uv_mapping(out, *mapping);
    }
  }
}

std::vector<std::byte> RecordWriter::frame(const Frame& frame) const {
  ByteWriter out;
  out.text(frame.name);
  out.put(frame.time_s);
  out.put(frame.view);
  out.put(frame.projection);
  out.put(frame.clip_depth);
  out.put(std::uint32_t{frame.clip_y_up});
  out.put(frame.width);
  out.put(frame.height);
  out.put(frame.exposure);
  out.put(frame.sky);
  out.put(frame.ambient);
  out.put(std::uint32_t{frame.sun.has_value()});
  if (frame.sun) {
    out.put(frame.sun->direction);
    out.put(frame.sun->irradiance);
    out.put(std::uint32_t{frame.sun->shadows});
  }
  out.put(static_cast<std::uint32_t>(frame.point_lights.size()));
  for (const PointLight& light : frame.point_lights) put_point_light(out, light);
  out.put(static_cast<std::uint32_t>(frame.draws.size()));
  for (const Draw& draw : frame.draws) put_draw(out, draw);
  return std::move(out.bytes);
}

void RecordWriter::put_point_light(ByteWriter& out, const PointLight& light) const {
  out.put(light.position);
  out.put(light.intensity);
  out.put(light.range);
  if (!has_version_2()) return;
  out.put(std::uint32_t{light.cone.has_value()});
  if (light.cone) {
    out.put(light.cone->direction);
    out.put(light.cone->inner_cosine);
    out.put(light.cone->outer_cosine);
  }
}

void RecordWriter::put_draw(ByteWriter& out, const Draw& draw) const {
  out.text(draw.name);
  out.put(draw.material);
  for (const VertexStream* stream : {&draw.position, &draw.normal, &draw.uv, &draw.tangent}) put_stream(out, *stream);
  out.put(draw.index_type);
  out.put(draw.index_buffer);
  out.put(draw.index_offset);
  out.put(draw.index_count);
  out.put(draw.base_vertex);
  out.put(draw.vertex_count);
  out.put(draw.transform);
  out.put(draw.instance_buffer);
  out.put(draw.instance_offset);
  out.put(draw.instance_count);
  if (has_version_2()) {
    put_stream(out, draw.uv2);
    put_stream(out, draw.colour);
  }
  if (version_ >= 3) {
    out.put(draw.topology);
    out.put(std::uint32_t{draw.restart});
  }
}

}  // namespace subpixel::capture
