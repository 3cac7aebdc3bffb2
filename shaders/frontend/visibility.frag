#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16 1A=-DGROUP=1,-DWITH_UV 2A=-DGROUP=2,-DWITH_UV 4A=-DGROUP=4,-DWITH_UV 8A=-DGROUP=8,-DWITH_UV 16A=-DGROUP=16,-DWITH_UV
// Nearest triangle of each sample, as nearest_samples.glsl finds it; variants A of alpha-tested materials.
// Reads and writes: the attachments.
#include "frontend/fragment.glsl"
#include "frontend/nearest_samples.glsl"

void main() {
  if (!take_samples(pixel_of(gl_FragCoord.xy))) discard;
}
