// Meshes compressed by KHR_draco_mesh_compression, decoded by the draco library. Private to gltf_mesh.cpp.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scenes/import/gltf_document.hpp"

namespace subpixel::capture {

struct DracoMesh {
  std::map<std::string, GltfValues> attributes;  // by the names the extension gives them
  std::vector<std::uint32_t> indices;            // triangles
};

// `extension` of a primitive. Throws InputError with draco's reason for damaged data.
DracoMesh decode_draco(const GltfDocument& document, const GltfElement& extension);

}  // namespace subpixel::capture
