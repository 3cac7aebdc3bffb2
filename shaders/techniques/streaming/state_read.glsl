// The list part of a pixel's state, read back after the compression pass.
// Reads: with IMAGE the array of attachments, else the buffer whose address ORDERED_SLOT_ADDRESS holds.
#ifndef SUBPIXEL_STREAMING_STATE_READ_GLSL
#define SUBPIXEL_STREAMING_STATE_READ_GLSL

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

uint read_count_word(ivec2 pixel) { return state_quad(pixel, DEPTH_QUADS).x; }

void read_surfaces(ivec2 pixel, out StreamSurface surface[STREAM_MAX_SURFACES]) {
  StreamList list;
  for (uint i = 0u; i < STATE_QUADS - DEPTH_QUADS; ++i) {
    uvec4 words = state_quad(pixel, DEPTH_QUADS + i);
    for (uint c = 0u; c < 4u; ++c) list.word[4u * i + c] = words[c];
  }
  uint word;
  stream_unpack(list, word, surface);
}

#endif
