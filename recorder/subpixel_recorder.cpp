#include "recorder/subpixel_recorder.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "capture_format/chunk.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/stream_recorder.hpp"
#include "recorder/block_textures.hpp"

using subpixel::InputError;
using subpixel::UsageError;
namespace capture = subpixel::capture;

struct subpixel_recorder {
  explicit subpixel_recorder(const capture::Metadata& metadata, const std::filesystem::path& path,
                             const capture::StreamOptions& options)
      : stream(metadata, path, options), part_path(stream.part_path().string()), most_bytes(options.most_bytes) {}

  capture::StreamRecorder stream;
  std::string part_path;
  std::uint64_t most_bytes;
  bool in_frame = false, finished = false;
  // Of the call after which nothing can be recorded, and what it said.
  subpixel_status lasting_status = SUBPIXEL_OK;
  std::string lasting_error;
};

namespace {

// The numbers of both languages are the same.
template <typename Enumeration>
constexpr bool is_same(std::uint32_t c, Enumeration cpp) {
  return c == static_cast<std::uint32_t>(cpp);
}
static_assert(SUBPIXEL_NONE == capture::kNone);
static_assert(is_same(SUBPIXEL_TEXTURE_RGBA8, capture::TextureEncoding::rgba8));
static_assert(is_same(SUBPIXEL_TEXTURE_IMAGE_FILE, capture::TextureEncoding::image_file));
static_assert(is_same(SUBPIXEL_WRAP_REPEAT, capture::Wrap::repeat));
static_assert(is_same(SUBPIXEL_WRAP_CLAMP_TO_EDGE, capture::Wrap::clamp_to_edge));
static_assert(is_same(SUBPIXEL_WRAP_MIRRORED_REPEAT, capture::Wrap::mirrored_repeat));
static_assert(is_same(SUBPIXEL_FILTER_LINEAR, capture::TexelFilter::linear));
static_assert(is_same(SUBPIXEL_FILTER_NEAREST, capture::TexelFilter::nearest));
static_assert(is_same(SUBPIXEL_MIP_LINEAR, capture::MipFilter::linear));
static_assert(is_same(SUBPIXEL_MIP_NEAREST, capture::MipFilter::nearest));
static_assert(is_same(SUBPIXEL_MIP_NONE, capture::MipFilter::none));
static_assert(is_same(SUBPIXEL_MIP_LINEAR_OF_MEANS, capture::MipFilter::linear_of_means));
static_assert(is_same(SUBPIXEL_MIP_NEAREST_OF_MEANS, capture::MipFilter::nearest_of_means));
static_assert(is_same(SUBPIXEL_ALPHA_OPAQUE, capture::AlphaMode::opaque));
static_assert(is_same(SUBPIXEL_ALPHA_TEST, capture::AlphaMode::test));
static_assert(is_same(SUBPIXEL_ALPHA_BLEND, capture::AlphaMode::blend));
static_assert(is_same(SUBPIXEL_CLIP_ZERO_TO_ONE, capture::ClipDepth::zero_to_one));
static_assert(is_same(SUBPIXEL_CLIP_ONE_TO_ZERO, capture::ClipDepth::one_to_zero));
static_assert(is_same(SUBPIXEL_CLIP_MINUS_ONE_TO_ONE, capture::ClipDepth::minus_one_to_one));
static_assert(is_same(SUBPIXEL_FLOAT32X2, capture::VertexFormat::float32x2));
static_assert(is_same(SUBPIXEL_FLOAT32X3, capture::VertexFormat::float32x3));
static_assert(is_same(SUBPIXEL_FLOAT32X4, capture::VertexFormat::float32x4));
static_assert(is_same(SUBPIXEL_FLOAT16X2, capture::VertexFormat::float16x2));
static_assert(is_same(SUBPIXEL_FLOAT16X4, capture::VertexFormat::float16x4));
static_assert(is_same(SUBPIXEL_SNORM8X4, capture::VertexFormat::snorm8x4));
static_assert(is_same(SUBPIXEL_SNORM16X4, capture::VertexFormat::snorm16x4));
static_assert(is_same(SUBPIXEL_UNORM16X2, capture::VertexFormat::unorm16x2));
static_assert(is_same(SUBPIXEL_UNORM8X4, capture::VertexFormat::unorm8x4));
static_assert(is_same(SUBPIXEL_UNORM16X4, capture::VertexFormat::unorm16x4));
static_assert(is_same(SUBPIXEL_OCTAHEDRAL_SNORM8, capture::VertexFormat::octahedral_snorm8));
static_assert(is_same(SUBPIXEL_OCTAHEDRAL_SNORM16, capture::VertexFormat::octahedral_snorm16));
static_assert(is_same(SUBPIXEL_SNORM10X3_2, capture::VertexFormat::snorm10x3_2));
static_assert(is_same(SUBPIXEL_UNORM10X3_2, capture::VertexFormat::unorm10x3_2));
static_assert(is_same(SUBPIXEL_FLOAT11X2_10, capture::VertexFormat::float11x2_10));
static_assert(is_same(SUBPIXEL_FLOAT16X3, capture::VertexFormat::float16x3));
static_assert(is_same(SUBPIXEL_SNORM16X2, capture::VertexFormat::snorm16x2));
static_assert(is_same(SUBPIXEL_SNORM16X2, capture::kLastVertexFormat));  // so that a new one is not forgotten
static_assert(is_same(SUBPIXEL_INDEX_NONE, capture::IndexType::none));
static_assert(is_same(SUBPIXEL_INDEX_UINT16, capture::IndexType::uint16));
static_assert(is_same(SUBPIXEL_INDEX_UINT32, capture::IndexType::uint32));
static_assert(is_same(SUBPIXEL_INDEX_UINT8, capture::IndexType::uint8));
static_assert(is_same(SUBPIXEL_TRIANGLE_LIST, capture::Topology::triangle_list));
static_assert(is_same(SUBPIXEL_TRIANGLE_STRIP, capture::Topology::triangle_strip));
static_assert(is_same(SUBPIXEL_TRIANGLE_FAN, capture::Topology::triangle_fan));

// A call that is not due.
class OrderError : public UsageError {
  using UsageError::UsageError;
};

// An array, so that an error can be told when there is no memory left.
thread_local char last_error[1024] = "";

subpixel_status told(subpixel_status status, const char* message) noexcept {
  const std::size_t size = std::min(std::strlen(message), sizeof last_error - 1);
  std::memmove(last_error, message, size);
  last_error[size] = 0;
  return status;
}

// The outcome of `work` as a status: the one place where exceptions end.
template <typename Work>
subpixel_status guarded(Work&& work) noexcept {
  try {
    work();
    return SUBPIXEL_OK;
  } catch (const OrderError& error) {
    return told(SUBPIXEL_BAD_ORDER, error.what());
  } catch (const UsageError& error) {
    return told(SUBPIXEL_BAD_ARGUMENT, error.what());
  } catch (const InputError& error) {
    return told(SUBPIXEL_CANT_WRITE, error.what());
  } catch (const std::bad_alloc&) {
    return told(SUBPIXEL_NO_MEMORY, "can't record more: there is no memory left");
  } catch (const std::exception& error) {
    return told(SUBPIXEL_FAILED, error.what());
  } catch (...) {
    return told(SUBPIXEL_FAILED, "can't record: an error of an unknown kind");
  }
}

// The same of a call on a recorder. A file that can't be written and a mistake of ours are the end of it.
template <typename Work>
subpixel_status guarded(subpixel_recorder* recorder, Work&& work) noexcept {
  if (recorder != nullptr && recorder->lasting_status != SUBPIXEL_OK) {
    return told(recorder->lasting_status, recorder->lasting_error.c_str());
  }
  const subpixel_status status = guarded([&] {
    if (recorder == nullptr) throw UsageError("can't record", "null", "argument recorder");
    if (recorder->finished) throw OrderError("can't record", "the recording is finished", recorder->part_path);
    work();
  });
  if (recorder != nullptr && (status == SUBPIXEL_CANT_WRITE || status == SUBPIXEL_FAILED)) {
    recorder->lasting_status = status;
    try {
      recorder->lasting_error = last_error;
    } catch (const std::bad_alloc&) {  // the status says enough
    }
  }
  return status;
}

[[noreturn]] void refuse(const char* what, const std::string& field, const std::string& why) {
  throw UsageError("can't record the " + std::string(what), why, "field " + field);
}

template <typename T>
T* required(T* pointer, const char* what, const char* argument) {
  if (pointer == nullptr)
    throw UsageError("can't record the " + std::string(what), "null", "argument " + std::string(argument));
  return pointer;
}

bool flag(std::uint32_t value, const char* what, const char* field) {
  if (value > 1) refuse(what, field, std::to_string(value) + " is neither 0 nor 1");
  return value == 1;
}

std::string text(const char* characters) {
  return characters == nullptr ? std::string() : std::string(characters);
}

template <typename Array>
void copy(float* to, const Array& from) {
  std::copy(from.begin(), from.end(), to);
}

template <std::size_t count>
std::array<float, count> array_of(const float (&from)[count]) {
  std::array<float, count> to;
  std::copy_n(from, count, to.begin());
  return to;
}

// ---- Defaults are those of the C++ structures.

subpixel_uv_mapping c_mapping(const capture::UvMapping& from) {
  subpixel_uv_mapping to{from.set, {}};
  copy(to.matrix, from.matrix);
  return to;
}

subpixel_stream c_stream(const capture::VertexStream& from) {
  return {from.buffer, static_cast<std::uint32_t>(from.format), from.offset, from.stride};
}

void set_defaults(subpixel_metadata& to) {
  to.metres_per_unit = capture::Metadata{}.metres_per_unit;
}

void set_defaults(subpixel_options& to) {
  const capture::StreamOptions from;
  to.zstd_level = from.zstd_level;
  to.queued_bytes = from.queued_bytes;
  to.kept_bytes = from.kept_bytes;
  to.most_bytes = from.most_bytes;
}

void set_defaults(subpixel_texture&) {}  // all are 0

void set_defaults(subpixel_material& to) {
  const capture::Material from;
  to.alpha_mode = static_cast<std::uint32_t>(from.alpha_mode);
  copy(to.base_colour, from.base_colour);
  copy(to.emissive, from.emissive);
  to.alpha_cutoff = from.alpha_cutoff;
  to.metallic = from.metallic;
  to.roughness = from.roughness;
  to.normal_scale = from.normal_scale;
  to.base_colour_texture = from.base_colour_texture;
  to.metallic_roughness_texture = from.metallic_roughness_texture;
  to.normal_texture = from.normal_texture;
  to.emissive_texture = from.emissive_texture;
  to.base_colour_uv = to.metallic_roughness_uv = to.normal_uv = to.emissive_uv = c_mapping(from.base_colour_uv);
}

void set_defaults(subpixel_point_light& to) {
  const capture::PointLight from;
  const capture::SpotCone cone;
  copy(to.position, from.position);
  copy(to.intensity, from.intensity);
  to.range = from.range;
  copy(to.direction, cone.direction);
  to.inner_cosine = cone.inner_cosine;
  to.outer_cosine = cone.outer_cosine;
}

void set_defaults(subpixel_frame& to) {
  const capture::Frame from;
  const capture::DirectionalLight sun;
  to.clip_depth = static_cast<std::uint32_t>(from.clip_depth);
  copy(to.view, capture::Draw{}.transform);
  copy(to.projection, capture::Draw{}.transform);
  to.width = from.width;
  to.height = from.height;
  to.exposure = from.exposure;
  copy(to.sky, from.sky);
  copy(to.ambient, from.ambient);
  copy(to.sun_direction, sun.direction);
  copy(to.sun_irradiance, sun.irradiance);
  to.sun_shadows = sun.shadows;
}

void set_defaults(subpixel_draw& to) {
  const capture::Draw from;
  to.position = to.normal = to.uv = to.tangent = to.uv2 = to.colour = c_stream(from.position);
  to.index_buffer = from.index_buffer;
  to.instance_buffer = from.instance_buffer;
  to.instance_count = from.instance_count;
  copy(to.transform, from.transform);
}

// ---- Structures of other versions than the library's

// No structure comes near it: a larger struct_size was never set.
constexpr std::size_t kMostStructBytes = 1 << 16;

// What version 1 had. When a structure of a later one has more, this is where its first new field begins.
template <typename T>
constexpr std::size_t kLeastStructBytes = sizeof(T);

template <typename T>
subpixel_status init(T* to, std::size_t struct_size, const char* what) {
  return guarded([&] {
    required(to, what, what);
    if (struct_size < kLeastStructBytes<T> || struct_size > kMostStructBytes) {
      refuse(what, "struct_size", std::to_string(struct_size) + " bytes is the size of no version of it");
    }
    T value{};
    set_defaults(value);
    value.struct_size = static_cast<std::uint32_t>(struct_size);
    std::memset(static_cast<void*>(to), 0, struct_size);
    std::memcpy(static_cast<void*>(to), &value, std::min(struct_size, sizeof value));
  });
}

// The caller's structure in the form of this library: fields of later versions than the caller's are at their default,
// ones that this library does not know must be 0, the value which says nothing.
template <typename T>
T known(const T* from, const char* what) {
  required(from, what, what);
  std::uint32_t size = 0;
  std::memcpy(&size, from, sizeof size);
  if (size < kLeastStructBytes<T> || size > kMostStructBytes) {
    refuse(what, "struct_size", std::to_string(size) + " is not what the init function sets");
  }
  if (size > sizeof(T)) {
    const char* bytes = reinterpret_cast<const char*>(from);
    if (std::any_of(bytes + sizeof(T), bytes + size, [](char byte) { return byte != 0; })) {
      refuse(what, "struct_size",
             "fields are set which version " + std::to_string(SUBPIXEL_RECORDER_VERSION) + " lacks");
    }
    size = sizeof(T);
  }
  T value{};
  if (size < sizeof(T)) set_defaults(value);
  std::memcpy(static_cast<void*>(&value), from, size);
  return value;
}

// ---- From C to C++. Numbers out of an enumeration stay so: the recorder refuses them by their field.

capture::Metadata cpp(const subpixel_metadata& from) {
  capture::Metadata to{text(from.title),   text(from.application), text(from.tool),
                       text(from.licence), from.metres_per_unit,   {}};
  if (from.notice_count > capture::kMaxNotices) {
    refuse("metadata", "notice_count",
           std::to_string(from.notice_count) + " is more than " + std::to_string(capture::kMaxNotices));
  }
  if (from.notice_count > 0 && from.notices == nullptr) refuse("metadata", "notices", "null");
  for (std::size_t i = 0; i < from.notice_count; ++i) to.notices.push_back(text(from.notices[i]));
  return to;
}

capture::StreamOptions cpp(const subpixel_options& from) {
  if (from.zstd_level < 0 || from.zstd_level > 22) {
    refuse("options", "zstd_level", std::to_string(from.zstd_level) + " is outside 0 to 22");
  }
  return {from.zstd_level, from.queued_bytes, from.kept_bytes, from.most_bytes};
}

capture::Texture cpp(const subpixel_texture& from, std::uint64_t most_bytes) {
  if (from.size > 0 && from.bytes == nullptr) refuse("texture", "bytes", "null");
  if (from.size > most_bytes)
    refuse("texture", "size", std::to_string(from.size) + " bytes are more than a recording may have");
  const std::span bytes(static_cast<const std::byte*>(from.bytes), from.size);
  capture::Texture to;
  to.name = text(from.name);
  to.srgb = flag(from.srgb, "texture", "srgb");
  to.sampler = {capture::Wrap{from.wrap_u}, capture::Wrap{from.wrap_v}, capture::TexelFilter{from.magnify},
                capture::TexelFilter{from.minify}, capture::MipFilter{from.mip}};
  const std::optional<subpixel::recording::BlockFormat> format = subpixel::recording::block_format(from.format);
  if (!format) {
    if (from.format > SUBPIXEL_TEXTURE_IMAGE_FILE) {
      refuse("texture", "format", std::to_string(from.format) + " is no texture format");
    }
    to.encoding = capture::TextureEncoding{from.format};
    to.width = from.width;
    to.height = from.height;
    to.bytes.assign(bytes.begin(), bytes.end());
    return to;
  }
  for (const auto& [field, side] : {std::pair{"width", from.width}, {"height", from.height}}) {
    if (side == 0 || side > capture::kMaxTextureSide) {
      refuse("texture", field, std::to_string(side) + " is outside 1 to " + std::to_string(capture::kMaxTextureSide));
    }
  }
  const std::uint64_t needed = level_bytes(*format, from.width, from.height);
  if (from.size != needed) {
    refuse("texture", "size", std::to_string(from.size) + " bytes instead of " + std::to_string(needed));
  }
  to.encoding = capture::TextureEncoding::image_file;
  to.bytes = dds_file(*format, from.width, from.height, bytes);
  return to;
}

capture::UvMapping cpp(const subpixel_uv_mapping& from) {
  return {from.set, array_of(from.matrix)};
}

capture::Material cpp(const subpixel_material& from) {
  capture::Material to;
  to.name = text(from.name);
  to.base_colour = array_of(from.base_colour);
  to.base_colour_texture = from.base_colour_texture;
  to.alpha_mode = capture::AlphaMode{from.alpha_mode};
  to.alpha_cutoff = from.alpha_cutoff;
  to.metallic = from.metallic;
  to.roughness = from.roughness;
  to.metallic_roughness_texture = from.metallic_roughness_texture;
  to.normal_texture = from.normal_texture;
  to.emissive = array_of(from.emissive);
  to.emissive_texture = from.emissive_texture;
  to.two_sided = flag(from.two_sided, "material", "two_sided");
  to.normal_scale = from.normal_scale;
  to.unlit = flag(from.unlit, "material", "unlit");
  to.base_colour_uv = cpp(from.base_colour_uv);
  to.metallic_roughness_uv = cpp(from.metallic_roughness_uv);
  to.normal_uv = cpp(from.normal_uv);
  to.emissive_uv = cpp(from.emissive_uv);
  return to;
}

capture::PointLight cpp(const subpixel_point_light& from) {
  capture::PointLight to{array_of(from.position), array_of(from.intensity), from.range};
  if (flag(from.has_cone, "frame", "point_lights[].has_cone")) {
    to.cone = capture::SpotCone{array_of(from.direction), from.inner_cosine, from.outer_cosine};
  }
  return to;
}

capture::Frame cpp(const subpixel_frame& from) {
  capture::Frame to;
  to.name = text(from.name);
  to.time_s = from.time_s;
  to.view = array_of(from.view);
  to.projection = array_of(from.projection);
  to.clip_depth = capture::ClipDepth{from.clip_depth};
  to.clip_y_up = flag(from.clip_y_up, "frame", "clip_y_up");
  to.width = from.width;
  to.height = from.height;
  to.exposure = from.exposure;
  to.sky = array_of(from.sky);
  to.ambient = array_of(from.ambient);
  const bool shadows = flag(from.sun_shadows, "frame", "sun_shadows");
  if (flag(from.has_sun, "frame", "has_sun")) {
    to.sun = capture::DirectionalLight{array_of(from.sun_direction), array_of(from.sun_irradiance), shadows};
  }
  if (from.point_light_count > capture::kMaxPointLights) {
    refuse("frame", "point_light_count",
           std::to_string(from.point_light_count) + " is more than " + std::to_string(capture::kMaxPointLights));
  }
  if (from.point_light_count == 0) return to;
  if (from.point_lights == nullptr) refuse("frame", "point_lights", "null");
  // The caller's version says how far the lights are apart.
  const std::uint32_t stride = from.point_lights->struct_size;
  const char* light = reinterpret_cast<const char*>(from.point_lights);
  for (std::size_t i = 0; i < from.point_light_count; ++i, light += stride) {
    std::uint32_t size = 0;
    std::memcpy(&size, light, sizeof size);
    if (size != stride) refuse("frame", "point_lights[" + std::to_string(i) + "].struct_size", "not that of the first");
    to.point_lights.push_back(cpp(known(reinterpret_cast<const subpixel_point_light*>(light), "point light")));
  }
  return to;
}

capture::VertexStream cpp(const subpixel_stream& from) {
  return {from.buffer, capture::VertexFormat{from.format}, from.offset, from.stride};
}

capture::Draw cpp(const subpixel_draw& from) {
  capture::Draw to;
  to.name = text(from.name);
  to.material = from.material;
  to.position = cpp(from.position);
  to.normal = cpp(from.normal);
  to.uv = cpp(from.uv);
  to.tangent = cpp(from.tangent);
  to.uv2 = cpp(from.uv2);
  to.colour = cpp(from.colour);
  to.index_type = capture::IndexType{from.index_type};
  to.index_buffer = from.index_buffer;
  to.index_offset = from.index_offset;
  to.index_count = from.index_count;
  to.base_vertex = from.base_vertex;
  to.vertex_count = from.vertex_count;
  to.transform = array_of(from.transform);
  to.instance_buffer = from.instance_buffer;
  to.instance_offset = from.instance_offset;
  to.instance_count = from.instance_count;
  to.topology = capture::Topology{from.topology};
  to.restart = flag(from.restart, "draw", "restart");
  return to;
}

}  // namespace

uint32_t subpixel_recorder_version(void) {
  return SUBPIXEL_RECORDER_VERSION;
}
uint32_t subpixel_recorder_format_version(void) {
  return capture::kNewestVersion;
}
const char* subpixel_recorder_release(void) {
  return SUBPIXEL_VERSION;
}
const char* subpixel_recorder_error(void) {
  return last_error;
}

subpixel_status subpixel_metadata_init(subpixel_metadata* metadata, size_t struct_size) {
  return init(metadata, struct_size, "metadata");
}
subpixel_status subpixel_options_init(subpixel_options* options, size_t struct_size) {
  return init(options, struct_size, "options");
}
subpixel_status subpixel_texture_init(subpixel_texture* texture, size_t struct_size) {
  return init(texture, struct_size, "texture");
}
subpixel_status subpixel_material_init(subpixel_material* material, size_t struct_size) {
  return init(material, struct_size, "material");
}
subpixel_status subpixel_point_light_init(subpixel_point_light* light, size_t struct_size) {
  return init(light, struct_size, "light");
}
subpixel_status subpixel_frame_init(subpixel_frame* frame, size_t struct_size) {
  return init(frame, struct_size, "frame");
}
subpixel_status subpixel_draw_init(subpixel_draw* draw, size_t struct_size) {
  return init(draw, struct_size, "draw");
}

subpixel_status subpixel_recorder_create(const char* path, const subpixel_metadata* metadata,
                                         const subpixel_options* options, subpixel_recorder** recorder) {
  if (recorder != nullptr) *recorder = nullptr;
  return guarded([&] {
    required(recorder, "file", "recorder");
    if (*required(path, "file", "path") == 0) throw UsageError("can't record the file", "empty", "argument path");
    const capture::StreamOptions chosen =
        options == nullptr ? capture::StreamOptions{} : cpp(known(options, "options"));
    *recorder = new subpixel_recorder(cpp(known(metadata, "metadata")), path, chosen);
  });
}

void subpixel_recorder_destroy(subpixel_recorder* recorder) {
  delete recorder;
}

const char* subpixel_recorder_part_path(const subpixel_recorder* recorder) {
  return recorder == nullptr ? nullptr : recorder->part_path.c_str();
}

subpixel_status subpixel_recorder_finish(subpixel_recorder* recorder) {
  return guarded(recorder, [&] {
    if (recorder->in_frame)
      throw OrderError("can't finish the recording", "a frame has not ended", recorder->part_path);
    recorder->finished = true;
    recorder->stream.finish();
  });
}

subpixel_status subpixel_recorder_add_buffer(subpixel_recorder* recorder, const char* name, const void* bytes,
                                             size_t size, uint32_t* buffer) {
  if (buffer != nullptr) *buffer = SUBPIXEL_NONE;
  return guarded(recorder, [&] {
    required(buffer, "buffer", "buffer");
    if (size > 0) required(bytes, "buffer", "bytes");
    if (size > recorder->most_bytes) {
      throw UsageError("can't record the buffer", std::to_string(size) + " bytes are more than a recording may have",
                       "argument size");
    }
    *buffer = recorder->stream.add_buffer(text(name), {static_cast<const std::byte*>(bytes), size});
  });
}

subpixel_status subpixel_recorder_add_texture(subpixel_recorder* recorder, const subpixel_texture* texture,
                                              uint32_t* number) {
  if (number != nullptr) *number = SUBPIXEL_NONE;
  return guarded(recorder, [&] {
    required(number, "texture", "number");
    *number = recorder->stream.add_texture(cpp(known(texture, "texture"), recorder->most_bytes));
  });
}

subpixel_status subpixel_recorder_add_material(subpixel_recorder* recorder, const subpixel_material* material,
                                               uint32_t* number) {
  if (number != nullptr) *number = SUBPIXEL_NONE;
  return guarded(recorder, [&] {
    required(number, "material", "number");
    *number = recorder->stream.add_material(cpp(known(material, "material")));
  });
}

subpixel_status subpixel_recorder_begin_frame(subpixel_recorder* recorder, const subpixel_frame* frame) {
  return guarded(recorder, [&] {
    if (recorder->in_frame) throw OrderError("can't begin a frame", "the frame before has not ended", "");
    recorder->stream.begin_frame(cpp(known(frame, "frame")));
    recorder->in_frame = true;
  });
}

subpixel_status subpixel_recorder_draw(subpixel_recorder* recorder, const subpixel_draw* draw) {
  return guarded(recorder, [&] {
    if (!recorder->in_frame) throw OrderError("can't record the draw", "no frame has begun", "");
    recorder->stream.draw(cpp(known(draw, "draw")));
  });
}

subpixel_status subpixel_recorder_end_frame(subpixel_recorder* recorder) {
  return guarded(recorder, [&] {
    if (!recorder->in_frame) throw OrderError("can't end the frame", "none has begun", "");
    recorder->in_frame = false;
    recorder->stream.end_frame();
  });
}
