// A pixel's state, read back by full-screen passes.
// Reads: with IMAGE the array of attachments, else the buffer whose address ORDERED_SLOT_ADDRESS holds. Define
// STATE_QUADS before it.
#ifndef SUBPIXEL_ORDERED_STATE_READ_GLSL
#define SUBPIXEL_ORDERED_STATE_READ_GLSL

#include "include/frame.glsl"
#include "include/ordered_state.h"

#ifdef IMAGE
layout(set = 0, binding = SAMPLED(ORDERED_SLOT_ATTACHMENTS)) uniform usampler2DArray state_image;
uvec4 state_quad(ivec2 pixel, uint i) { return texelFetch(state_image, ivec3(pixel, i), 0); }
#else
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer StateQuads { uvec4 quads[]; };
layout(set = 0, binding = STORAGE(ORDERED_SLOT_ADDRESS), scalar) readonly buffer StateAddress { StateQuads state; };
uvec4 state_quad(ivec2 pixel, uint i) {
  return state.quads[(uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)) * STATE_QUADS + i];
}
#endif

#endif
