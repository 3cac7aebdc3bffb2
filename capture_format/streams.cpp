#include "capture_format/streams.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

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

void decode_element(VertexFormat format, const std::byte* from, float* to) {
  switch (format) {
    case VertexFormat::float32x2:
    case VertexFormat::float32x3:
    case VertexFormat::float32x4:
      for (std::uint32_t c = 0; c < component_count(format); ++c) to[c] = load<float>(from + 4 * c);
      return;
    case VertexFormat::float16x2:
    case VertexFormat::float16x4:
      for (std::uint32_t c = 0; c < component_count(format); ++c)
        to[c] = half_to_float(load<std::uint16_t>(from + 2 * c));
      return;
    case VertexFormat::snorm8x4:
      for (std::uint32_t c = 0; c < 4; ++c) {
        to[c] = std::max(static_cast<float>(load<std::int8_t>(from + c)) / 127.0f, -1.0f);
      }
      return;
    case VertexFormat::snorm16x4:
      for (std::uint32_t c = 0; c < 4; ++c) {
        to[c] = std::max(static_cast<float>(load<std::int16_t>(from + 2 * c)) / 32767.0f, -1.0f);
      }
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
  }
}

}  // namespace

std::uint32_t component_count(VertexFormat format) {
  switch (format) {
    case VertexFormat::float32x2:
    case VertexFormat::float16x2:
    case VertexFormat::unorm16x2:
      return 2;
    case VertexFormat::float32x3:
      return 3;
    case VertexFormat::float32x4:
    case VertexFormat::float16x4:
    case VertexFormat::snorm8x4:
    case VertexFormat::snorm16x4:
    case VertexFormat::unorm8x4:
    case VertexFormat::unorm16x4:
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
      return 4;
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
  std::vector<std::uint32_t> indices(draw.index_count);
  const auto base = static_cast<std::uint32_t>(draw.base_vertex);  // wraps to the right sum for negative bases
  if (draw.index_type == IndexType::none) {
    for (std::uint32_t i = 0; i < draw.index_count; ++i) indices[i] = i + base;
    return indices;
  }
  const std::byte* from = capture.buffers[draw.index_buffer].bytes.data() + draw.index_offset;
  if (draw.index_type == IndexType::uint16) {
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = load<std::uint16_t>(from + 2 * i) + base;
  } else {
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = load<std::uint32_t>(from + 4 * i) + base;
  }
  return indices;
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
  return std::uint64_t{draw.index_count / 3} * draw.instance_count;
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
