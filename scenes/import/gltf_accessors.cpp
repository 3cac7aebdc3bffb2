// Accessors (section 3.6.2) and compressed buffer views (EXT_meshopt_compression) of a glTF document.
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "scenes/import/gltf_document.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint64_t kMostElements = 1ull << 26;

struct ComponentType {
  std::size_t bytes;
  double (*read)(const std::byte* from);
  double largest;  // of normalised integers; 0: not an integer that can be
};

template <typename T>
double read_as(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

std::optional<ComponentType> component_type(std::uint64_t number) {
  switch (number) {
    case 5120:
      return ComponentType{1, &read_as<std::int8_t>, 127};
    case 5121:
      return ComponentType{1, &read_as<std::uint8_t>, 255};
    case 5122:
      return ComponentType{2, &read_as<std::int16_t>, 32767};
    case 5123:
      return ComponentType{2, &read_as<std::uint16_t>, 65535};
    case 5125:
      return ComponentType{4, &read_as<std::uint32_t>, 4294967295.0};
    case 5126:
      return ComponentType{4, &read_as<float>, 0};
    default:
      return std::nullopt;
  }
}

struct ElementShape {
  std::string_view name;
  std::size_t columns, rows;
};
constexpr ElementShape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                                    {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

// Columns of matrices start at multiples of four bytes.
std::size_t column_bytes(const ElementShape& shape, std::size_t component_bytes) {
  const std::size_t bytes = shape.rows * component_bytes;
  return shape.columns > 1 ? (bytes + 3) / 4 * 4 : bytes;
}

// `count` elements at `stride` in `bytes` from `offset`, or the accessor's error.
void require_inside(const GltfElement& accessor, std::uint64_t count, std::uint64_t offset, std::uint64_t stride,
                    std::uint64_t element_bytes, std::size_t available) {
  if (count == 0) return;
  if (offset > available || element_bytes > available || stride > (1ull << 32) ||
      offset + stride * (count - 1) > available - element_bytes) {
    accessor.fail(fmt::format("{} elements of {} bytes from byte {} at stride {} are not in its view of {} bytes",
                              count, element_bytes, offset, stride, available));
  }
}

std::uint64_t element_count(const GltfElement& accessor) {
  const std::uint64_t count = accessor.whole("count");
  if (count > kMostElements) accessor.fail(fmt::format("count {} is more than {}", count, kMostElements));
  return count;
}

}  // namespace

GltfValues GltfDocument::values(std::size_t index, const GltfElement& user,
                                std::span<const std::string_view> types) const {
  const GltfElement accessor = item("accessors", index);
  const std::uint64_t count = element_count(accessor);
  const std::string type = accessor.text("type");
  const auto* const shape = std::ranges::find(kShapes, std::string_view(type), &ElementShape::name);
  if (shape == std::end(kShapes)) accessor.member("type").fail("unknown type");
  if (!types.empty() && std::ranges::find(types, type) == types.end())
    user.fail(accessor.path() + " is of type " + type);
  const std::uint64_t component_number = accessor.whole("componentType");
  const std::optional<ComponentType> component = component_type(component_number);
  if (!component) accessor.fail(fmt::format("unknown componentType {}", component_number));
  const bool normalised = accessor.flag("normalized", false);
  const std::size_t column = column_bytes(*shape, component->bytes), element_bytes = column * shape->columns;

  GltfValues values{count, shape->columns * shape->rows, {}};
  const auto read_element = [&](const std::byte* from, double* to) {
    for (std::size_t c = 0; c < shape->columns; ++c) {
      for (std::size_t r = 0; r < shape->rows; ++r) {
        const double value = component->read(from + c * column + r * component->bytes);
        *to++ = normalised && component->largest > 0 ? std::max(value / component->largest, -1.0) : value;
      }
    }
  };
  if (const std::optional<std::size_t> view = accessor.find_index("bufferView", this->count("bufferViews"))) {
    const std::span<const std::byte> bytes = view_bytes(*view, accessor);
    const std::uint64_t offset = accessor.whole("byteOffset", 0);
    const std::uint64_t stride = item("bufferViews", *view).whole("byteStride", element_bytes);
    require_inside(accessor, count, offset, stride, element_bytes, bytes.size());
    values.numbers.resize(count * values.components);
    for (std::uint64_t i = 0; i < count; ++i) {
      read_element(bytes.data() + offset + stride * i, values.numbers.data() + i * values.components);
    }
  } else {
    values.numbers.assign(count * values.components, 0.0);
  }
  const std::optional<GltfElement> sparse = accessor.find("sparse");
  if (!sparse) return values;

  const std::uint64_t changed = element_count(*sparse);
  const GltfElement places = sparse->member("indices"), replacements = sparse->member("values");
  const std::uint64_t place_number = places.whole("componentType");
  const std::optional<ComponentType> place_type = component_type(place_number);
  if (!place_type || (place_number != 5121 && place_number != 5123 && place_number != 5125)) {
    places.fail(fmt::format("indices of componentType {}", place_number));
  }
  const auto place_bytes = view_bytes(places.index("bufferView", this->count("bufferViews")), places);
  const auto value_bytes = view_bytes(replacements.index("bufferView", this->count("bufferViews")), replacements);
  const std::uint64_t place_offset = places.whole("byteOffset", 0), value_offset = replacements.whole("byteOffset", 0);
  require_inside(places, changed, place_offset, place_type->bytes, place_type->bytes, place_bytes.size());
  require_inside(replacements, changed, value_offset, element_bytes, element_bytes, value_bytes.size());
  for (std::uint64_t i = 0; i < changed; ++i) {
    const auto at =
        static_cast<std::uint64_t>(place_type->read(place_bytes.data() + place_offset + i * place_type->bytes));
    if (at >= count) places.fail(fmt::format("index {} of {} elements", at, count));
    read_element(value_bytes.data() + value_offset + element_bytes * i, values.numbers.data() + at * values.components);
  }
  return values;
}

std::vector<std::uint32_t> GltfDocument::indices(std::size_t index, const GltfElement& user) const {
  static constexpr std::string_view kScalar[] = {"SCALAR"};
  const GltfElement accessor = item("accessors", index);
  const std::uint64_t component = accessor.whole("componentType");
  if (component != 5121 && component != 5123 && component != 5125) {
    accessor.fail(fmt::format("indices of componentType {}", component));
  }
  const GltfValues values = this->values(index, user, kScalar);
  std::vector<std::uint32_t> result(values.count);
  for (std::size_t i = 0; i < values.count; ++i) result[i] = static_cast<std::uint32_t>(values.numbers[i]);
  return result;
}

// EXT_meshopt_compression: `extension` of a buffer view.
std::vector<std::byte> GltfDocument::decompressed(const GltfElement& extension) const {
  const std::span<const std::byte> buffer = buffer_bytes(extension.index("buffer", count("buffers")), extension);
  const std::uint64_t offset = extension.whole("byteOffset", 0), length = extension.whole("byteLength");
  const std::uint64_t stride = extension.whole("byteStride"), elements = element_count(extension);
  if (offset > buffer.size() || length > buffer.size() - offset) {
    extension.fail(fmt::format("bytes {} to {} are not in its buffer of {}", offset, offset + length, buffer.size()));
  }
  const std::string mode = extension.text("mode"), filter = extension.text("filter", "NONE");
  const auto* const from = reinterpret_cast<const unsigned char*>(buffer.data() + offset);
  int status = 0;
  std::vector<std::byte> bytes;
  if (mode == "ATTRIBUTES") {
    if (stride == 0 || stride > 256 || stride % 4 != 0)
      extension.fail(fmt::format("byteStride {} of attributes", stride));
    bytes.resize(elements * stride);
    status = meshopt_decodeVertexBuffer(bytes.data(), elements, stride, from, length);
  } else if (mode == "TRIANGLES" || mode == "INDICES") {
    if (stride != 2 && stride != 4) extension.fail(fmt::format("byteStride {} of indices", stride));
    if (mode == "TRIANGLES" && elements % 3 != 0) extension.fail(fmt::format("{} indices are no triangles", elements));
    bytes.resize(elements * stride);
    status = mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(bytes.data(), elements, stride, from, length)
                                 : meshopt_decodeIndexSequence(bytes.data(), elements, stride, from, length);
  } else {
    extension.member("mode").fail("unknown mode");
  }
  if (status != 0) extension.fail("the compressed bytes are damaged");
  if (filter == "NONE") return bytes;
  if (mode != "ATTRIBUTES") extension.fail("a filter of indices");
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(bytes.data(), elements, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(bytes.data(), elements, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(bytes.data(), elements, stride);
  } else {
    extension.fail(fmt::format("filter {} with byteStride {}", filter, stride));
  }
  return bytes;
}

}  // namespace subpixel::capture
