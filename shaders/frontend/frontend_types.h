// What the front-end's set-up hands to the geometry passes. Included by host and shaders.
#ifndef SUBPIXEL_FRONTEND_TYPES_H
#define SUBPIXEL_FRONTEND_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::uvec4;
using glm::vec4;
#endif

// Vertices are snapped to 1/256 pixel; sample positions lie on a 1/128 pixel grid around the pixel's centre.
#define SUBPIXEL_SNAP 256
#define SUBPIXEL_SAMPLE_GRID 128
// Pixels beyond the viewport that snapped vertices may reach; triangles that go further are clipped there.
#define SUBPIXEL_GUARD_BAND_PX 4096
#define SUBPIXEL_CHUNK_TRIANGLES 64
// A clipped triangle is a polygon of at most 3 + 6 corners, so at most 7 triangles.
#define SUBPIXEL_MAX_CLIP_PIECES 7u
// Visibility of a sample that nothing covers.
#define SUBPIXEL_NO_TRIANGLE 0xffffffffu

// Up to 64 consecutive triangles of one instance: what one workgroup sets up.
struct ChunkRecord {
  uvec4 range;  // first index, triangles, instance, material
  uvec4 flags;  // x: CHUNK_ bits
};
#define CHUNK_CULL_BACK 1u
#define CHUNK_ALPHA_TEST 2u

// One front-facing-by-construction screen triangle: its snapped vertices are ordered so that the area is positive.
struct TriangleRecord {
  uvec4 hull01;    // float bits: corners 0 and 1 of the conservative hull, pixels
  uvec4 hull2_id;  // float bits: corner 2; then first index of the source triangle, instance
  uvec4 v01;       // int bits: snapped vertices 0 and 1, 1/256 pixel of the band
  uvec4 v2_ref;    // int bits: snapped vertex 2; then reference pixel of the band, x | y << 16; then RECORD_ bits | material
  uvec4 depth;     // float bits: z at the reference pixel's centre, dz/dx, dz/dy per pixel, smallest z of the triangle
  uvec4 depth2;    // float bits: largest z of the triangle; then corner 3 of the hull, if it has one; slot of the source triangle
};
#define RECORD_BACK_FACE 1u
#define RECORD_MIRRORED 2u
#define RECORD_LARGE 4u  // over SUBPIXEL_SMALL_PX pixels wide or high, which decides how edges are computed (coverage.glsl)
#define RECORD_MATERIAL_SHIFT 3
// Screen triangles whose samples lie in no more pixels than this are small: passes may rasterise them in compute.
#define SUBPIXEL_SMALL_TRIANGLE_PX 512.0
// What set-up says of a triangle's slot: how many triangles its hull has, or how many clipped pieces there are; of a small one
// also how many blocks (small_triangles.glsl) its bounding box touches, at most 16 x 31.
#define COUNT_CLIPPED 0x80000000u
#define COUNT_SMALL 0x40000000u         // opaque
#define COUNT_SMALL_TESTED 0x20000000u  // alpha-tested
#define COUNT_BLOCKS_SHIFT 4
#define COUNT_BLOCKS_MASK 0x3ffu
#define COUNT_MASK 0xfu
#define SUBPIXEL_SMALL_PX 60

// What the lists by block need of a small triangle.
struct SmallTriangle {
  uvec4 v01, v2_ref, depth;  // as in TriangleRecord
  uvec4 depth2_id;           // depth2.x of TriangleRecord; then the record's number
};

#ifdef __cplusplus
static_assert(sizeof(SmallTriangle) == 64);
static_assert(sizeof(ChunkRecord) == 32);
static_assert(sizeof(TriangleRecord) == 96);
}  // namespace subpixel::gpu_types
#endif
#endif
