// The triangle buffer of deferred attribute interpolation. Included by host and shaders.
// Schied and Dachsbacher 2015, "Deferred Attribute Interpolation for Memory-Efficient Deferred Shading".
#ifndef SUBPIXEL_DAIS_INTERFACE_H
#define SUBPIXEL_DAIS_INTERFACE_H

#include "../../frontend/frontend_interface.h"
#include "../../include/shared_types.h"

#define DAIS_SLOT_TRIANGLES 1  // storage: a TriangleBuffer

// Words of a stored triangle: the sample point (pixels); the change of 1 / w per pixel in x and y over its value there;
// depth as TriangleRecord has it, with the largest; the reference pixel. Then three words for each attribute's scalar:
// its value at the sample point, and the change of attribute / w per pixel over 1 / w there. Attributes come in the order of
// normal, coordinates, second coordinates, colour, tangent; those that no material needs are left out.
#define DAIS_HEAD_WORDS 10u
#define DAIS_NORMAL_SCALARS 3u
#define DAIS_COORDINATES_OF(features)                                                                  \
  ((((features) & (FEATURE_BASE_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_ROUGHNESS_TEXTURE |             \
                   FEATURE_EMISSIVE_TEXTURE)) != 0u)                                                   \
       ? 2u                                                                                            \
       : 0u)
#define DAIS_SCALARS(features)                                                                         \
  (DAIS_NORMAL_SCALARS + DAIS_COORDINATES_OF(features) + 2u * BIT_OF(features, FEATURE_SECOND_UV) +    \
   4u * BIT_OF(features, FEATURE_VERTEX_COLOUR) + 4u * BIT_OF(features, FEATURE_NORMAL_MAP))
#define DAIS_WORDS(features) (DAIS_HEAD_WORDS + 3u * DAIS_SCALARS(features))

// In the first word: planes would not hold over the triangle, so its fragments go back to the vertices.
#define DAIS_NO_PLANES 0xffffffffu
// They would not where weights change by more than this in a pixel: a vertex snapped to 1/256 pixel puts samples up to an
// eighth of the triangle outside of it.
#define DAIS_STEEPEST 32.0
// Nor where 1 / w falls to less than this part of what it is at the sample point, since the difference is what is left.
#define DAIS_LEAST_PART (1.0 / 1024.0)

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Members are in triangles.glsl.
BUFFER_REFERENCE(TriangleNumbers)
BUFFER_REFERENCE(TriangleWords)

struct TriangleBuffer {
  ADDRESS(TriangleNumbers) numbers;  // of fragments, and one more
  ADDRESS(TriangleWords) words;
  uint capacity;  // triangles
};

// Of number.comp.
struct DaisNumberPush {
  uint fragments;
};

#ifdef __cplusplus
static_assert(DAIS_WORDS(FEATURE_BASE_TEXTURE) == 25);
}  // namespace subpixel::gpu_types
#endif
#endif
