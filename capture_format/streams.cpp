#include "capture_format/streams.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {
namespace {

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

// A capture is little-endian (SPEC.md); loads above would have to swap elsewhere.
static_assert(std::endian::native == std::endian::little);

float snorm(int value, int most) {
  return std::max(static_cast<float>(value) / static_cast<float>(most), -1.0f);
}

int signed_field(std::uint32_t bits, std::uint32_t at, std::uint32_t width) {
  return static_cast<std::int32_t>(bits << (32 - width - at)) >> (32 - width);
}

// The unit vector of a point of the square that the octahedron unfolds to.
void decode_octahedral(float u, float v, float* to) {
  float x = u, y = v;
  const float z = 1.0f - std::abs(u) - std::abs(v);
  if (z < 0) {
    x = std::copysign(1.0f - std::abs(v), u);
    y = std::copysign(1.0f - std::abs(u), v);
  }
  const float length = std::sqrt(x * x + y * y + z * z);  // at least 1 / sqrt(3)
  to[0] = x / length;
  to[1] = y / length;
  to[2] = z / length;
}

void decode_element(VertexFormat format, const std::byte* from, float* to) {
  switch (format) {
    case VertexFormat::float32x2:
    case VertexFormat::float32x3:
    case VertexFormat::float32x4:
      for (std::uint32_t c = 0; c < component_count(format); ++c) to[c] = load<float>(from + 4 * c);
      return;
    case VertexFormat::float16x2:
    case VertexFormat::float16x3:
    case VertexFormat::float16x4:
      for (std::uint32_t c = 0; c < component_count(format); ++c)
        to[c] = half_to_float(load<std::uint16_t>(from + 2 * c));
      return;
    case VertexFormat::snorm8x4:
      for (std::uint32_t c = 0; c < 4; ++c) to[c] = snorm(load<std::int8_t>(from + c), 127);
      return;
    case VertexFormat::snorm16x4:
      for (std::uint32_t c = 0; c < 4; ++c) to[c] = snorm(load<std::int16_t>(from + 2 * c), 32767);
      return;
    case VertexFormat::unorm8x4:
      for (std::uint32_t c = 0; c < 4; ++c) to[c] = static_cast<float>(load<std::uint8_t>(from + c)) / 255.0f;
      return;
    case VertexFormat::unorm16x2:
    case VertexFormat::unorm16x4:
      for (std::uint32_t c = 0; c < component_count(format); ++c) {
        to[c] = static_cast<float>(load<std::uint16_t>(from + 2 * c)) / 65535.0f;
      }
      return;
    case VertexFormat::octahedral_snorm8:
      decode_octahedral(snorm(load<std::int8_t>(from), 127), snorm(load<std::int8_t>(from + 1), 127), to);
      return;
    case VertexFormat::octahedral_snorm16:
      decode_octahedral(snorm(load<std::int16_t>(from), 32767), snorm(load<std::int16_t>(from + 2), 32767), to);
      return;
    case VertexFormat::snorm10x3_2: {
      const auto bits = load<std::uint32_t>(from);
      for (std::uint32_t c = 0; c < 3; ++c) to[c] = snorm(signed_field(bits, 10 * c, 10), 511);
      to[3] = snorm(signed_field(bits, 30, 2), 1);
      return;
    }
    case VertexFormat::unorm10x3_2: {
      const auto bits = load<std::uint32_t>(from);
      for (std::uint32_t c = 0; c < 3; ++c) to[c] = static_cast<float>(bits >> (10 * c) & 0x3ff) / 1023.0f;
      to[3] = static_cast<float>(bits >> 30) / 3.0f;
      return;
    }
    case VertexFormat::float11x2_10: {
      const auto bits = load<std::uint32_t>(from);
      // Halves without a sign whose mantissas are cut to 6 and 5 bits.
      to[0] = half_to_float(static_cast<std::uint16_t>((bits & 0x7ff) << 4));
      to[1] = half_to_float(static_cast<std::uint16_t>((bits >> 11 & 0x7ff) << 4));
      to[2] = half_to_float(static_cast<std::uint16_t>((bits >> 22) << 5));
      return;
    }
    case VertexFormat::snorm16x2:
      for (std::uint32_t c = 0; c < 2; ++c) to[c] = snorm(load<std::int16_t>(from + 2 * c), 32767);
      return;
  }
}

// The corners of the triangles of a strip or fan, in positions of its own indices; `cut` is the index that begins anew.
std::vector<std::uint32_t> listed(Topology topology, std::span<const std::uint32_t> indices,
                                  std::optional<std::uint32_t> cut) {
  std::vector<std::uint32_t> list;
  std::size_t begin = 0;
  while (begin < indices.size()) {
    const auto from = indices.subspan(begin);
    const auto end = cut ? std::find(from.begin(), from.end(), *cut) : from.end();
    const auto part = from.first(static_cast<std::size_t>(end - from.begin()));
    for (std::size_t i = 0; i + 2 < part.size(); ++i) {
      if (topology == Topology::triangle_fan) {
        list.insert(list.end(), {part[i + 1], part[i + 2], part[0]});
      } else {
        list.insert(list.end(), {part[i], part[i + 1 + i % 2], part[i + 2 - i % 2]});
      }
    }
    begin += part.size() + 1;
  }
  return list;
}

// The draw's indices as they are in its buffer; of a draw without them 0, 1, 2, ...
std::vector<std::uint32_t> stored_indices(const Capture& capture, const Draw& draw) {
  std::vector<std::uint32_t> indices(draw.index_count);
  if (draw.index_type == IndexType::none) {
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }
  const std::byte* from = capture.buffers[draw.index_buffer].bytes.data() + draw.index_offset;
  const auto widen = [&]<typename Index>(Index) {
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = load<Index>(from + i * sizeof(Index));
  };
  if (draw.index_type == IndexType::uint8) widen(std::uint8_t{});
  if (draw.index_type == IndexType::uint16) widen(std::uint16_t{});
  if (draw.index_type == IndexType::uint32) widen(std::uint32_t{});
  return indices;
}

std::vector<std::uint32_t> with_base(std::vector<std::uint32_t> indices, const Draw& draw) {
  const auto base = static_cast<std::uint32_t>(draw.base_vertex);  // wraps to the right sum for negative bases
  for (std::uint32_t& index : indices) index += base;
  return indices;
}

// The draw's triangles, three indices each, base_vertex not added.
std::vector<std::uint32_t> listed_indices(const Capture& capture, const Draw& draw) {
  std::vector<std::uint32_t> indices = stored_indices(capture, draw);
  if (draw.topology == Topology::triangle_list) return indices;
  return listed(draw.topology, indices, draw.restart ? restart_index(draw.index_type) : std::nullopt);
}

}  // namespace

std::optional<std::uint32_t> restart_index(IndexType type) {
  switch (type) {
    case IndexType::uint8:
      return 0xffu;
    case IndexType::uint16:
      return 0xffffu;
    case IndexType::uint32:
      return 0xffffffffu;
    case IndexType::none:
      break;
  }
  return std::nullopt;
}

std::uint32_t index_bytes(IndexType type) {
  switch (type) {
    case IndexType::uint8:
      return 1;
    case IndexType::uint16:
      return 2;
    case IndexType::uint32:
      return 4;
    case IndexType::none:
      break;
  }
  return 0;
}

std::uint32_t component_count(VertexFormat format) {
  switch (format) {
    case VertexFormat::float32x2:
    case VertexFormat::float16x2:
    case VertexFormat::unorm16x2:
    case VertexFormat::snorm16x2:
      return 2;
    case VertexFormat::float32x3:
    case VertexFormat::float16x3:
    case VertexFormat::octahedral_snorm8:
    case VertexFormat::octahedral_snorm16:
    case VertexFormat::float11x2_10:
      return 3;
    case VertexFormat::float32x4:
    case VertexFormat::float16x4:
    case VertexFormat::snorm8x4:
    case VertexFormat::snorm16x4:
    case VertexFormat::unorm8x4:
    case VertexFormat::unorm16x4:
    case VertexFormat::snorm10x3_2:
    case VertexFormat::unorm10x3_2:
      return 4;
  }
  return 0;
}

std::uint32_t element_bytes(VertexFormat format) {
  switch (format) {
    case VertexFormat::float32x2:
      return 8;
    case VertexFormat::float32x3:
      return 12;
    case VertexFormat::float32x4:
      return 16;
    case VertexFormat::float16x2:
    case VertexFormat::snorm8x4:
    case VertexFormat::unorm16x2:
    case VertexFormat::unorm8x4:
    case VertexFormat::octahedral_snorm16:
    case VertexFormat::snorm10x3_2:
    case VertexFormat::unorm10x3_2:
    case VertexFormat::float11x2_10:
    case VertexFormat::snorm16x2:
      return 4;
    case VertexFormat::octahedral_snorm8:
      return 2;
    case VertexFormat::float16x3:
      return 6;
    case VertexFormat::float16x4:
    case VertexFormat::snorm16x4:
    case VertexFormat::unorm16x4:
      return 8;
  }
  return 0;
}

std::vector<float> decode_stream(const Capture& capture, const VertexStream& stream, std::uint32_t count,
                                 std::uint32_t components) {
  if (stream.buffer == kNone) return {};
  std::vector<float> values(std::size_t{count} * components);
  const std::byte* from = capture.buffers[stream.buffer].bytes.data() + stream.offset;
  for (std::uint32_t i = 0; i < count; ++i) {
    float element[4] = {0, 0, 0, 1};
    decode_element(stream.format, from + std::size_t{i} * stream.stride, element);
    std::copy_n(element, components, values.data() + std::size_t{i} * components);
  }
  return values;
}

std::vector<std::uint32_t> decode_indices(const Capture& capture, const Draw& draw) {
  return with_base(listed_indices(capture, draw), draw);
}

std::vector<std::uint32_t> named_vertices(const Capture& capture, const Draw& draw) {
  std::vector<std::uint32_t> indices = stored_indices(capture, draw);
  if (const auto cut = draw.restart ? restart_index(draw.index_type) : std::nullopt) std::erase(indices, *cut);
  return with_base(std::move(indices), draw);
}

void make_triangle_lists(Capture& capture, std::uint64_t most_bytes) {
  // Frames repeat their draws, so each range becomes a list once.
  using Key = std::tuple<std::uint32_t, IndexType, std::uint64_t, std::uint32_t, Topology, bool>;
  struct List {
    std::uint64_t offset;
    std::uint32_t count;
    IndexType type;
  };
  std::map<Key, List> lists;
  Buffer buffer{"triangle lists of strips and fans", {}};
  const auto number = static_cast<std::uint32_t>(capture.buffers.size());
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) {
      if (draw.topology == Topology::triangle_list) continue;
      const Key key{draw.index_buffer, draw.index_type, draw.index_offset,
                    draw.index_count,  draw.topology,   draw.restart};
      auto found = lists.find(key);
      if (found == lists.end()) {
        const std::uint64_t most_of_draw = 12 * std::uint64_t{draw.index_count};
        if (most_of_draw > most_bytes) {
          throw InputError("the capture can't be read", "its strips and fans are too large as triangle lists",
                           draw.name);
        }
        const std::vector<std::uint32_t> indices = listed_indices(capture, draw);
        const IndexType type = draw.index_type == IndexType::none ? IndexType::uint32 : draw.index_type;
        const std::uint64_t offset = (buffer.bytes.size() + 3) / 4 * 4;
        buffer.bytes.resize(offset + indices.size() * index_bytes(type));
        for (std::size_t i = 0; i < indices.size(); ++i) {  // the low bytes come first
          std::memcpy(buffer.bytes.data() + offset + i * index_bytes(type), &indices[i], index_bytes(type));
        }
        most_bytes -= indices.size() * index_bytes(type);
        found = lists.emplace(key, List{offset, static_cast<std::uint32_t>(indices.size()), type}).first;
      }
      draw.index_buffer = number;
      draw.index_type = found->second.type;
      draw.index_offset = found->second.offset;
      draw.index_count = found->second.count;
      draw.topology = Topology::triangle_list;
      draw.restart = false;
    }
  }
  if (lists.empty()) return;
  if (number >= kMaxBuffers) {
    throw InputError("the capture can't be read", "no buffer is left for the triangle lists of its strips", "buffers");
  }
  capture.buffers.push_back(std::move(buffer));
}

std::vector<Matrix4> world_transforms(const Capture& capture, const Draw& draw) {
  if (draw.instance_buffer == kNone) return {draw.transform};
  std::vector<Matrix4> transforms(draw.instance_count);
  const std::byte* from = capture.buffers[draw.instance_buffer].bytes.data() + draw.instance_offset;
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    transforms[i] = multiply(draw.transform, load<Matrix4>(from + sizeof(Matrix4) * i));
  }
  return transforms;
}

std::uint64_t triangle_count(const Draw& draw) {
  if (draw.topology == Topology::triangle_list) return std::uint64_t{draw.index_count / 3} * draw.instance_count;
  return std::uint64_t{draw.index_count < 3 ? 0 : draw.index_count - 2} * draw.instance_count;
}

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
  Matrix4 product{};
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t r = 0; r < 4; ++r) {
      float sum = a[r] * b[4 * c];
      for (std::size_t k = 1; k < 4; ++k) sum += a[4 * k + r] * b[4 * c + k];
      product[4 * c + r] = sum;
    }
  }
  return product;
}

float half_to_float(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000u) << 16;
  const std::uint32_t exponent = (half >> 10) & 0x1fu;
  const std::uint32_t mantissa = half & 0x3ffu;
  if (exponent == 0) {
    const float magnitude = static_cast<float>(mantissa) * 0x1p-24f;  // subnormal: exact in float
    return sign != 0 ? -magnitude : magnitude;
  }
  const std::uint32_t biased = exponent == 31 ? 255 : exponent + 112;
  return std::bit_cast<float>(sign | (biased << 23) | (mantissa << 13));
}

}  // namespace subpixel::capture
