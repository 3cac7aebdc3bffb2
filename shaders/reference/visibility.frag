// variants: SOLID= TESTED=-DTESTED=1
// Computes: the triangle seen by each sample. TESTED decides by alpha whether it is there.
// Reads: the triangle's number; with TESTED its material.
// Writes: the number plus 1.
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
  uint index = SAMPLES_OF_TURN * turn.number.x + sample_number;
  uint shuffled = bitfieldReverse(scramble(bitfieldReverse(index), hash));
  uint spread = bitfieldReverse(scramble(shuffled, hash ^ 0xa511e9b3u));
  return (float(spread >> 8) + 0.5) * (1.0 / 16777216.0);
}
#endif

void main() {
  seen = triangle;
#ifdef TESTED
  ReferenceTriangle t = push.triangles.at[triangle - 1u];
  MaterialRecord m = materials[t.source.z];
  uvec2 texel = uvec2(gl_FragCoord.xy);
  uint s = sample_of(texel % SIDE);
  vec2 point = vec2(texel / SIDE) + sample_place(s);
  float alpha = m.base_colour.a;
  if (has_feature(FEATURE_BASE_TEXTURE)) {
    Coordinates c = coordinates_of(vertices_of(t), weights_at(triangle - 1u, point), t.source.z, 0u);
    alpha *= texture_at(material_textures[t.source.z].x, c).a;
  }
  if (has_feature(FEATURE_VERTEX_COLOUR)) alpha *= colour_of(vertices_of(t), weights_at(triangle - 1u, point)).a;
  bool blend = (m.flags.x & MATERIAL_ALPHA_BLEND) != 0u;
  if (alpha < (blend ? blend_threshold(triangle, s) : m.emissive_cutoff.w)) discard;
#endif
}
