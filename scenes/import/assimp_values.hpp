// assimp's vectors and matrices as glm's. Private to the loader by assimp.
#pragma once

#include <assimp/matrix4x4.h>
#include <assimp/scene.h>
#include <assimp/vector3.h>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace subpixel::capture {

inline glm::dvec3 to_vec3(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

inline glm::dmat4 to_matrix(const aiMatrix4x4& m) {
  glm::dmat4 matrix(1.0);
  for (unsigned r = 0; r < 4; ++r) {
    for (unsigned c = 0; c < 4; ++c) matrix[static_cast<int>(c)][static_cast<int>(r)] = m[r][c];
  }
  return matrix;
}

// Node to world; the identity for no node.
inline glm::dmat4 place_of(const aiNode* node) {
  glm::dmat4 place(1.0);
  for (; node != nullptr; node = node->mParent) place = to_matrix(node->mTransformation) * place;
  return place;
}

}  // namespace subpixel::capture
