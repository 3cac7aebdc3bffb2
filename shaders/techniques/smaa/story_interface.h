// What host and the variants of the passes agree on that tell what they make of one pixel.
#ifndef SUBPIXEL_SMAA_STORY_INTERFACE_H
#define SUBPIXEL_SMAA_STORY_INTERFACE_H

#include "smaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define SMAA_SLOT_STORY 5  // storage: the header, then the structures below

// The pixel, its eastern and its southern neighbour, whose west and north edges are the pixel's other two.
#define SMAA_STORY_PIXELS 3

struct SmaaEdgesStory {
  vec4 steps;  // contrast with west, north, east, south
  vec4 more;   // of west and north with those beyond; the largest of all six
  uvec4 head;  // SMAA_EDGE_ bits; 1: the pixel is in the image
};

// What was looked at, bits of `head`.
#define SMAA_TOLD_LEVEL 1u
#define SMAA_TOLD_UPRIGHT 2u
#define SMAA_TOLD_RISING 4u
#define SMAA_TOLD_FALLING 8u

// Of lines the level one, then the upright one; of diagonals the rising one, then the falling one.
struct SmaaWeightsStory {
  uvec4 head;             // SMAA_TOLD_, the four weights as bytes, 1: the pixel is in the image
  vec4 weights;           // before they are rounded
  uvec4 line[2];          // pixels to the line's ends, what crosses it there (SMAA_CROSSED_)
  vec4 line_areas[2];     // of the pixel and of the one across, what corners leave of each
  uvec4 diagonal[2];      // steps to its ends, its edges that go on there
  vec4 diagonal_areas[2]; // of the pixel and of the one across
};

struct SmaaBlendStory {
  vec4 weights;  // north, south, west, east
  uvec4 head;    // 1: with the neighbours west and east; 1: blended
  vec4 own, before, after;  // values; of the neighbours north and south, or west and east
  vec4 mixed;    // value; the neighbours' share
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
