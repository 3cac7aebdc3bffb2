#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// How many fragments have stored in each pixel, as a map.
// Reads: the counts of gbuffer_in_order.frag. Writes: them.
#include "deferred/deferred_interface.h"
#include "include/frame.glsl"

layout(set = 0, binding = STORAGE(DEFERRED_SLOT_WRITTEN), scalar) readonly buffer Written { uint written[]; };
layout(location = 0) out uint out_written;

void main() {
  // Blocks of pixels reach beyond the image's borders.
  uvec2 pixel = min(uvec2(gl_FragCoord.xy), uvec2(band_size()) - 1u);
  out_written = written[pixel.y * uint(frame.viewport.x) + pixel.x];
}
