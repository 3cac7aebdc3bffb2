#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16
// A G-buffer of full samples without a depth pass before it: a fragment that is nearest so far in some sample evaluates its
// surface and stores it there, over what was there before.
// Reads and writes: depths and triangles of the samples in the attachments, in primitive order; how many fragments have stored in
// the pixel. Writes: a layer for each sample, as in stored_sample.glsl. The order of fragments in images and buffers is the device's,
// which the start-up litmus proves for ordered_state.glsl.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "deferred/deferred_interface.h"
#include "deferred/stored_sample.glsl"

layout(set = 0, binding = STORAGE_IMAGE(DEFERRED_SLOT_SAMPLES), rgba32ui) writeonly uniform uimage2DArray out_samples;
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_WRITTEN), scalar) buffer Written { uint written[]; };

void store_taken(ivec2 pixel, PixelEdges edges, uint bits);
#define SAMPLES_TAKEN store_taken
#include "frontend/nearest_samples.glsl"

void store_taken(ivec2 pixel, PixelEdges edges, uint bits) {
  // lavapipe runs whole blocks of 4x4 pixels, beyond the image's borders too: stores to images are dropped there, to buffers not.
  bool inside = all(lessThan(pixel, band_size()));
  for (bool store = inside; store; store = false) {
    uvec4 stored = stored_sample(fragment_surface(pixel, shading_offset(edges, SAMPLES)));
    for (uint left = bits; left != 0u; left &= left - 1u)
      imageStore(out_samples, ivec3(pixel, SAMPLE_GROUP * GROUP + uint(findLSB(left))), stored);
    written[uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)] += 1u;
  }
}

void main() {
  if (!take_samples(pixel_of(gl_FragCoord.xy))) discard;
}
