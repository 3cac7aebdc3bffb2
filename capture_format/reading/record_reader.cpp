#include "capture_format/reading/record_reader.hpp"

#include <string>
#include <utility>

#include "capture_format/limits.hpp"

namespace subpixel::capture {
namespace {

// Smallest encodings, for bounding counts before memory is taken for them: of version 1, and what version 2 adds.
constexpr std::size_t kPointLightBytes = 28, kPointLightAddedBytes = 4;
constexpr std::size_t kMaterialBytes = 68, kMaterialAddedBytes = 120;
constexpr std::size_t kDrawBytes = 196, kDrawAddedBytes = 40, kDrawBytesAddedIn3 = 8;
constexpr std::size_t kTextBytes = 4;

}  // namespace

Report fail_in(const FieldReader& in) {
  return [&in](std::string_view field, const std::string& why) { in.fail(field, why); };
}

void add_skip_notice(Metadata& metadata, const std::set<std::string>& kinds) {
  if (kinds.empty() || metadata.notices.size() >= kMaxNotices) return;
  std::string notice = "skipped on reading, of kinds that this program does not know: chunks";
  for (const std::string& kind : kinds) notice += " " + kind;
  if (notice.size() <= kMaxTextBytes) metadata.notices.push_back(std::move(notice));
}

Metadata RecordReader::metadata(FieldReader& in) const {
  Metadata metadata;
  metadata.title = in.text("title");
  metadata.application = in.text("application");
  metadata.tool = in.text("tool");
  metadata.licence = in.text("licence");
  metadata.metres_per_unit = in.get<float>("metres_per_unit");
  if (has_version_2_) {
    metadata.notices.resize(in.count("notices", kMaxNotices, kTextBytes));
    for (std::string& notice : metadata.notices) notice = in.text("notices");
  }
  check_metadata(metadata, fail_in(in));
  return metadata;
}

Buffer RecordReader::buffer(FieldReader& in, const TakeData& take_data) const {
  Buffer buffer;
  buffer.name = in.text("name");
  buffer.bytes = take_data(in);
  return buffer;
}

Texture RecordReader::texture(FieldReader& in, const TakeData& take_data) const {
  Texture texture;
  texture.name = in.text("name");
  texture.encoding = in.get<TextureEncoding>("encoding");
  texture.srgb = in.flag("srgb");
  texture.width = in.get<std::uint32_t>("width");
  texture.height = in.get<std::uint32_t>("height");
  texture.bytes = take_data(in);
  texture.sampler = sampler(in);
  return texture;
}

Sampler RecordReader::sampler(FieldReader& in) const {
  Sampler sampler;
  if (!has_version_2_) return sampler;
  sampler.wrap_u = in.get<Wrap>("sampler.wrap_u");
  sampler.wrap_v = in.get<Wrap>("sampler.wrap_v");
  sampler.magnify = in.get<TexelFilter>("sampler.magnify");
  sampler.minify = in.get<TexelFilter>("sampler.minify");
  sampler.mip = in.get<MipFilter>("sampler.mip");
  if (version_ < 3 && sampler.mip > MipFilter::none) {
    in.fail("sampler.mip", std::to_string(static_cast<std::uint32_t>(sampler.mip)) + " is no mip filter of version 2");
  }
  return sampler;
}

UvMapping RecordReader::uv_mapping(FieldReader& in, std::string_view name) const {
  UvMapping mapping;
  mapping.set = in.get<std::uint32_t>(name);
  mapping.matrix = in.get<std::array<float, 6>>(name);
  return mapping;
}

Material RecordReader::material(FieldReader& in) const {
  Material material;
  material.name = in.text("name");
  material.base_colour = in.get<std::array<float, 4>>("base_colour");
  material.base_colour_texture = in.get<std::uint32_t>("base_colour_texture");
  material.alpha_mode = in.get<AlphaMode>("alpha_mode");
  material.alpha_cutoff = in.get<float>("alpha_cutoff");
  material.metallic = in.get<float>("metallic");
  material.roughness = in.get<float>("roughness");
  material.metallic_roughness_texture = in.get<std::uint32_t>("metallic_roughness_texture");
  material.normal_texture = in.get<std::uint32_t>("normal_texture");
  material.emissive = in.get<Float3>("emissive");
  material.emissive_texture = in.get<std::uint32_t>("emissive_texture");
  material.two_sided = in.flag("two_sided");
  if (has_version_2_) {
    material.normal_scale = in.get<float>("normal_scale");
    material.unlit = in.flag("unlit");
    material.base_colour_uv = uv_mapping(in, "base_colour_uv");
    material.metallic_roughness_uv = uv_mapping(in, "metallic_roughness_uv");
    material.normal_uv = uv_mapping(in, "normal_uv");
    material.emissive_uv = uv_mapping(in, "emissive_uv");
  }
  return material;
}

std::vector<Material> RecordReader::materials(FieldReader& in, std::size_t texture_count) const {
  const std::size_t least_bytes = kMaterialBytes + (has_version_2_ ? kMaterialAddedBytes : 0);
  const std::uint32_t count = in.count("materials", kMaxMaterials, least_bytes);
  std::vector<Material> materials;
  materials.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    in.enter("material", i);
    materials.push_back(material(in));
    check_material(materials.back(), texture_count, fail_in(in));
  }
  in.leave();
  return materials;
}

PointLight RecordReader::point_light(FieldReader& in) const {
  PointLight light;
  light.position = in.get<Float3>("point_lights");
  light.intensity = in.get<Float3>("point_lights");
  light.range = in.get<float>("point_lights");
  if (has_version_2_ && in.flag("point_lights.has_cone")) {
    light.cone.emplace();
    light.cone->direction = in.get<Float3>("point_lights.cone.direction");
    light.cone->inner_cosine = in.get<float>("point_lights.cone.inner_cosine");
    light.cone->outer_cosine = in.get<float>("point_lights.cone.outer_cosine");
  }
  return light;
}

VertexStream RecordReader::stream(FieldReader& in, std::string_view name) const {
  VertexStream stream;
  stream.buffer = in.get<std::uint32_t>(name);
  stream.format = in.get<VertexFormat>(name);
  const VertexFormat last = version_ == 1   ? VertexFormat::unorm16x2
                            : version_ == 2 ? VertexFormat::unorm16x4
                                            : kLastVertexFormat;
  if (version_ < 3 && stream.buffer != kNone && stream.format > last) {
    const std::string number = std::to_string(static_cast<std::uint32_t>(stream.format));
    in.fail(std::string(name) + ".format", number + " is no vertex format of version " + std::to_string(version_));
  }
  stream.offset = in.get<std::uint64_t>(name);
  stream.stride = in.get<std::uint32_t>(name);
  return stream;
}

Draw RecordReader::draw(FieldReader& in) const {
  Draw draw;
  draw.name = in.text("name");
  draw.material = in.get<std::uint32_t>("material");
  draw.position = stream(in, "position");
  draw.normal = stream(in, "normal");
  draw.uv = stream(in, "uv");
  draw.tangent = stream(in, "tangent");
  draw.index_type = in.get<IndexType>("index_type");
  if (version_ < 3 && draw.index_type == IndexType::uint8) {
    in.fail("index_type", "3 is no index type of version " + std::to_string(version_));
  }
  draw.index_buffer = in.get<std::uint32_t>("index_buffer");
  draw.index_offset = in.get<std::uint64_t>("index_offset");
  draw.index_count = in.get<std::uint32_t>("index_count");
  draw.base_vertex = in.get<std::int32_t>("base_vertex");
  draw.vertex_count = in.get<std::uint32_t>("vertex_count");
  draw.transform = in.get<Matrix4>("transform");
  draw.instance_buffer = in.get<std::uint32_t>("instance_buffer");
  draw.instance_offset = in.get<std::uint64_t>("instance_offset");
  draw.instance_count = in.get<std::uint32_t>("instance_count");
  if (has_version_2_) {
    draw.uv2 = stream(in, "uv2");
    draw.colour = stream(in, "colour");
  }
  if (version_ >= 3) {
    draw.topology = in.get<Topology>("topology");
    draw.restart = in.flag("restart");
  }
  return draw;
}

Frame RecordReader::frame(FieldReader& in, const DrawBounds& bounds,
                          const std::function<void(const Draw&, const Report&)>& check_indices) const {
  Frame frame;
  frame.name = in.text("name");
  frame.time_s = in.get<double>("time_s");
  frame.view = in.get<Matrix4>("view");
  frame.projection = in.get<Matrix4>("projection");
  frame.clip_depth = in.get<ClipDepth>("clip_depth");
  frame.clip_y_up = in.flag("clip_y_up");
  frame.width = in.get<std::uint32_t>("width");
  frame.height = in.get<std::uint32_t>("height");
  frame.exposure = in.get<float>("exposure");
  frame.sky = in.get<Float3>("sky");
  frame.ambient = in.get<Float3>("ambient");
  if (in.flag("has_sun")) {
    frame.sun.emplace();
    frame.sun->direction = in.get<Float3>("sun.direction");
    frame.sun->irradiance = in.get<Float3>("sun.irradiance");
    frame.sun->shadows = in.flag("sun.shadows");
  }
  const std::size_t light_bytes = kPointLightBytes + (has_version_2_ ? kPointLightAddedBytes : 0);
  frame.point_lights.resize(in.count("point_lights", kMaxPointLights, light_bytes));
  for (PointLight& light : frame.point_lights) light = point_light(in);
  check_frame(frame, fail_in(in));
  const std::size_t draw_bytes =
      kDrawBytes + (has_version_2_ ? kDrawAddedBytes : 0) + (version_ >= 3 ? kDrawBytesAddedIn3 : 0);
  const std::uint32_t draw_count = in.count("draws", kMaxDraws, draw_bytes);
  frame.draws.reserve(draw_count);
  for (std::uint32_t i = 0; i < draw_count; ++i) {
    in.enter("draw", i);
    frame.draws.push_back(draw(in));
    check_draw(bounds, frame.draws.back(), fail_in(in));
    check_indices(frame.draws.back(), fail_in(in));
  }
  in.leave();
  check_draw_list(frame, fail_in(in));
  return frame;
}

}  // namespace subpixel::capture
