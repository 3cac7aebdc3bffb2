#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: BUFFER= TILED_IMAGE=-DTILED,-DIMAGE TILED_BUFFER=-DTILED
// What the compression pass did to each pixel.
// Reads: the pixel's state. Writes: merges, samples discarded while visible, surfaces stored, neighbours in the front-to-back
// order that stand the wrong way round; with TILED also words of surfaces loaded and stored.
#include "techniques/streaming/streaming_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "techniques/streaming/state_read.glsl"

layout(location = 0) out uint out_merges;
layout(location = 1) out uint out_discards;
layout(location = 2) out uint out_surfaces;
layout(location = 3) out uint out_order_errors;
#ifdef TILED
layout(location = 4) out uint out_loaded;
layout(location = 5) out uint out_stored;
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint word = read_count_word(pixel);
  uint count = field_of(word, 0u, STREAM_COUNT_BITS), order = field_of(word, STREAM_ORDER_SHIFT, STREAM_ORDER_BITS);
  StreamSurface surface[STREAM_MAX_SURFACES];
  read_surfaces(pixel, surface);
  uint errors = 0u;
  float before = 0.0;
  for (uint place = 0u; place < SURFACES; ++place) {
    float depth = surface[0].depth;
    for (uint i = 1u; i < SURFACES; ++i) depth = stream_slot(order, place) == i ? surface[i].depth : depth;
    errors += place > 0u && place < count && depth < before ? 1u : 0u;
    before = depth;
  }
  out_merges = field_of(word, STREAM_MERGES_SHIFT, STREAM_MERGES_BITS);
  out_discards = field_of(word, STREAM_DROPPED_SHIFT, STREAM_DROPPED_BITS);
  out_surfaces = count;
  out_order_errors = errors;
#ifdef TILED
  uvec4 head = state_quad(pixel, DEPTH_QUADS);
  out_loaded = head.y;
  out_stored = head.z;
#endif
}
