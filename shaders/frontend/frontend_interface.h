// What host and front-end agree on, and passes of techniques that take fragments from it: push constants and slots.
#ifndef SUBPIXEL_FRONTEND_INTERFACE_H
#define SUBPIXEL_FRONTEND_INTERFACE_H

#include "frontend_types.h"
#include "../include/interface.h"

// Slots of passes over listed fragments; a technique's own begin behind them.
#define FRONTEND_SLOT_LISTS 0  // storage, a ListAddresses

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

BUFFER_REFERENCE(Records)
BUFFER_REFERENCE(Positions)
BUFFER_REFERENCE(Normals)
BUFFER_REFERENCE(Uvs)
BUFFER_REFERENCE(Tangents)
BUFFER_REFERENCE(Colours)
BUFFER_REFERENCE(Indices)
BUFFER_REFERENCE(ClipMatrices)
BUFFER_REFERENCE(Instances)
BUFFER_REFERENCE(Fragments)
BUFFER_REFERENCE(FragmentNumbers)
BUFFER_REFERENCE(PixelEnds)
BUFFER_REFERENCE(FragmentBases)

// Of hull.vert and all that fragment.glsl is part of.
struct HullPush {
  ADDRESS(Records) records;
  ADDRESS(Positions) positions;
  ADDRESS(Normals) normals;
  ADDRESS(Uvs) uvs;
  ADDRESS(Tangents) tangents;
  ADDRESS(Indices) indices;
  ADDRESS(ClipMatrices) clip_matrices;
  ADDRESS(Instances) instances;
  ADDRESS(Uvs) second_uvs;
  ADDRESS(Colours) colours;
  uint material;        // of the batch
  uint triangle_slots;  // records of clipped pieces start here
  uint first_fragment;  // of passes over lists: the batch is [first, last), by triangle
  uint last_fragment;
};

// The blocks are those of fragment_lists.glsl.
struct ListAddresses {
  ADDRESS(Fragments) fragments;
  ADDRESS(FragmentNumbers) numbers;
  ADDRESS(PixelEnds) ends;
  ADDRESS(FragmentBases) bases;
};

// Of collect.comp.
struct CollectPush {
  ListAddresses lists;
  ADDRESS(Records) records;
  uint count;   // small triangles
  uint groups;  // dealt_item()
  uint runs;
  uint width;
  uint height;
};

#ifdef __cplusplus
static_assert(sizeof(HullPush) == 96);
static_assert(sizeof(ListAddresses) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
