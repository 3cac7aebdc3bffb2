#include "scenes/import/gltf_draco.hpp"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

GltfValues values_of(const draco::PointAttribute& attribute, std::uint32_t points, const GltfElement& element) {
  GltfValues values;
  values.count = points;
  values.components = static_cast<std::size_t>(attribute.num_components());
  if (values.components < 1 || values.components > 4) {
    element.fail(fmt::format("{} components of a compressed attribute", values.components));
  }
  values.numbers.reserve(points * values.components);
  // ConvertValue scales normalised integers to 0..1 by itself; colours and UVs may be such.
  float value[4] = {};
  for (std::uint32_t p = 0; p < points; ++p) {
    const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(p));
    if (!attribute.ConvertValue<float>(index, static_cast<std::int8_t>(values.components), value)) {
      element.fail("a compressed attribute's value can't be read");
    }
    for (std::size_t c = 0; c < values.components; ++c) values.numbers.push_back(static_cast<double>(value[c]));
  }
  return values;
}

}  // namespace

DracoMesh decode_draco(const GltfDocument& document, const GltfElement& extension) {
  const std::size_t view = extension.index("bufferView", document.count("bufferViews"));
  const std::span<const std::byte> bytes = document.view_bytes(view, extension);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) extension.fail("draco: " + to_utf8(decoded.status().error_msg_string()));
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  DracoMesh result;
  const GltfElement names = extension.member("attributes");
  for (const auto& [name, id] : names.raw().items()) {
    const auto number = static_cast<std::uint32_t>(names.whole(name.c_str()));
    const draco::PointAttribute* const attribute = mesh->GetAttributeByUniqueId(number);
    if (attribute == nullptr)
      names.fail(fmt::format("the compressed mesh has no attribute {} for {}", number, to_utf8(name)));
    result.attributes.emplace(name, values_of(*attribute, mesh->num_points(), names));
  }
  result.indices.reserve(std::size_t{3} * mesh->num_faces());
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(f))) {
      if (corner.value() >= mesh->num_points()) extension.fail("draco: a face names a point that is not there");
      result.indices.push_back(corner.value());
    }
  }
  return result;
}

}  // namespace subpixel::capture
