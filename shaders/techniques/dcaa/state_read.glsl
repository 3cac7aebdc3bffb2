// A pixel's state, read back after the merge pass.
// Reads: with IMAGE the array of attachments, else the buffer whose address ORDERED_SLOT_ADDRESS holds.
#ifndef SUBPIXEL_DCAA_STATE_READ_GLSL
#define SUBPIXEL_DCAA_STATE_READ_GLSL

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

uint read_count_word(ivec2 pixel) { return state_quad(pixel, 0u).x; }

void read_surfaces(ivec2 pixel, out DcaaSurface surface[DCAA_MAX_SURFACES]) {
  DcaaState state;
  for (uint i = 0u; i < STATE_QUADS; ++i) {
    uvec4 words = state_quad(pixel, i);
    for (uint c = 0u; c < 4u; ++c) state.word[4u * i + c] = words[c];
  }
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);
}

#endif
