// Where the passes over fragments find geometry and records: by address.
// Reads: push constants.
#ifndef SUBPIXEL_HULL_INTERFACE_GLSL
#define SUBPIXEL_HULL_INTERFACE_GLSL

#include "include/frame.glsl"
#include "frontend/buffers.glsl"

layout(push_constant, scalar) uniform Push { HullPush push; };

const uint kUvFeatures = FEATURE_BASE_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_ROUGHNESS_TEXTURE | FEATURE_EMISSIVE_TEXTURE;
// What fragments fetch from the source triangle's vertices themselves, so that hulls have no more outputs for it.
const uint kFetchedFeatures = FEATURE_SECOND_UV | FEATURE_VERTEX_COLOUR;

#endif
