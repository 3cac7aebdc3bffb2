// variants: SOLID= TESTED=-DTESTED=1
// Computes: the triangle seen by each sample. TESTED decides by alpha at the place of each of the four samples.
// Reads: the triangle's number; with TESTED its material.
// Writes: the number plus 1; with TESTED the mask of the samples that are there.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "reference/triangles.glsl"
#ifdef TESTED
#include "reference/textures.glsl"
#endif

layout(location = 0) flat in uint triangle;
layout(location = 0) out uint seen;

#ifdef TESTED
// Laine and Karras 2011: each bit is flipped or not by a hash of the bits below it.
uint scramble(uint x, uint seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return x;
}

// Blended materials cover each sample with the probability alpha. The thresholds of one triangle are spread evenly over
// the samples of all turns; those of different triangles are independent, so that layers multiply: the radical inverse
// of a shuffled index, both by hashed Owen scrambling (Burley 2020).
float blend_threshold(uint number, uint sample_number) {
  uint hash = number * 747796405u + 2891336453u;
  hash = ((hash >> ((hash >> 28u) + 4u)) ^ hash) * 277803737u;
  hash = (hash >> 22u) ^ hash;
  uint index = 4u * turn.number.x + sample_number;
  uint shuffled = bitfieldReverse(scramble(bitfieldReverse(index), hash));
  uint spread = bitfieldReverse(scramble(shuffled, hash ^ 0xa511e9b3u));
  return (float(spread >> 8) + 0.5) * (1.0 / 16777216.0);
}
#endif

void main() {
  seen = triangle;
#ifdef TESTED
  ReferenceTriangle t = triangles.at[triangle - 1u];
  MaterialRecord m = materials[t.source.z];
  uint base_texture = material_textures[t.source.z].x;
  uvec3 vertices = vertices_of(t);
  bool blend = (m.flags.x & MATERIAL_ALPHA_BLEND) != 0u;
  int mask = 0;
  vec2 texel = floor(gl_FragCoord.xy);
  for (uint s = 0u; s < 4u; ++s) {
    vec2 offset = s < 2u ? (s == 0u ? turn.offset01.xy : turn.offset01.zw)
                         : (s == 2u ? turn.offset23.xy : turn.offset23.zw);
    vec2 pixel = texel - vec2(turn.texel.x >> (2u * s) & 1u, turn.texel.x >> (2u * s + 1u) & 1u);
    float alpha = m.base_colour.a;
    if (has_feature(FEATURE_BASE_TEXTURE))
      alpha *= texture_at(base_texture, coordinates_of(vertices, weights_at(triangle - 1u, pixel + offset))).a;
    float threshold = blend ? blend_threshold(triangle, s) : m.emissive_cutoff.w;
    mask |= alpha >= threshold ? 1 << s : 0;
  }
  gl_SampleMask[0] = mask;
#endif
}
