// What host and the passes of surface-based anti-aliasing agree on.
#ifndef SUBPIXEL_SBAA_INTERFACE_H
#define SUBPIXEL_SBAA_INTERFACE_H

#include "../../frontend/frontend_interface.h"

#define SBAA_CONSTANT_SURFACES 7
#define SBAA_CONSTANT_MERGE 8

// Sampled.
#define SBAA_SLOT_SURFACES 1
#define SBAA_SLOT_GBUFFER 2
#define SBAA_SLOT_DROPPED 3
// Storage image: the G-buffer while it is written.
#define SBAA_SLOT_STORED 0

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

BUFFER_REFERENCE(Faces)

// Of triangles.comp.
struct SbaaTrianglesPush {
  ADDRESS(HullIndices) hulls;
  ADDRESS(Records) records;
  ADDRESS(Positions) positions;
  ADDRESS(Indices) indices;
  ADDRESS(Instances) instances;
  ADDRESS(Faces) faces;
  uint hull_triangles;
  uint row;  // invocations in x
};

struct SbaaAnalysePush {
  ADDRESS(Faces) faces;
  float cosine;  // of the largest angle between normals of one surface
};

// Of a triangle: the packed normal and the bits of its depth slope.
#define SBAA_FACE_BYTES 8

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
