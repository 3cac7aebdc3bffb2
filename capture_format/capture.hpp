// What a capture is, in memory: resources, frames and the draw calls of each frame in submission order.
// The bytes on disk are described in SPEC.md; reader.hpp and writer.hpp convert between the two.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace subpixel::capture {

using Float3 = std::array<float, 3>;
using Matrix4 = std::array<float, 16>;  // column-major: element (row r, column c) is [4 * c + r]; vectors are columns

inline constexpr std::uint32_t kNone = 0xffffffffu;  // "no such resource" in an index field

struct Metadata {
  std::string title;
  std::string application;  // what was recorded
  std::string tool;         // what recorded it, with version
  std::string licence;      // of the recorded content
  float metres_per_unit = 1.0f;
  std::vector<std::string> notices;  // what whoever made the capture left out or approximated, a sentence each
};

// Raw bytes that vertex streams, indices and instance transforms point into.
struct Buffer {
  std::string name;
  std::vector<std::byte> bytes;
};

enum class TextureEncoding : std::uint32_t { rgba8 = 0, image_file = 1 };  // image_file: PNG, JPEG, TGA, ... as found

enum class Wrap : std::uint32_t { repeat = 0, clamp_to_edge = 1, mirrored_repeat = 2 };
enum class TexelFilter : std::uint32_t { linear = 0, nearest = 1 };
// none: level 0 at every distance. of_means: a level's alpha is the mean of the finer level's, as most engines have it;
// else it is scaled so that as many texels pass an alpha test as at level 0.
enum class MipFilter : std::uint32_t { linear = 0, nearest = 1, none = 2, linear_of_means = 3, nearest_of_means = 4 };

struct Sampler {
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  TexelFilter magnify = TexelFilter::linear, minify = TexelFilter::linear;
  MipFilter mip = MipFilter::linear;

  bool operator==(const Sampler&) const = default;
};

struct Texture {
  std::string name;
  TextureEncoding encoding = TextureEncoding::rgba8;
  bool srgb = false;  // colour textures are sRGB-encoded, normal and roughness maps are linear
  // Texels of rgba8 (4 * width * height bytes, top row first). For image_file: 0, the file itself knows.
  std::uint32_t width = 0, height = 0;
  std::vector<std::byte> bytes;
  Sampler sampler{};
};

// Where on its image a material's texture is read: u' = m[0] u + m[1] v + m[2], v' = m[3] u + m[4] v + m[5].
struct UvMapping {
  std::uint32_t set = 0;  // 0: Draw::uv, 1: Draw::uv2
  std::array<float, 6> matrix{1, 0, 0, 0, 1, 0};

  bool operator==(const UvMapping&) const = default;
};

enum class AlphaMode : std::uint32_t { opaque = 0, test = 1, blend = 2 };

// glTF metallic-roughness. Factors multiply their textures.
struct Material {
  std::string name;
  std::array<float, 4> base_colour{1, 1, 1, 1};  // linear
  std::uint32_t base_colour_texture = kNone;     // alpha in A
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  float metallic = 0.0f;
  float roughness = 0.8f;
  std::uint32_t metallic_roughness_texture = kNone;  // G roughness, B metallic
  std::uint32_t normal_texture = kNone;              // tangent space, +Y up
  Float3 emissive{0, 0, 0};                          // linear radiance
  std::uint32_t emissive_texture = kNone;
  bool two_sided = false;
  float normal_scale = 1.0f;  // of the normal texture's x and y
  bool unlit = false;         // radiance is the base colour: neither light nor shadow
  UvMapping base_colour_uv{}, metallic_roughness_uv{}, normal_uv{}, emissive_uv{};
};

enum class VertexFormat : std::uint32_t {
  float32x2 = 0,
  float32x3 = 1,
  float32x4 = 2,
  float16x2 = 3,
  float16x4 = 4,
  snorm8x4 = 5,
  snorm16x4 = 6,
  unorm16x2 = 7,
  unorm8x4 = 8,
  unorm16x4 = 9,
  octahedral_snorm8 = 10,  // a direction as two snorm8: Cigolle et al. 2014, the unit vector is decoded
  octahedral_snorm16 = 11,
  snorm10x3_2 = 12,  // 32 bits: x in the lowest ten, w in the highest two
  unorm10x3_2 = 13,
  float11x2_10 = 14,  // 32 bits of unsigned floats: x in the lowest eleven, z in the highest ten
  float16x3 = 15,
  snorm16x2 = 16,
};
inline constexpr VertexFormat kLastVertexFormat = VertexFormat::snorm16x2;

// One vertex attribute: element i starts at byte `offset + i * stride` of buffer `buffer`.
struct VertexStream {
  std::uint32_t buffer = kNone;  // kNone: the attribute is absent
  VertexFormat format = VertexFormat::float32x3;
  std::uint64_t offset = 0;  // bytes
  std::uint32_t stride = 0;  // bytes
};

enum class IndexType : std::uint32_t { none = 0, uint16 = 1, uint32 = 2, uint8 = 3 };

// How indices (or vertices in order) make triangles; strips and fans as Vulkan numbers their corners.
enum class Topology : std::uint32_t { triangle_list = 0, triangle_strip = 1, triangle_fan = 2 };

// One draw call. What a reader returns is made of triangle lists: it turns strips and fans into them.
struct Draw {
  std::string name;
  std::uint32_t material = 0;
  VertexStream position, normal, uv, tangent;  // position is required; tangent.w is the bitangent sign
  VertexStream uv2, colour;                    // colour: linear, multiplies the base colour, alpha included
  IndexType index_type = IndexType::none;
  std::uint32_t index_buffer = kNone;
  std::uint64_t index_offset = 0;  // bytes
  std::uint32_t index_count = 0;   // indices (index_type none: vertices) drawn; of a list a multiple of 3
  std::int32_t base_vertex = 0;    // added to every index
  std::uint32_t vertex_count = 0;  // vertices the streams hold; index + base_vertex must be below it
  Matrix4 transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // object to world
  // Instance i is placed by transform * instance matrix i (Matrix4s, tightly packed). instance_count 1 and buffer
  // kNone: one.
  std::uint32_t instance_buffer = kNone;
  std::uint64_t instance_offset = 0;  // bytes
  std::uint32_t instance_count = 1;
  Topology topology = Topology::triangle_list;
  bool restart = false;  // of an indexed strip or fan: the index of all ones begins a new one
};

// How `projection` maps to clip space; replay converts to its own (Vulkan, reversed depth).
enum class ClipDepth : std::uint32_t { zero_to_one = 0, one_to_zero = 1, minus_one_to_one = 2 };

struct DirectionalLight {
  Float3 direction{0, -1, 0};  // the way the light travels, world space
  Float3 irradiance{3, 3, 3};  // linear, on a surface facing it
  bool shadows = true;
};

// Full intensity within `inner` of the direction, none beyond `outer`; between them the square of the linear fraction
// of cosines (glTF's KHR_lights_punctual).
struct SpotCone {
  Float3 direction{0, -1, 0};                // the way the light travels, world space
  float inner_cosine = 1, outer_cosine = 0;  // of the angle to it; inner > outer
};

struct PointLight {
  Float3 position{0, 0, 0};
  Float3 intensity{1, 1, 1};  // linear radiant intensity; irradiance is intensity / distance^2, windowed to 0 at range
  float range = 10.0f;        // world units
  std::optional<SpotCone> cone{};
};

struct Frame {
  std::string name;
  double time_s = 0;
  Matrix4 view{};        // world to view, right-handed, looking down -z
  Matrix4 projection{};  // view to clip
  ClipDepth clip_depth = ClipDepth::one_to_zero;
  bool clip_y_up = false;                    // false: Vulkan (clip +y is down the image); true: OpenGL, Direct3D
  std::uint32_t width = 1280, height = 720;  // pixels it was recorded at; the default replay size
  float exposure = 1.0f;
  Float3 sky{0.35f, 0.5f, 0.75f};     // linear radiance of what no surface covers
  Float3 ambient{0.3f, 0.35f, 0.4f};  // linear irradiance / pi from everywhere
  std::optional<DirectionalLight> sun;
  std::vector<PointLight> point_lights;
  std::vector<Draw> draws;
};

struct Capture {
  Metadata metadata;
  std::vector<Buffer> buffers;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Frame> frames;
};

}  // namespace subpixel::capture
