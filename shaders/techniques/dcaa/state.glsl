// A pixel's state as 32-bit words: the count word, then SURFACES surfaces.
// Needs surface.glsl and SAMPLES before it.
#ifndef SUBPIXEL_DCAA_STATE_GLSL
#define SUBPIXEL_DCAA_STATE_GLSL

const uint COVERAGE_WORDS = DCAA_COVERAGE_WORDS(SAMPLES);
const uint FACET_WORDS = DCAA_FACET_WORDS(NORMAL_FORMAT);
const uint WIDE_DEPTH_WORDS = DCAA_WIDE_DEPTH_WORDS(DEPTH_BITS);
const uint EMISSION_WORDS = BIT_OF(FEATURES, FEATURE_EMISSIVE);
const uint MOMENT_WORDS = DCAA_MOMENT_WORDS(DCAA_OPTIONS);
const uint SURFACE_WORDS = DCAA_SURFACE_WORDS(SAMPLES, FEATURES, DCAA_OPTIONS, NORMAL_FORMAT, DEPTH_BITS);
const uint STATE_QUADS = DCAA_STATE_QUADS(SURFACES, SURFACE_WORDS);

#define MAX_STATE_WORDS 108
struct DcaaState {
  uint word[MAX_STATE_WORDS];
};

DcaaSurface dcaa_unpack(DcaaState state, uint i) {
  uint at = 1u + i * SURFACE_WORDS;
  DcaaSurface s;
  s.coverage = uvec2(state.word[at], COVERAGE_WORDS > 1u ? state.word[at + 1u] : 0u);
  at += COVERAGE_WORDS;
  s.facet = uvec3(state.word[at], 0u, 0u);
  if (FACET_WORDS == 3u) s.facet.yz = uvec2(state.word[at + 1u], state.word[at + 2u]);
  at += FACET_WORDS;
  s.albedo = state.word[at];
  s.normal = state.word[at + 1u];
  s.roughness = state.word[at + 2u] & 255u;
  s.depth = dcaa_unpack_depth(WIDE_DEPTH_WORDS != 0u ? state.word[at + 3u] : state.word[at + 2u] >> 8);
  at += 3u + WIDE_DEPTH_WORDS;
  s.emission = 0u;
  if (EMISSION_WORDS != 0u) s.emission = state.word[at];
  at += EMISSION_WORDS;
  s.moments = uvec3(0u);
  if (MOMENT_WORDS != 0u) s.moments = uvec3(state.word[at], state.word[at + 1u], state.word[at + 2u]);
  return s;
}

void dcaa_pack(DcaaSurface s, uint i, inout DcaaState state) {
  uint at = 1u + i * SURFACE_WORDS;
  state.word[at] = s.coverage.x;
  if (COVERAGE_WORDS > 1u) state.word[at + 1u] = s.coverage.y;
  at += COVERAGE_WORDS;
  state.word[at] = s.facet.x;
  if (FACET_WORDS == 3u) {
    state.word[at + 1u] = s.facet.y;
    state.word[at + 2u] = s.facet.z;
  }
  at += FACET_WORDS;
  state.word[at] = s.albedo;
  state.word[at + 1u] = s.normal;
  state.word[at + 2u] = s.roughness | (WIDE_DEPTH_WORDS != 0u ? 0u : dcaa_pack_depth(s.depth) << 8);
  if (WIDE_DEPTH_WORDS != 0u) state.word[at + 3u] = dcaa_pack_depth(s.depth);
  at += 3u + WIDE_DEPTH_WORDS;
  if (EMISSION_WORDS != 0u) state.word[at] = s.emission;
  at += EMISSION_WORDS;
  if (MOMENT_WORDS != 0u) {
    state.word[at] = s.moments.x;
    state.word[at + 1u] = s.moments.y;
    state.word[at + 2u] = s.moments.z;
  }
}

#endif
