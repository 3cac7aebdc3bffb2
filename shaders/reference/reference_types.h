// What the reference's passes share with the host.
#ifndef SUBPIXEL_REFERENCE_TYPES_H
#define SUBPIXEL_REFERENCE_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::uvec4;
using glm::vec4;
#endif

// One triangle that may be seen. Its homogeneous corners are in a buffer of their own, for the vertex shader.
struct ReferenceTriangle {
  uvec4 source;  // first index, instance, material, REFERENCE_ bits
};
#define REFERENCE_BACK_FACE 1u

// One level of one texture: first texel, width, height, 1 when sRGB.
struct TextureLevel {
  uvec4 place;
};
// A texture is its first level's number | levels << 24; none:
#define REFERENCE_NO_TEXTURE 0xffffffffu

// One turn: the image drawn at twice the width and height, so that four texels' centres are samples of each pixel, and
// shifted by less than half a texel.
struct TurnConstants {
  vec4 shift;    // x, y in pixels; z, w the same in clip space, for w 1
  uvec4 number;  // x: number of the turn, y: turns in all
};

#ifdef __cplusplus
static_assert(sizeof(ReferenceTriangle) == 16);
static_assert(sizeof(TurnConstants) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
