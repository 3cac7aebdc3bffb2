// Bits of a pixel's count word and of the specialization constant that switches parts of the algorithm. Included by host
// and shaders.
#ifndef SUBPIXEL_STREAMING_TYPES_H
#define SUBPIXEL_STREAMING_TYPES_H

// The count word (Kerzner and Salvi 2014, section 4): how many surfaces, their slots from front to back with two bits each,
// and whether one that was still visible has been discarded. The paper uses 9 of its 32 bits for three surfaces; the
// others count what happened to the pixel. Both counts stop at their largest value.
#define STREAM_COUNT_BITS 3
#define STREAM_ORDER_SHIFT 3
#define STREAM_ORDER_BITS 8
#define STREAM_DISCARD_SHIFT 11
#define STREAM_MERGES_SHIFT 12
#define STREAM_MERGES_BITS 10
#define STREAM_DROPPED_SHIFT 22  // samples
#define STREAM_DROPPED_BITS 10

#define STREAM_MAX_SURFACES 4

// Specialization constant 12.
#define STREAM_MERGE_NORMALS 1u       // the three conditions of section 3.1
#define STREAM_MERGE_DEPTH 2u
#define STREAM_MERGE_COVERAGE 4u
#define STREAM_WEIGHT_COVERAGE 8u     // a merge weights both sides by their samples, not equally
#define STREAM_DEPTH_TESTED 32u       // beyond the paper: the depth test of each sample decides what hides it
#define STREAM_DISCARD_RESOLVED 64u   // the surface with the smallest depth-resolved mask has to go, as the text can be read
#define STREAM_CLIP_SPACE 16u         // depths and slopes of reversed depth, not of the distance along the view
#endif
