// What host and shaders of decoupled coverage anti-aliasing share.
#ifndef SUBPIXEL_DCAA_INTERFACE_H
#define SUBPIXEL_DCAA_INTERFACE_H

#include "../../include/ordered_state.h"
#include "../../include/shared_types.h"
#include "../agaa/agaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define DCAA_MAX_SURFACES 8

#define DCAA_CONSTANT_SURFACES (AGAA_CONSTANTS_END + 0)
#define DCAA_CONSTANT_COS_NORMAL_ANGLE (AGAA_CONSTANTS_END + 1)
#define DCAA_CONSTANT_OPTIONS (AGAA_CONSTANTS_END + 2)        // DCAA_ bits
#define DCAA_CONSTANT_NORMAL_FORMAT (AGAA_CONSTANTS_END + 3)  // DCAA_NORMAL_
#define DCAA_CONSTANT_DEPTH_BITS (AGAA_CONSTANTS_END + 4)
#define DCAA_CONSTANT_TABLE_DIRECTIONS (AGAA_CONSTANTS_END + 5)
#define DCAA_CONSTANT_TABLE_DISTANCES (AGAA_CONSTANTS_END + 6)
#define DCAA_CONSTANT_DEPTH_REACH (AGAA_CONSTANTS_END + 7)
#define DCAA_CONSTANT_INVERSE_LENGTH (AGAA_CONSTANTS_END + 8)
#define DCAA_CONSTANT_LEAST_SHOWN (AGAA_CONSTANTS_END + 9)  // samples; of the pass that lights
#define DCAA_CONSTANT_FIRST_MAP (AGAA_CONSTANTS_END + 10)     // of maps.frag, which writes so many at a time:
#define DCAA_MAPS_AT_A_TIME 3

#define DCAA_SECOND_MERGE 1u   // section 3.3: merge the surface that has to go, if one overlaps it in depth
#define DCAA_KEEP_FRONT 2u     // section 3.3: the front-most surface never has to go
#define DCAA_TABLE 4u          // coverage from the table, not exact
#define DCAA_PREPASS 8u        // fragments behind the prepass's bound are dropped
#define DCAA_WEIGHT_SHOWN 16u  // a merge weights the one behind by the samples that the one in front leaves it
#define DCAA_DISTRIBUTION 32u  // shading normals keep the length of their mean
#define DCAA_NEAREST 64u       // the second merge: with the nearest by the distance of aggregates, whose plane stays
#define DCAA_SECOND_MOMENTS 128u  // surfaces keep the second moments of their shading normals, too
#define DCAA_SHOWN_PART 256u      // fragments bring only samples that no surface wholly in front of them covers
#define DCAA_MASKS_MADE 512u      // of passes over lists: fragments have their masks from a pass of their own

// How a facet normal is stored.
#define DCAA_NORMAL_2X16 0u  // octahedral (Cigolle et al. 2014)
#define DCAA_NORMAL_2X8 1u
#define DCAA_NORMAL_3X8 2u  // three components
#define DCAA_NORMAL_3X32 3u

// Storage, beside those of ordered_state.h.
#define DCAA_SLOT_TABLE 1
#define DCAA_SLOT_VIEW 2
// Sampled.
#define DCAA_SLOT_BOUND 0  // of the pass that merges, whose state is not sampled
#define DCAA_SLOT_FOUND 4  // storage: where it is

// The count word: surfaces stored, then what happened to the pixel. Counts stop at their largest value. The paper needs
// no such word, since a stored surface always covers something; ours feeds the maps.
#define DCAA_COUNT_BITS 4
#define DCAA_FIRST_SHIFT 4  // first merges
#define DCAA_FIRST_BITS 12
#define DCAA_SECOND_SHIFT 16  // second merges
#define DCAA_SECOND_BITS 8
#define DCAA_DISCARD_SHIFT 24  // surfaces discarded
#define DCAA_DISCARD_BITS 8

// A pixel's state: the count word, then the surfaces (state.glsl), of 7 words (28 bytes, section 4.3), fewer where the
// scene emits nothing or a mask fits one word, more for the wider formats that the paper compares with and for second
// moments.
#define DCAA_COVERAGE_WORDS(samples) ((samples) / 64u + 1u)
#define DCAA_FACET_WORDS(normal_format) ((normal_format) == DCAA_NORMAL_3X32 ? 3u : 1u)
#define DCAA_WIDE_DEPTH_WORDS(depth_bits) ((depth_bits) == 32u ? 1u : 0u)
#define DCAA_MOMENT_WORDS(options) (((options) & DCAA_SECOND_MOMENTS) != 0u ? 3u : 0u)
#define DCAA_SURFACE_WORDS(samples, features, options, normal_format, depth_bits)                            \
  (DCAA_COVERAGE_WORDS(samples) + DCAA_FACET_WORDS(normal_format) + 3u + DCAA_WIDE_DEPTH_WORDS(depth_bits) + \
   BIT_OF(features, FEATURE_EMISSIVE) + DCAA_MOMENT_WORDS(options))
#define DCAA_STATE_QUADS(surfaces, surface_words) ORDERED_QUADS_OF(1u + (surfaces) * (surface_words))

// Storage buffer. From facet normals (world space) to planes of reversed depth over the screen. Directions of view rays
// are linear in the pixel (x, y): ray = ray0 + rays_differ * (x ray_dx + y ray_dy). A facet's normal n then gives the
// slopes
//   g = (n.ray_dx, n.ray_dy) / n.ray,   (dz/dx, dz/dy) = (z * rays_differ + scale) * g,
// and slopes give n, up to its length, as gx normal_x + gy normal_y + (1 - rays_differ * (gx x + gy y)) normal_1.
struct DcaaView {
  vec4 ray_dx, ray_dy, ray0;          // w: largest n.ray that counts (negative), limit of g, the band's first row
  vec4 normal_x, normal_y, normal_1;  // facing the eye
  // rays_differ: 1 with perspective, else 0; scale; and how depths are places on a ray: the point at depth z is at
  // w / (z + scale) times the ray from the eye with perspective (w: z of this vector), else at -z times the ray.
  vec4 terms;
};

// Of each listed fragment that is kept.
struct DcaaListedSurface {
  uvec4 words;  // facet, depth bits, albedo, normal
  uvec4 more;   // roughness, emission, the facet's further words
};

#ifdef __cplusplus
static_assert(sizeof(DcaaView) == 112);
static_assert(sizeof(DcaaListedSurface) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
