// What host and shaders of the streaming compression share.
#ifndef SUBPIXEL_STREAMING_INTERFACE_H
#define SUBPIXEL_STREAMING_INTERFACE_H

#include "../../include/ordered_state.h"
#include "../../include/shared_types.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define STREAM_MAX_SURFACES 4

#define STREAM_CONSTANT_SURFACES (PASS_CONSTANTS + 0)
#define STREAM_CONSTANT_COS_NORMAL_ANGLE (PASS_CONSTANTS + 1)
#define STREAM_CONSTANT_OPTIONS (PASS_CONSTANTS + 2)  // STREAM_ bits

#define STREAM_MERGE_NORMALS 1u  // the three conditions of section 3.1
#define STREAM_MERGE_DEPTH 2u
#define STREAM_MERGE_COVERAGE 4u
#define STREAM_WEIGHT_COVERAGE 8u  // a merge weights both sides by their samples, not equally
#define STREAM_DISCARD_RESOLVED 64u   // the smallest depth-resolved mask has to go, as the text can be read
#define STREAM_CLIP_SPACE 16u      // depths and slopes of reversed depth, not of the distance along the view
#define STREAM_DEPTH_TESTED 32u    // beyond the paper: the depth test of each sample decides what hides it

// The count word (Kerzner and Salvi 2014, section 4): how many surfaces, their slots from front to back with two bits
// each, and whether one that was still visible has been discarded. The paper uses 9 of its 32 bits for three surfaces;
// the others count what happened to the pixel. Both counts stop at their largest value.
#define STREAM_COUNT_BITS 3
#define STREAM_ORDER_SHIFT 3
#define STREAM_ORDER_BITS 8
#define STREAM_DISCARD_SHIFT 11
#define STREAM_MERGES_SHIFT 12
#define STREAM_MERGES_BITS 10
#define STREAM_DROPPED_SHIFT 22  // samples
#define STREAM_DROPPED_BITS 10

// A pixel's state: a depth for each sample, the count word, the surfaces (state.glsl). Up to 8 samples a surface's two
// masks and its roughness share a word; at 32 each mask has its own.
#define STREAM_ROUGHNESS_WORDS(samples, features) \
  (BIT_OF(features, FEATURE_VARYING_ROUGHNESS) * ((samples) / 16u - (samples) / 32u))
#define STREAM_SURFACE_WORDS(samples, features) \
  (5u + (samples) / 32u + STREAM_ROUGHNESS_WORDS(samples, features) + BIT_OF(features, FEATURE_EMISSIVE))
#define STREAM_STATE_QUADS(samples, features, surfaces) \
  ORDERED_QUADS_OF((samples) + 1u + (surfaces) * STREAM_SURFACE_WORDS(samples, features))

// Of the ordered pass: the depths, then a quad of the count word, how many words of surfaces the pixel's fragments loaded and how
// many they stored; the surfaces are entries (ordered_entries.glsl).
#define STREAM_HEAD_QUADS(samples) ((samples) / 4u + 1u)

// Of each listed fragment that passed the depth test.
struct StreamListedSurface {
  uvec4 words;  // depth bits, slopes, albedo, normal
  uvec2 more;   // roughness, emission
};

#ifdef __cplusplus
static_assert(sizeof(StreamListedSurface) == 24);
}  // namespace subpixel::gpu_types
#endif
#endif
