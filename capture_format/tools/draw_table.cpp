#include "capture_format/tools/draw_table.hpp"

#include "capture_format/streams.hpp"
#include "capture_format/tools/draw_streams.hpp"

namespace subpixel::capture {
namespace {

const char* name_of(IndexType type) {
  switch (type) {
    case IndexType::none:
      return "none";
    case IndexType::uint8:
      return "u8";
    case IndexType::uint16:
      return "u16";
    case IndexType::uint32:
      return "u32";
  }
  return "none";
}

std::uint64_t bytes_read(const Draw& draw) {
  std::uint64_t bytes = std::uint64_t{draw.index_count} * index_bytes(draw.index_type);
  for (const StreamOfDraw& each : kStreamsOfDraw) {
    const VertexStream& stream = draw.*each.member;
    if (stream.buffer == kNone) continue;
    bytes += std::uint64_t{element_bytes(stream.format)} * (stream.stride == 0 ? 1 : draw.vertex_count);
  }
  if (draw.instance_buffer != kNone) bytes += std::uint64_t{draw.instance_count} * sizeof(Matrix4);
  return bytes;
}

}  // namespace

nlohmann::json draw_table(const Capture& capture, std::uint32_t frame) {
  const Frame& of = capture.frames[frame];
  nlohmann::json draws = nlohmann::json::array();
  for (std::size_t d = 0; d < of.draws.size(); ++d) {
    const Draw& draw = of.draws[d];
    const Material& material = capture.materials[draw.material];
    nlohmann::json textures = nlohmann::json::array();
    for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
      const std::uint32_t texture = material.*slot.member;
      if (texture == kNone) continue;
      textures.push_back({{"slot", slot.name}, {"texture", texture}, {"name", capture.textures[texture].name}});
    }
    draws.push_back({{"draw", d},
                     {"name", draw.name},
                     {"material", {{"number", draw.material}, {"name", material.name}}},
                     {"triangles", triangle_count(draw)},
                     {"instances", draw.instance_count},
                     {"vertices", draw.vertex_count},
                     {"index_type", name_of(draw.index_type)},
                     {"textures", std::move(textures)},
                     {"bytes", bytes_read(draw)}});
  }
  return {{"frame", frame}, {"name", of.name}, {"draws", std::move(draws)}};
}

}  // namespace subpixel::capture
