// What host and front-end agree on, and passes of techniques that take fragments from it: push constants, slots,
// specialization constants.
#ifndef SUBPIXEL_FRONTEND_INTERFACE_H
#define SUBPIXEL_FRONTEND_INTERFACE_H

#include "../include/interface.h"
#include "../scene/scene_interface.h"
#include "frontend_types.h"

#define FRONTEND_CONSTANT_AFTER_SMALL 7   // visibility.frag: small triangles are there
#define FRONTEND_CONSTANT_WITH_MASKS 8    // collect.*
#define FRONTEND_CONSTANT_LITMUS_WIDTH 9  // litmus.frag, pixels

// Storage. Set-up, chunk by chunk:
#define FRONTEND_SLOT_CHUNKS 0
#define FRONTEND_SLOT_COUNTS 1  // of slots, COUNT_ bits
#define FRONTEND_SLOT_SUMS 2    // of chunks, or of whatever scan.comp scans
#define FRONTEND_SLOT_PIECE_BASES 3
#define FRONTEND_SLOT_CLIP_LIST 4
#define FRONTEND_SLOT_CLIP_COUNT 5
#define FRONTEND_SLOT_HULL_INDICES 6
// Draws:
#define FRONTEND_SLOT_BATCHES 4
#define FRONTEND_SLOT_COMMANDS 5
// Small triangles:
#define FRONTEND_SLOT_SMALL_RECORDS 4
#define FRONTEND_SLOT_SMALL_TRIANGLES 5
#define FRONTEND_SLOT_BLOCK_ENDS 6
#define FRONTEND_SLOT_BLOCK_LISTS 7
// Visibility without an order of fragments; a NearestAddresses:
#define FRONTEND_SLOT_NEAREST 0
// Longer lists of a pixel are sorted and merged in parts of so many fragments, each by a pass of its own: some drivers end loops
// after 65,535 turns, all of an invocation together.
#define SUBPIXEL_LIST_PART 900u
#define SUBPIXEL_LIST_PARTS 4u  // at most

// Lists of fragments; slots of techniques' own begin behind the first.
#define FRONTEND_SLOT_LISTS 0           // a ListAddresses
#define FRONTEND_SLOT_FRAGMENT_BASES 4  // of records
#define FRONTEND_SLOT_ITEMS 4           // of pixel_bases.comp
// What tells about the device:
#define FRONTEND_SLOT_TURNS 0
#define FRONTEND_SLOT_LITMUS_STATES 0

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Members are in frontend/buffers.glsl, those of the lists in fragment_lists.glsl.
BUFFER_REFERENCE(Records)
BUFFER_REFERENCE(ClipMatrices)
BUFFER_REFERENCE(HullIndices)
BUFFER_REFERENCE(Fragments)
BUFFER_REFERENCE(FragmentNumbers)
BUFFER_REFERENCE(PixelEnds)
BUFFER_REFERENCE(FragmentBases)
BUFFER_REFERENCE(NearestWords)
BUFFER_REFERENCE(SmallTriangles)
BUFFER_REFERENCE(SmallWords)

// Of setup.comp and clip.comp.
struct SetupPush {
  ADDRESS(Positions) positions;
  ADDRESS(Indices) indices;
  ADDRESS(ClipMatrices) clip_matrices;
  ADDRESS(Instances) instances;
  ADDRESS(Records) records;
  uint chunk_count;
  uint triangle_slots;  // records of clipped pieces start here
  uint piece_capacity;
};

struct ChunkSumPush {
  uint chunk_count;
  uint triangle_slots;
  uint small_bits;  // of a count: which triangles are left to compute
};

struct EmitPush {
  uint chunk_count;
  uint triangle_slots;
  uint hull_capacity;
  uint small_capacity;
  uint small_bits;  // of a count: which triangles are listed
};

struct DrawArgumentsPush {
  uint batch_count;
};

struct ScanPush {
  uint count;  // the total goes behind so many
};

struct FragmentBasesPush {
  uint chunk_count;
  uint triangle_slots;
};

struct PixelBasesPush {
  uint groups;  // of 64 items
  uint count;   // items
};

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

struct ListSmallPush {
  ADDRESS(Records) records;
  ADDRESS(SmallTriangles) small;
  uint count;   // small triangles
  uint width;
  uint height;
};

struct VisibilitySmallPush {
  ADDRESS(SmallWords) small;
  uint count;  // small triangles
  uint width;
  uint height;
};

// Of visibility_unordered.frag: bits of the nearest depth, the first submitted triangle and record that have it.
struct NearestAddresses {
  ADDRESS(NearestWords) depths;
  ADDRESS(NearestWords) slots;
  ADDRESS(NearestWords) records;
};

// Of gather_visibility.frag.
struct NearestPush {
  NearestAddresses nearest;
  uint width;
  uint height;
};

struct ListAddresses {
  ADDRESS(Fragments) fragments;
  ADDRESS(FragmentNumbers) numbers;
  ADDRESS(PixelEnds) ends;
  ADDRESS(FragmentBases) bases;
};

// Of visible_fragments.comp.
struct VisibleFragmentsPush {
  ListAddresses lists;
  uint width;
  uint height;
};

// Of sort_part.comp and merge_parts.comp.
struct ListPartPush {
  ListAddresses lists;
  ADDRESS(FragmentNumbers) merged;
  uint width;
  uint height;
  uint part;
};

// Of collect.comp.
struct CollectPush {
  ListAddresses lists;
  ADDRESS(Records) records;
  uint count;   // small triangles
  uint width;
  uint height;
};

#ifdef __cplusplus
static_assert(sizeof(HullPush) == 96);
static_assert(sizeof(ListAddresses) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
