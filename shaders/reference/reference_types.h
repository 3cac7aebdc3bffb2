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

// One turn: a shift of the image under the rasteriser's four samples. The target is a pixel larger each way, and each
// output pixel takes the samples that the shift brings into it: one of each kind, maybe from neighbouring texels.
struct TurnConstants {
  vec4 clip;      // scale in x, y and offset in x, y of clip positions
  vec4 offset01;  // where samples 0 and 1 lie in their output pixel, pixels from its corner
  vec4 offset23;
  uvec4 texel;   // sample s is in the texel (pixel + (bit 2s, bit 2s+1) of x)
  uvec4 number;  // x: number of the turn, y: turns in all
};

#ifdef __cplusplus
static_assert(sizeof(ReferenceTriangle) == 16);
static_assert(sizeof(TurnConstants) == 80);
}  // namespace subpixel::gpu_types
#endif
#endif
