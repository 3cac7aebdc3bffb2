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

// One level of one texture: first texel, width, height, LEVEL_ bits.
struct TextureLevel {
  uvec4 place;
};
#define LEVEL_SRGB 1u
// The texture's sampler. Two bits for each axis: 0 repeats, 1 clamps, 2 mirrors.
#define LEVEL_WRAP_U_SHIFT 1
#define LEVEL_WRAP_V_SHIFT 3
#define LEVEL_MAGNIFY_NEAREST 32u
#define LEVEL_MINIFY_NEAREST 64u
#define LEVEL_MIP_NEAREST 128u
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
