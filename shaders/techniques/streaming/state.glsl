// A pixel's compressed state as 32-bit words: n sample depths, the count word, SURFACES surfaces.
// Needs compress.glsl and SAMPLES before it.
#ifndef SUBPIXEL_STREAMING_STATE_GLSL
#define SUBPIXEL_STREAMING_STATE_GLSL

const uint DEPTH_QUADS = SAMPLES / 4u;
const uint ROUGHNESS_WORDS = STREAM_ROUGHNESS_WORDS(SAMPLES, FEATURES);
const uint EMISSION_WORDS = BIT_OF(FEATURES, FEATURE_EMISSIVE);
const uint RESOLVED_WORDS = SAMPLES / 32u;
const uint SURFACE_WORDS = STREAM_SURFACE_WORDS(SAMPLES, FEATURES);
const uint LISTED_STATE_QUADS = STREAM_STATE_QUADS(SAMPLES, FEATURES, SURFACES);
const uint LIST_QUADS = LISTED_STATE_QUADS - DEPTH_QUADS;

#define MAX_LIST_WORDS 36  // 4 surfaces of 8 words
struct StreamList {
  uint word[MAX_LIST_WORDS];  // the count word, then the surfaces
};

void stream_unpack(StreamList list, out uint word, out StreamSurface surface[STREAM_MAX_SURFACES]) {
  word = list.word[0];
  for (uint i = 0u; i < SURFACES; ++i) {
    uint base = 1u + i * SURFACE_WORDS, masks = list.word[base + 2u];
    surface[i].depth = uintBitsToFloat(list.word[base]);
    surface[i].slopes = list.word[base + 1u];
    surface[i].albedo = list.word[base + 3u];
    surface[i].normal = list.word[base + 4u];
    surface[i].roughness = 0u;
    if (SAMPLES <= 8u) {
      surface[i].coverage = masks & 255u;
      surface[i].resolved = (masks >> 8) & 255u;
      surface[i].roughness = masks >> 16;
    } else if (SAMPLES == 16u) {
      surface[i].coverage = masks & 0xffffu;
      surface[i].resolved = masks >> 16;
    } else {
      surface[i].coverage = masks;
      surface[i].resolved = list.word[base + 5u];
    }
    if (ROUGHNESS_WORDS != 0u) surface[i].roughness = list.word[base + 5u + RESOLVED_WORDS];
    surface[i].emission = 0u;
    if (EMISSION_WORDS != 0u) surface[i].emission = list.word[base + 5u + RESOLVED_WORDS + ROUGHNESS_WORDS];
  }
}

void stream_pack(uint word, StreamSurface surface[STREAM_MAX_SURFACES], out StreamList list) {
  for (uint i = 0u; i < MAX_LIST_WORDS; ++i) list.word[i] = 0u;
  list.word[0] = word;
  for (uint i = 0u; i < SURFACES; ++i) {
    uint base = 1u + i * SURFACE_WORDS;
    list.word[base] = floatBitsToUint(surface[i].depth);
    list.word[base + 1u] = surface[i].slopes;
    list.word[base + 3u] = surface[i].albedo;
    list.word[base + 4u] = surface[i].normal;
    if (SAMPLES <= 8u) {
      list.word[base + 2u] = surface[i].coverage | surface[i].resolved << 8 | surface[i].roughness << 16;
    } else if (SAMPLES == 16u) {
      list.word[base + 2u] = surface[i].coverage | surface[i].resolved << 16;
    } else {
      list.word[base + 2u] = surface[i].coverage;
      list.word[base + 5u] = surface[i].resolved;
    }
    if (ROUGHNESS_WORDS != 0u) list.word[base + 5u + RESOLVED_WORDS] = surface[i].roughness;
    if (EMISSION_WORDS != 0u) list.word[base + 5u + RESOLVED_WORDS + ROUGHNESS_WORDS] = surface[i].emission;
  }
}

#endif
