// What host and shaders of the aggregate technique share.
#ifndef SUBPIXEL_AGAA_INTERFACE_H
#define SUBPIXEL_AGAA_INTERFACE_H

#include "../../frontend/frontend_interface.h"
#include "../../include/shared_types.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define AGAA_MAX_AGGREGATES 4

#define AGAA_CONSTANT_AGGREGATES (PASS_CONSTANTS + 0)
#define AGAA_CONSTANT_OPTIONS (PASS_CONSTANTS + 1)      // AGAA_ bits
#define AGAA_CONSTANT_SHADOW_TAPS (PASS_CONSTANTS + 2)  // points of a footprint that look its shadow up
#define AGAA_CONSTANTS_END (PASS_CONSTANTS + 3)         // for techniques whose shaders include ours

#define AGAA_FLOAT 1u                // sums of 32-bit floats, not the paper's fixed point
#define AGAA_SGGX 2u                 // second moments of the normals as well
#define AGAA_ROUGHNESS_IN_NORMAL 4u  // roughness shortens the normals, and is not kept by itself
#define AGAA_DISTANCE_ALONG_VIEW 8u  // face normals: the eye looks along +z of view space
#define AGAA_LEAN 16u                // moments of the normals' slopes as well; not with AGAA_SGGX
#define AGAA_LIGHT_VARIANCE 32u      // the spread of a light's directions widens the distribution of normals
#define AGAA_LIT 64u                 // colours multiplied by each sample's shadow as well

#define AGAA_SLOT_STATE 1       // storage: AgaaState
#define AGAA_SLOT_MEMBERSHIP 1  // sampled: bits 0 and 1 of every sample's aggregate

// An aggregate's words (aggregate.glsl): in fixed point three, one more with metal and one more for a mask of over 8
// samples; or eleven floats. Then its emission, then the moments of its normals or of their slopes, then its sunlit colours.
#define AGAA_FIXED_WORDS(samples, features) (3u + BIT_OF(features, FEATURE_METAL) + ((samples) > 8u ? 1u : 0u))
#define AGAA_EMISSION_WORD(samples, features, options) \
  (((options) & AGAA_FLOAT) != 0u ? 11u : AGAA_FIXED_WORDS(samples, features))
#define AGAA_MOMENTS_WORD(samples, features, options) \
  (AGAA_EMISSION_WORD(samples, features, options) + 3u * BIT_OF(features, FEATURE_EMISSIVE))
#define AGAA_MOMENTS_WORDS(options)                                                                 \
  (((options) & AGAA_SGGX) != 0u ? (((options) & AGAA_FLOAT) != 0u ? 6u : 3u)                        \
                                 : (((options) & AGAA_LEAN) != 0u ? (((options) & AGAA_FLOAT) != 0u ? 5u : 4u) : 0u))
#define AGAA_LIT_WORD(samples, features, options) \
  (AGAA_MOMENTS_WORD(samples, features, options) + AGAA_MOMENTS_WORDS(options))
#define AGAA_WORDS(samples, features, options) \
  (AGAA_LIT_WORD(samples, features, options) + \
   (((options) & AGAA_LIT) == 0u ? 0u : (((options) & AGAA_FLOAT) != 0u ? 6u : 2u)))

BUFFER_REFERENCE(AggregateSums)
BUFFER_REFERENCE(Hulls)
BUFFER_REFERENCE(Faces)

// Storage buffer: the pixels' aggregates, and what each visible fragment adds to one.
struct AgaaState {
  ADDRESS(AggregateSums) sums;
  ADDRESS(AggregateSums) parts;
  float largest_emission;  // of the scene; 1 where nothing emits
};

// Of faces.comp.
struct AgaaFacesPush {
  ADDRESS(Hulls) hulls;
  ADDRESS(Records) records;
  ADDRESS(Positions) positions;
  ADDRESS(Indices) indices;
  ADDRESS(Instances) instances;
  ADDRESS(Faces) faces;
  uint hull_triangles;
  uint row;             // invocations in x
  float largest_polar;  // radians from the axis towards the eye that a visible face normal can have
};

// Of define.frag.
struct AgaaDefinePush {
  mat4 view_from_clip;
  ADDRESS(Faces) faces;
  float inverse_length;  // 1 / world units
  float separation;
};

// Of shade.frag and maps.frag.
struct AgaaShadePush {
  mat4 view_from_clip;
};

#ifdef __cplusplus
static_assert(sizeof(AgaaState) == 24);
static_assert(sizeof(AgaaFacesPush) == 64);
static_assert(sizeof(AgaaDefinePush) == 80);
}  // namespace subpixel::gpu_types
#endif
#endif
