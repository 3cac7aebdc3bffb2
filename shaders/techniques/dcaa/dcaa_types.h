// What host and shaders of decoupled coverage anti-aliasing share: bits of a pixel's count word, options, the camera.
#ifndef SUBPIXEL_DCAA_TYPES_H
#define SUBPIXEL_DCAA_TYPES_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::vec4;
#endif

#define DCAA_MAX_SURFACES 8

// The count word: surfaces stored, then what happened to the pixel. Counts stop at their largest value. The paper needs no
// such word, since a stored surface always covers something; ours feeds the maps.
#define DCAA_COUNT_BITS 4
#define DCAA_FIRST_SHIFT 4  // first merges
#define DCAA_FIRST_BITS 12
#define DCAA_SECOND_SHIFT 16  // second merges
#define DCAA_SECOND_BITS 8
#define DCAA_DISCARD_SHIFT 24  // surfaces discarded
#define DCAA_DISCARD_BITS 8

// Specialization constant 12.
#define DCAA_SECOND_MERGE 1u  // section 3.3: merge the surface that has to go, if one overlaps it in depth
#define DCAA_KEEP_FRONT 2u    // section 3.3: the front-most surface never has to go
#define DCAA_TABLE 4u         // coverage from the table, not exact
#define DCAA_PREPASS 8u       // fragments behind the prepass's bound are dropped
#define DCAA_WEIGHT_SHOWN 16u  // a merge weights the one behind by the samples that the one in front leaves it
#define DCAA_DISTRIBUTION 32u  // shading normals keep the length of their mean
#define DCAA_SECOND_MOMENTS 128u  // surfaces keep the second moments of their shading normals, too
#define DCAA_NEAREST 64u  // the second merge is with the nearest surface by the distance of aggregates, whose plane stays

// Specialization constant 13: how a facet normal is stored.
#define DCAA_NORMAL_2X16 0u  // octahedral (Cigolle et al. 2014)
#define DCAA_NORMAL_2X8 1u
#define DCAA_NORMAL_3X8 2u  // three components
#define DCAA_NORMAL_3X32 3u

// From facet normals (world space) to planes of reversed depth over the screen. Directions of view rays are linear in the
// pixel (x, y): ray = ray0 + rays_differ * (x ray_dx + y ray_dy). A facet's normal n then gives the slopes
//   g = (n.ray_dx, n.ray_dy) / n.ray,   (dz/dx, dz/dy) = (z * rays_differ + scale) * g,
// and slopes give n, up to its length, as gx normal_x + gy normal_y + (1 - rays_differ * (gx x + gy y)) normal_1.
struct DcaaView {
  vec4 ray_dx, ray_dy, ray0;           // w: largest n.ray that counts (negative), limit of g, unused
  vec4 normal_x, normal_y, normal_1;  // facing the eye
  // rays_differ: 1 with perspective, else 0; scale; and how depths are places on a ray: the point at depth z is at
  // w / (z + scale) times the ray from the eye with perspective (w: z of this vector), else at -z times the ray.
  vec4 terms;
};

#ifdef __cplusplus
static_assert(sizeof(DcaaView) == 112);
}  // namespace subpixel::gpu_types
#endif
#endif
