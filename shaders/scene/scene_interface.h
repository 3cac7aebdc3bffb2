// The scene's buffers that passes reach by address, and the push constants of the shadow map's.
#ifndef SUBPIXEL_SCENE_INTERFACE_H
#define SUBPIXEL_SCENE_INTERFACE_H

#include "../include/interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Members are in scene/buffers.glsl.
BUFFER_REFERENCE(Positions)
BUFFER_REFERENCE(Normals)
BUFFER_REFERENCE(Uvs)
BUFFER_REFERENCE(Tangents)
BUFFER_REFERENCE(Colours)
BUFFER_REFERENCE(Indices)
BUFFER_REFERENCE(Instances)

struct ShadowPush {
  mat4 world_to_clip;
  ADDRESS(Positions) positions;
  ADDRESS(Uvs) uvs;  // those that the material's base colour is read by
  ADDRESS(Instances) instances;
  ADDRESS(Colours) colours;
  uint material;
};

#ifdef __cplusplus
static_assert(sizeof(ShadowPush) == 104);
}  // namespace subpixel::gpu_types
#endif
#endif
