// Which samples of a pixel belong together, and which of these surfaces are kept. Salvi and Vidimce 2012, "Surface based
// anti-aliasing", as the papers that compare themselves with it describe it.
// The including shader defines SAMPLES (4 to 32) and the functions declared here, which tell about one pixel.
// Reads and writes: nothing else.
#ifndef SUBPIXEL_SBAA_ANALYSIS_GLSL
#define SUBPIXEL_SBAA_ANALYSIS_GLSL

const uint kMostSurfaces = 8u;

// Of one covered sample: the unit normal of its triangle, its depth, and |dz/dx| + |dz/dy| of the triangle.
struct AnalysedSample {
  vec3 normal;
  float depth, slope;
};
AnalysedSample analysed_sample(uint s);

// Of unit vectors. In this order, each product and sum rounded: the decision is the same wherever it is computed.
float face_cosine(vec3 a, vec3 b) {
  precise float c = a.x * b.x;
  c = c + a.y * b.y;
  c = c + a.z * b.z;
  return c;
}

#include "techniques/sbaa/story.glsl"

// Primitive numbers are stored in 8 bits, of which neighbours in the stream share few: Knuth's multiplicative hash.
uint primitive_hash(uint primitive) { return (primitive * 2654435769u) >> 24; }

// The bytes of x that are 0, in bits 0 to 3.
uint zero_bytes(uint x) {
  uint zero = ~(((x & 0x7f7f7f7fu) + 0x7f7f7f7fu) | x) & 0x80808080u;
  return ((zero >> 7) * 0x01020408u) >> 24 & 15u;
}

struct KeptSurfaces {
  uint mask[kMostSurfaces];  // samples, most first; 0 behind the last
};

// `hashes`: four samples in a word, the lowest byte first. `covered`: samples that show anything.
// Samples of one hash are one surface. With `merge`, in the order of their first samples, a surface goes into the earliest one
// whose first triangle's normal has a cosine above `cosine` with its own and whose depth interval overlaps its own; the
// interval of a sample is what its triangle's plane reaches within a pixel of it, that of merged surfaces spans theirs.
// The `keep` surfaces with most samples are kept, of equal ones those whose first sample comes first.
KeptSurfaces analyse_pixel(uint hashes[8], uint covered, bool merge, float cosine, uint keep) {
  uint mask[SAMPLES];
  vec3 normal[SAMPLES];
  float low[SAMPLES], high[SAMPLES];
  for (uint j = 0u; j < SAMPLES; ++j) mask[j] = 0u;
  uint count = 0u;
  for (uint left = covered; left != 0u;) {
    uint first = uint(findLSB(left));
    uint word = 0u;
    for (uint i = 0u; i < SAMPLES / 4u; ++i) word = first / 4u == i ? hashes[i] : word;
    uint pattern = (word >> 8u * (first & 3u) & 255u) * 0x01010101u;
    uint same = 0u;
    for (uint i = 0u; i < SAMPLES / 4u; ++i) same |= zero_bytes(hashes[i] ^ pattern) << 4u * i;
    same &= covered;
    left &= ~same;

    uint into = count;
    if (merge) {
      AnalysedSample s = analysed_sample(first);
      float nearest = s.depth + s.slope, farthest = s.depth - s.slope;
      for (uint j = 0u; j < SAMPLES; ++j) {
        float c = face_cosine(normal[j], s.normal);
        bool fits = j < count && c > cosine && farthest <= high[j] && low[j] <= nearest;
        into = fits && into == count ? j : into;
      }
      TELL_GROUP(first, same, into, count, true, normal, low, high);
      for (uint j = 0u; j < SAMPLES; ++j) {
        bool here = j == into, fresh = into == count;
        normal[j] = here && fresh ? s.normal : normal[j];
        low[j] = here ? (fresh ? farthest : min(low[j], farthest)) : low[j];
        high[j] = here ? (fresh ? nearest : max(high[j], nearest)) : high[j];
      }
    } else {
      TELL_GROUP(first, same, into, count, false, normal, low, high);
    }
    for (uint j = 0u; j < SAMPLES; ++j) mask[j] |= j == into ? same : 0u;
    count += into == count ? 1u : 0u;
  }

  KeptSurfaces kept;
  for (uint k = 0u; k < kMostSurfaces; ++k) kept.mask[k] = 0u;
  for (uint k = 0u; k < keep; ++k) {
    uint best = 0u;
    for (uint j = 0u; j < SAMPLES; ++j) best = bitCount(mask[j]) > bitCount(best) ? mask[j] : best;
    for (uint j = 0u; j < SAMPLES; ++j) mask[j] = mask[j] == best ? 0u : mask[j];
    kept.mask[k] = best;
  }
  return kept;
}

#endif
