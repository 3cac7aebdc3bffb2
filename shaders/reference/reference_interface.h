// What the reference's passes share with the host.
#ifndef SUBPIXEL_REFERENCE_INTERFACE_H
#define SUBPIXEL_REFERENCE_INTERFACE_H

#include "../include/interface.h"

#define REFERENCE_CONSTANT_TONE_MAP_SAMPLES 7  // 1: also sum the display values of shading samples
#define REFERENCE_CONSTANT_SIDE 8  // samples of a turn in each row and column of a pixel, 2 or 4
#define REFERENCE_CONSTANT_SHADE_ALL_SAMPLES 9  // 1: shade a triangle at each of a turn's samples that see it

// Storage; materials, mappings and cones are where the frame has them.
#define REFERENCE_SLOT_TURN 0
#define REFERENCE_SLOT_LEVELS 1
#define REFERENCE_SLOT_MATERIAL_TEXTURES 2
#define REFERENCE_SLOT_STORY 3  // of accumulate.comp:STORY
// Sampled.
#define REFERENCE_SLOT_SEEN 0

#ifdef __cplusplus
namespace subpixel::gpu_types {
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

// One turn: the image drawn at two or four times the width and height, so that four or sixteen texels' centres are
// samples of each pixel, and shifted by less than half a texel.
struct TurnConstants {
  vec4 shift;    // x, y in pixels; z, w the same in clip space, for w 1
  uvec4 number;  // x: number of the turn, y: turns in all, z: side
  vec4 choice;   // x in [0, 1): which of the samples that see a triangle it is shaded at, as a share of them
};

// What one pixel was shaded by in a turn.
struct ReferenceShading {
  uvec4 of;  // the triangle's number, those of the turn's samples that see it
  vec4 at;   // in the pixel, 0 to 1 each way
  vec4 radiance;
};
struct ReferenceStory {
  uvec4 head;  // pixel, shadings
  ReferenceShading shading[16];
};

// Members are in triangles.glsl.
BUFFER_REFERENCE(Corners)
BUFFER_REFERENCE(Triangles)
BUFFER_REFERENCE(Words)
BUFFER_REFERENCE(Vectors2)
BUFFER_REFERENCE(Vectors3)
BUFFER_REFERENCE(Vectors4)
BUFFER_REFERENCE(Instances)
BUFFER_REFERENCE(Pixels)

// Of all the reference's passes.
struct ReferencePush {
  ADDRESS(Corners) corners;
  ADDRESS(Triangles) triangles;
  ADDRESS(Words) indices;
  ADDRESS(Vectors3) normals;
  ADDRESS(Vectors2) uvs;
  ADDRESS(Vectors4) tangents;
  ADDRESS(Instances) instances;
  ADDRESS(Words) texels;
  ADDRESS(Pixels) sums;          // of linear radiance over the turns
  ADDRESS(Pixels) compensation;  // what the sums lost to rounding
  ADDRESS(Pixels) display_sums;  // of tone-mapped shading samples
  ADDRESS(Vectors2) second_uvs;
  ADDRESS(Vectors4) colours;
};

#ifdef __cplusplus
static_assert(sizeof(ReferencePush) == 104);
static_assert(sizeof(ReferenceTriangle) == 16);
static_assert(sizeof(TurnConstants) == 48);
static_assert(sizeof(ReferenceStory) == 16 + 16 * 48);
}  // namespace subpixel::gpu_types
#endif
#endif
