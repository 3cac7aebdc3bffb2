// A pixel's state as 32-bit words: the count word, then SURFACES surfaces of 7 words (28 bytes, section 4.3), fewer where the
// scene emits nothing or a mask fits one word, more for the wider formats that the paper compares with and for second moments.
// Needs surface.glsl and SAMPLES before it.
#ifndef SUBPIXEL_DCAA_STATE_GLSL
#define SUBPIXEL_DCAA_STATE_GLSL

const uint COVERAGE_WORDS = SAMPLES / 64u + 1u;
const uint FACET_WORDS = NORMAL_FORMAT == DCAA_NORMAL_3X32 ? 3u : 1u;
const uint WIDE_DEPTH_WORDS = DEPTH_BITS == 32u ? 1u : 0u;
const uint EMISSION_WORDS = (FEATURES / FEATURE_EMISSIVE) & 1u;
const uint MOMENT_WORDS = (DCAA_OPTIONS & DCAA_SECOND_MOMENTS) != 0u ? 3u : 0u;
const uint SURFACE_WORDS = COVERAGE_WORDS + FACET_WORDS + 3u + WIDE_DEPTH_WORDS + EMISSION_WORDS + MOMENT_WORDS;
const uint STATE_QUADS = (1u + SURFACES * SURFACE_WORDS + 3u) / 4u;

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
