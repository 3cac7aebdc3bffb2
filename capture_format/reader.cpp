#include "capture_format/reader.hpp"

#include <cstdio>
#include <memory>
#include <string>

#include "capture_format/checks.hpp"
#include "capture_format/chunk_reader.hpp"
#include "capture_format/error.hpp"

namespace subpixel::capture {
namespace {

// Smallest encodings, for bounding counts before memory is taken for them.
constexpr std::size_t kPointLightBytes = 28;
constexpr std::size_t kMaterialBytes = 68;
constexpr std::size_t kDrawBytes = 196;

Report fail_in(const FieldReader& in) {
  return [&in](std::string_view field, const std::string& why) { in.fail(field, why); };
}

VertexStream read_stream(FieldReader& in, std::string_view name) {
  VertexStream stream;
  stream.buffer = in.get<std::uint32_t>(name);
  stream.format = in.get<VertexFormat>(name);
  stream.offset = in.get<std::uint64_t>(name);
  stream.stride = in.get<std::uint32_t>(name);
  return stream;
}

Draw read_draw(FieldReader& in) {
  Draw draw;
  draw.name = in.text("name");
  draw.material = in.get<std::uint32_t>("material");
  draw.position = read_stream(in, "position");
  draw.normal = read_stream(in, "normal");
  draw.uv = read_stream(in, "uv");
  draw.tangent = read_stream(in, "tangent");
  draw.index_type = in.get<IndexType>("index_type");
  draw.index_buffer = in.get<std::uint32_t>("index_buffer");
  draw.index_offset = in.get<std::uint64_t>("index_offset");
  draw.index_count = in.get<std::uint32_t>("index_count");
  draw.base_vertex = in.get<std::int32_t>("base_vertex");
  draw.vertex_count = in.get<std::uint32_t>("vertex_count");
  draw.transform = in.get<Matrix4>("transform");
  draw.instance_buffer = in.get<std::uint32_t>("instance_buffer");
  draw.instance_offset = in.get<std::uint64_t>("instance_offset");
  draw.instance_count = in.get<std::uint32_t>("instance_count");
  return draw;
}

Frame read_frame(FieldReader& in, const Capture& capture, IndexChecker& indices) {
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
  frame.point_lights.resize(in.count("point_lights", kMaxPointLights, kPointLightBytes));
  for (PointLight& light : frame.point_lights) {
    light.position = in.get<Float3>("point_lights");
    light.intensity = in.get<Float3>("point_lights");
    light.range = in.get<float>("point_lights");
  }
  check_frame(frame, fail_in(in));
  const std::uint32_t draw_count = in.count("draws", kMaxDraws, kDrawBytes);
  frame.draws.reserve(draw_count);
  for (std::uint32_t i = 0; i < draw_count; ++i) {
    in.enter("draw", i);
    frame.draws.push_back(read_draw(in));
    check_draw(capture, frame.draws.back(), fail_in(in));
    indices.check(capture, frame.draws.back(), fail_in(in));
  }
  in.leave();
  check_draw_list(frame, fail_in(in));
  return frame;
}

Material read_material(FieldReader& in) {
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
  return material;
}

// The bytes of DATA chunks, decoded at first use. Chunks are used more than once when contents were equal.
class DataChunks {
 public:
  DataChunks(std::span<const std::byte> file, const ReadLimits& limits)
      : file_(file), bytes_left_(limits.decoded_bytes) {}

  void add(const ChunkAt& chunk) { chunks_.push_back({chunk, false}); }

  std::vector<std::byte> take(FieldReader& in) {
    const auto number = in.get<std::uint32_t>("data");
    if (number >= chunks_.size()) {
      in.fail("data", std::to_string(number) + " is not below " + std::to_string(chunks_.size()));
    }
    Entry& entry = chunks_[number];
    // Sharing multiplies bytes in memory that the chunk sizes counted once.
    if (entry.chunk.header.decoded_bytes > bytes_left_) in.fail("data", "too many bytes in all buffers and textures");
    bytes_left_ -= entry.chunk.header.decoded_bytes;
    entry.used = true;
    return decode_chunk(file_, entry.chunk);
  }

  // Bytes nobody refers to were never verified, so there may be none.
  void require_all_used() const {
    for (const Entry& entry : chunks_) {
      if (!entry.used) {
        fail_reading("no buffer or texture refers to it", entry.chunk.offset,
                     chunk_name(entry.chunk.header.type, entry.chunk.header.id), "id");
      }
    }
  }

 private:
  struct Entry {
    ChunkAt chunk;
    bool used;
  };
  std::span<const std::byte> file_;
  std::uint64_t bytes_left_;
  std::vector<Entry> chunks_;
};

void require_fewer(const ChunkAt& chunk, std::size_t count, std::uint32_t most) {
  if (count >= most) {
    fail_reading("more than " + std::to_string(most) + " of this kind", chunk.offset,
                 chunk_name(chunk.header.type, chunk.header.id), "id");
  }
}

class CaptureReader {
 public:
  CaptureReader(std::span<const std::byte> file, const ReadLimits& limits) : file_(file), data_(file, limits) {}

  void read(const ChunkAt& chunk) {
    if (chunk.header.type == ChunkType::data) {
      data_.add(chunk);
      return;
    }
    const std::vector<std::byte> payload = decode_chunk(file_, chunk);
    FieldReader in(payload, chunk);
    switch (chunk.header.type) {
      case ChunkType::metadata:
        read_metadata(in, chunk);
        break;
      case ChunkType::buffer:
        require_fewer(chunk, capture_.buffers.size(), kMaxBuffers);
        read_buffer(in);
        break;
      case ChunkType::texture:
        require_fewer(chunk, capture_.textures.size(), kMaxTextures);
        read_texture(in);
        break;
      case ChunkType::material:
        require_fewer(chunk, materials_read_, 1);
        read_materials(in);
        break;
      case ChunkType::frame:
        require_fewer(chunk, capture_.frames.size(), kMaxFrames);
        capture_.frames.push_back(read_frame(in, capture_, indices_));
        break;
      case ChunkType::data:
      case ChunkType::index:
        fail_reading("not expected here", chunk.offset, chunk_name(chunk.header.type, chunk.header.id), "type");
    }
    in.finish();
  }

  Capture finish() {
    if (metadata_read_ == 0) fail_reading("chunk META is missing", 0, "", "");
    if (materials_read_ == 0) fail_reading("chunk MATL is missing", 0, "", "");
    data_.require_all_used();
    return std::move(capture_);
  }

 private:
  void read_metadata(FieldReader& in, const ChunkAt& chunk) {
    require_fewer(chunk, metadata_read_, 1);
    capture_.metadata.title = in.text("title");
    capture_.metadata.application = in.text("application");
    capture_.metadata.tool = in.text("tool");
    capture_.metadata.licence = in.text("licence");
    capture_.metadata.metres_per_unit = in.get<float>("metres_per_unit");
    check_metadata(capture_.metadata, fail_in(in));
    ++metadata_read_;
  }

  void read_buffer(FieldReader& in) {
    Buffer buffer;
    buffer.name = in.text("name");
    buffer.bytes = data_.take(in);
    check_buffer(buffer, fail_in(in));
    capture_.buffers.push_back(std::move(buffer));
  }

  void read_texture(FieldReader& in) {
    Texture texture;
    texture.name = in.text("name");
    texture.encoding = in.get<TextureEncoding>("encoding");
    texture.srgb = in.flag("srgb");
    texture.width = in.get<std::uint32_t>("width");
    texture.height = in.get<std::uint32_t>("height");
    texture.bytes = data_.take(in);
    check_texture(texture, fail_in(in));
    capture_.textures.push_back(std::move(texture));
  }

  void read_materials(FieldReader& in) {
    const std::uint32_t count = in.count("materials", kMaxMaterials, kMaterialBytes);
    for (std::uint32_t i = 0; i < count; ++i) {
      in.enter("material", i);
      capture_.materials.push_back(read_material(in));
      check_material(capture_.materials.back(), capture_.textures.size(), fail_in(in));
    }
    in.leave();
    ++materials_read_;
  }

  std::span<const std::byte> file_;
  Capture capture_;
  DataChunks data_;
  IndexChecker indices_;
  std::size_t metadata_read_ = 0;
  std::size_t materials_read_ = 0;
};

std::vector<std::byte> file_bytes(const std::filesystem::path& path, const ReadLimits& limits) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw InputError("the capture can't be read", "the file can't be opened", path.string());
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);  // fails on folders and devices
  if (error) throw InputError("the capture can't be read", error.message(), path.string());
  if (size > limits.file_bytes) {
    throw InputError("the capture can't be read", "larger than " + std::to_string(limits.file_bytes) + " bytes",
                     path.string());
  }
  std::vector<std::byte> bytes(size);
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
    throw InputError("the capture can't be read", "the file ends early", path.string());
  }
  return bytes;
}

}  // namespace

Capture decode_capture(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const std::vector<ChunkAt> chunks = list_chunks(bytes, limits);
  CaptureReader reader(bytes, limits);
  for (const ChunkAt& chunk : chunks) reader.read(chunk);
  return reader.finish();
}

Capture read_capture(const std::filesystem::path& path, const ReadLimits& limits) {
  const std::vector<std::byte> bytes = file_bytes(path, limits);
  try {
    return decode_capture(bytes, limits);
  } catch (const InputError& error) {
    throw InputError(path.string(), error.what(), "");
  }
}

}  // namespace subpixel::capture
