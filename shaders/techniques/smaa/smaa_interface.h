// What host and passes agree on.
#ifndef SUBPIXEL_SMAA_INTERFACE_H
#define SUBPIXEL_SMAA_INTERFACE_H

#include "../../include/interface.h"

// Sampled.
#define SMAA_SLOT_DISPLAYED 0
#define SMAA_SLOT_VALUES 1
#define SMAA_SLOT_EDGES 2
#define SMAA_SLOT_WEIGHTS 3
// Storage.
#define SMAA_SLOT_AREAS 0

// Bits of a pixel of the image of edges. Also what crosses an edge at one of its ends, by the side it is on.
#define SMAA_EDGE_WEST 1u
#define SMAA_EDGE_NORTH 2u
#define SMAA_CROSSED_BEFORE 1u  // on the side of lower coordinates: above a level edge
#define SMAA_CROSSED_AFTER 2u

// Distances that the table of areas has in each direction: squares of 0 to 15, and for diagonals 0 to 19.
#define SMAA_AREA_DISTANCES 16
#define SMAA_DIAGONAL_DISTANCES 20

#define SMAA_EDGES_OF_LUMA 0u
#define SMAA_EDGES_OF_COLOUR 1u
#define SMAA_BLENDS_DISPLAYED 0u
#define SMAA_BLENDS_RADIANCE 1u

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct SmaaEdgesPush {
  float threshold;   // display values
  float adaptation;  // an edge is lost beside one that many times its contrast
  uint edges;        // SMAA_EDGES_
};

struct SmaaWeightsPush {
  uint search_steps;    // of two pixels, in each direction
  uint diagonal_steps;  // of one; 0: diagonals are not looked for
  float rounding;       // what is left of the blending at a sharp corner
};

struct SmaaBlendPush {
  uint blend;  // SMAA_BLENDS_
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
