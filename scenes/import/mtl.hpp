// What the statements of an MTL file say. Format: Wavefront, Material Library File, and the statements for
// metallic-roughness materials that Exocortex proposed and Blender writes. Private to the OBJ loader.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace subpixel::capture {

struct MtlMap {
  std::string file;   // as written, options and quotes removed
  std::string place;  // "FILE, line N"
  bool clamp = false;
  glm::dvec2 scale{1, 1}, offset{0, 0};  // u' = scale * u + offset, v upwards
  double bump = 1;
  char channel = 0;  // r g b m l z, or 0
};

struct MtlMaterial {
  std::string name;
  std::string place;  // "FILE, line N"
  std::optional<glm::dvec3> kd, ke;
  std::optional<double> ns, d, tr, pr, pm;
  std::optional<MtlMap> map_kd, map_d, map_ke, map_pr, map_pm, norm, bump;
};

struct MtlLibrary {
  std::vector<MtlMaterial> materials;
  bool tr_is_opacity = false;        // of `tr` where it stands without `d`
  std::vector<std::string> notices;  // statements and options left out, one for each keyword
};

// Throws InputError naming file, line and value that is wrong. tr_is_opacity: `Tr` is 1 - d by its definition, but
// MeshLab and others write the opacity; taken to be so when MeshLab says that it wrote the file, or when some material
// would be invisible otherwise and none of them is opaque by Tr 0.
MtlLibrary parse_mtl(std::vector<std::byte> file, const std::string& where);

}  // namespace subpixel::capture
