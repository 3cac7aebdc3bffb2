// What the statements of an OBJ file say, checked: all indices are those of elements that the file has.
// Format: Wavefront, Object Files, appendix B1 of the Advanced Visualizer manual, and the vertex colours that scanners'
// and sculptors' tools add. Private to the OBJ loader.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/normals.hpp"

namespace subpixel::capture {

inline constexpr std::uint32_t kNoElement = 0xffffffffu;

struct ObjCorner {
  bool operator==(const ObjCorner&) const = default;

  std::uint32_t position = 0, uv = kNoElement, normal = kNoElement;  // counted from 0
};

struct ObjFace {
  std::uint32_t first_corner = 0, corner_count = 0;  // at least 3
  std::uint32_t object = 0, material = 0;            // in ObjText::objects, ObjText::materials
  SmoothingGroup smoothing = kByCreaseAngle;
  std::size_t line = 0;
};

struct ObjMaterialUse {
  std::string name;      // "" is that of faces before any usemtl
  std::size_t line = 0;  // of its first usemtl
};

struct ObjLibraryUse {
  std::string names;  // as written: one file name or several
  std::size_t line = 0;
};

struct ObjText {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> colours;   // empty, or one for each position, 0 to 1 as the file has them
  std::vector<glm::dvec2> uvs;      // v upwards
  std::vector<glm::dvec3> normals;  // not finite where the file's are no numbers
  std::vector<ObjCorner> corners;
  std::vector<ObjFace> faces;
  std::vector<std::string> objects;  // names of the last `o` or `g` before a face, each once
  std::vector<ObjMaterialUse> materials;
  std::vector<ObjLibraryUse> libraries;
  std::vector<std::string> notices;  // statements left out, one for each keyword
};

// Throws InputError naming file, line and value that is wrong.
ObjText parse_obj(std::vector<std::byte> file, const std::string& where);

}  // namespace subpixel::capture
