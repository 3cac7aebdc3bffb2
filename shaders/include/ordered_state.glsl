// Where a fragment finds its pixel's state: quad() and set_quad() for its STATE_QUADS quads of words. They lie in
// colour attachments while ATTACHMENTS > 0, so that reads and writes of a pixel's fragments are ordered by
// VK_EXT_rasterization_order_attachment_access. States of more quads than attachments (ATTACHMENTS 0) lie in a buffer;
// their order is that of the device's fragments, proven at start-up. Define ATTACHMENTS and STATE_QUADS before it.
// Reads and writes: the attachments, or the buffer whose address ORDERED_SLOT_ADDRESS holds.
#ifndef SUBPIXEL_ORDERED_STATE_GLSL
#define SUBPIXEL_ORDERED_STATE_GLSL

#include "include/ordered_state.h"

// With INTERLOCK the device orders what stands between begin_ordered() and end_ordered() (VK_EXT_fragment_shader_interlock).
#ifdef INTERLOCK
layout(pixel_interlock_ordered) in;
#define begin_ordered() beginInvocationInterlockARB()
#define end_ordered() endInvocationInterlockARB()
#else
#define begin_ordered()
#define end_ordered()
#endif

#if ATTACHMENTS > 0
#define STATE(i)                                                                                               \
  layout(input_attachment_index = i, set = 0, binding = INPUT_ATTACHMENT(i)) uniform usubpassInput in_state##i; \
  layout(location = i) out uvec4 out_state##i;
STATE(0)
STATE(1)
STATE(2)
#if ATTACHMENTS > 3
STATE(3)
#endif
#if ATTACHMENTS > 4
STATE(4)
#endif
#if ATTACHMENTS > 5
STATE(5)
#endif
#if ATTACHMENTS > 6
STATE(6)
#endif
#if ATTACHMENTS > 7
STATE(7)
#endif

void find_state(ivec2 pixel) {}

// `i` is constant once loops are unrolled.
uvec4 quad(uint i) {
  if (i == 0u) return subpassLoad(in_state0);
  if (i == 1u) return subpassLoad(in_state1);
  if (i == 2u) return subpassLoad(in_state2);
#if ATTACHMENTS > 3
  if (i == 3u) return subpassLoad(in_state3);
#endif
#if ATTACHMENTS > 4
  if (i == 4u) return subpassLoad(in_state4);
#endif
#if ATTACHMENTS > 5
  if (i == 5u) return subpassLoad(in_state5);
#endif
#if ATTACHMENTS > 6
  if (i == 6u) return subpassLoad(in_state6);
#endif
#if ATTACHMENTS > 7
  if (i == 7u) return subpassLoad(in_state7);
#endif
  return uvec4(0u);
}

void set_quad(uint i, uvec4 value) {
  if (i == 0u) out_state0 = value;
  if (i == 1u) out_state1 = value;
  if (i == 2u) out_state2 = value;
#if ATTACHMENTS > 3
  if (i == 3u) out_state3 = value;
#endif
#if ATTACHMENTS > 4
  if (i == 4u) out_state4 = value;
#endif
#if ATTACHMENTS > 5
  if (i == 5u) out_state5 = value;
#endif
#if ATTACHMENTS > 6
  if (i == 6u) out_state6 = value;
#endif
#if ATTACHMENTS > 7
  if (i == 7u) out_state7 = value;
#endif
}

#else
#ifdef INTERLOCK
#define STATE_ACCESS coherent
#else
#define STATE_ACCESS
#endif
layout(buffer_reference, scalar, buffer_reference_align = 16) STATE_ACCESS buffer StateQuads { uvec4 quads[]; };
layout(set = 0, binding = STORAGE(ORDERED_SLOT_ADDRESS), scalar) readonly buffer StateAddress { StateQuads state; };

uint first_quad;
void find_state(ivec2 pixel) { first_quad = (uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)) * STATE_QUADS; }
uvec4 quad(uint i) { return state.quads[first_quad + i]; }
void set_quad(uint i, uvec4 value) { state.quads[first_quad + i] = value; }
#endif

#endif
