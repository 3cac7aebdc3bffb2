// Streaming compression of one pixel: what one more fragment does to its surfaces.
// Kerzner and Salvi, "Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing", High-Performance Graphics 2014:
// sections 3.1 (merge metric), 3.2 (compression) and 3.2.1 (coverage determination).
// Reads and writes: its arguments alone, so that a test can feed it a stream of its own.
//
// Where the paper leaves a choice: of several surfaces that a fragment could merge with, the nearest takes it; of equal
// depths, the earlier is in front; the fused occluder reaches from the nearest to the farthest depth of its parts; of
// what shows equally little, the farthest is discarded. As the authors' public code has it (Merge.hlsl and DepthTests.hlsl
// of kerzner/streaming-g-buffer-compression): a merged surface keeps the nearer depth, and the surface that shows least
// is the one with the fewest depth-resolved samples that nothing nearer covers, whether or not depth intervals overlap;
// overlap decides only what is stored. STREAM_DISCARD_RESOLVED counts the stored masks instead.
#ifndef SUBPIXEL_STREAMING_COMPRESS_GLSL
#define SUBPIXEL_STREAMING_COMPRESS_GLSL

#include "include/blending.glsl"
#include "include/coverage.glsl"
#include "include/ordered_state_words.glsl"
#include "techniques/streaming/streaming_interface.h"

layout(constant_id = STREAM_CONSTANT_SURFACES) const uint SURFACES = 3u;
layout(constant_id = STREAM_CONSTANT_COS_NORMAL_ANGLE) const float COS_NORMAL_ANGLE = 0.70710678;
layout(constant_id = STREAM_CONSTANT_OPTIONS) const uint STREAM_OPTIONS =
    STREAM_MERGE_NORMALS | STREAM_MERGE_DEPTH | STREAM_MERGE_COVERAGE;

bool stream_option(uint option) { return (STREAM_OPTIONS & option) != 0u; }

struct StreamSurface {
  float depth;      // at the pixel's centre, growing away from the eye
  uint slopes;      // of the depth, half2, per pixel in x and y
  uint coverage;    // samples
  uint resolved;    // of them, those no occluder is known to hide: the depth-resolved coverage
  uint albedo;      // this word and the next as in packing.glsl
  uint normal;
  uint roughness;   // 8 bits
  uint emission;    // shared exponent
};

// Slopes as half2, rounded to nearest even here: packHalf2x16() may round either way, and compilers take its rounding for
// superfluous where an unpackHalf2x16() follows. 11 bits remain by Dekker's splitting (1971); below 2^-14, where halves are
// multiples of 2^-24, by adding what has that unit in the last place.
uint stream_pack_slopes(vec2 slope) {
  vec2 v = clamp(slope, -65504.0, 65504.0);
  precise vec2 shifted = v * 8193.0;
  precise vec2 excess = shifted - v;
  precise vec2 rounded = shifted - excess;
  precise vec2 raised = v + 0.75;
  precise vec2 small = raised - 0.75;
  return packHalf2x16(mix(rounded, small, lessThan(abs(v), vec2(0.00006103515625))));
}

// The depths that the surface may have in the pixel, nearest and farthest (section 3.1).
vec2 stream_interval(float depth, uint slopes) {
  vec2 slope = abs(unpackHalf2x16(slopes));
  precise float reach = slope.x + slope.y;
  precise vec2 interval = vec2(depth - reach, depth + reach);
  return interval;
}

// unpack_normal() with every operation's order given, so that the alignment of two normals is the same bit everywhere.
vec3 stream_normal(uint packed) {
  vec2 p = unpackSnorm2x16(packed);
  precise float z = 1.0 - abs(p.x) - abs(p.y);
  float t = max(-z, 0.0);
  precise vec2 xy = p + vec2(p.x >= 0.0 ? -t : t, p.y >= 0.0 ? -t : t);
  precise float squared = xy.x * xy.x + xy.y * xy.y + z * z;
  precise vec3 normal = vec3(xy, z) / sqrt(max(squared, 1e-20));
  return normal;
}

StreamSurface stream_merged(StreamSurface a, StreamSurface b) {
  BlendWeights weights = BlendWeights(0.5, 0.5);
  if (stream_option(STREAM_WEIGHT_COVERAGE)) weights = weights_by_samples(bitCount(a.coverage), bitCount(b.coverage));
  StreamSurface merged;
  merged.depth = min(a.depth, b.depth);
  merged.slopes = stream_pack_slopes(blend(unpackHalf2x16(a.slopes), unpackHalf2x16(b.slopes), weights));
  merged.coverage = a.coverage | b.coverage;
  merged.resolved = a.resolved | b.resolved;
  merged.albedo = blend_albedo(a.albedo, b.albedo, weights);
  merged.normal = pack_normal(blend(stream_normal(a.normal), stream_normal(b.normal), weights));
  merged.roughness = blend_byte(a.roughness, b.roughness, 0u, weights);
  merged.emission = blend_emission(a.emission, b.emission, weights);
  return merged;
}

// Slot number at each place of the order, two bits a place, nearest first.
uint stream_slot(uint order, uint place) { return (order >> (2u * place)) & 3u; }
uint stream_removed(uint order, uint place) {
  uint low = (1u << (2u * place)) - 1u;
  return (order & low) | ((order >> 2u) & ~low);
}
uint stream_inserted(uint order, uint place, uint slot) {
  uint low = (1u << (2u * place)) - 1u;
  return (order & low) | slot << (2u * place) | (order & ~low) << 2u;
}

StreamSurface stream_select(bool condition, StreamSurface yes, StreamSurface no) {
  StreamSurface s;
  s.depth = condition ? yes.depth : no.depth;
  s.slopes = condition ? yes.slopes : no.slopes;
  s.coverage = condition ? yes.coverage : no.coverage;
  s.resolved = condition ? yes.resolved : no.resolved;
  s.albedo = condition ? yes.albedo : no.albedo;
  s.normal = condition ? yes.normal : no.normal;
  s.roughness = condition ? yes.roughness : no.roughness;
  s.emission = condition ? yes.emission : no.emission;
  return s;
}

// Slots of surfaces that the fragment may merge with (section 3.1), bit i for slot i.
uint stream_matches(StreamSurface surface[STREAM_MAX_SURFACES], uint count, StreamSurface fragment) {
  uint candidates = 0u;
  for (uint i = 0u; i < SURFACES; ++i) {
    bool exclusive = !stream_option(STREAM_MERGE_COVERAGE) || (surface[i].coverage & fragment.coverage) == 0u;
    candidates |= i < count && exclusive ? 1u << i : 0u;
  }
  uint matches = 0u;
  for (bool any_candidate = candidates != 0u; any_candidate; any_candidate = false) {
    vec2 interval = stream_interval(fragment.depth, fragment.slopes);
    vec3 normal = stream_normal(fragment.normal);
    matches = candidates;
    for (uint i = 0u; i < SURFACES; ++i) {
      vec2 other_interval = stream_interval(surface[i].depth, surface[i].slopes);
      vec3 other = stream_normal(surface[i].normal);
      precise float cosine = normal.x * other.x + normal.y * other.y + normal.z * other.z;
      bool aligned = !stream_option(STREAM_MERGE_NORMALS) || cosine > COS_NORMAL_ANGLE;
      bool overlap = !stream_option(STREAM_MERGE_DEPTH) ||
                     (other_interval.x <= interval.y && interval.x <= other_interval.y);
      matches &= aligned && overlap ? ~0u : ~(1u << i);
    }
  }
  return matches;
}

// How many of the listed surfaces are not behind `depth`: the place of a newcomer.
uint stream_place(StreamSurface surface[STREAM_MAX_SURFACES], uint listed, float depth) {
  uint place = 0u;
  for (uint i = 0u; i < SURFACES; ++i) place += (listed & (1u << i)) != 0u && surface[i].depth <= depth ? 1u : 0u;
  return place;
}

// Section 3.2.1, with the array full: fuses the surfaces and the fragment from front to back, takes hidden samples off their
// depth-resolved coverages, and returns the slot of the one to discard, SURFACES for the fragment. `left`: how many samples
// it shows.
uint stream_fuse(inout StreamSurface surface[STREAM_MAX_SURFACES], uint order, inout StreamSurface fragment, out uint left) {
  uint place = stream_place(surface, (1u << SURFACES) - 1u, fragment.depth);
  vec2 own_interval = stream_interval(fragment.depth, fragment.slopes);
  uint fused = 0u, discarded = 0u;
  float farthest = 0.0;
  left = 0xffffffffu;
  for (uint k = 0u; k <= SURFACES; ++k) {
    uint slot = stream_slot(order, k - (k > place ? 1u : 0u));
    bool own = k == place;
    vec2 interval = own_interval;
    uint coverage = fragment.coverage, resolved = fragment.resolved;
    for (uint i = 0u; i < SURFACES; ++i) {
      bool here = !own && slot == i;
      interval = here ? stream_interval(surface[i].depth, surface[i].slopes) : interval;
      coverage = here ? surface[i].coverage : coverage;
      resolved = here ? surface[i].resolved : resolved;
    }
    uint shown = resolved & ~fused;
    // Depths rise with k, so intervals that don't overlap lie one behind the other. Nothing is fused before the first.
    resolved &= interval.x > farthest ? ~fused : ~0u;
    farthest = k == 0u ? interval.y : max(farthest, interval.y);
    fused |= coverage;
    for (uint i = 0u; i < SURFACES; ++i) surface[i].resolved = !own && slot == i ? resolved : surface[i].resolved;
    fragment.resolved = own ? resolved : fragment.resolved;
    uint samples = bitCount(stream_option(STREAM_DISCARD_RESOLVED) ? resolved : shown);
    discarded = samples <= left ? (own ? SURFACES : slot) : discarded;
    left = min(left, samples);
  }
  return discarded;
}

// Adds a fragment to the pixel. `fragment.resolved` is its coverage; with STREAM_DEPTH_TESTED, those of its samples that
// passed the depth test, which nothing stored so far can show any more.
void stream_add(inout uint word, inout StreamSurface surface[STREAM_MAX_SURFACES], StreamSurface fragment) {
  uint count = field_of(word, 0u, STREAM_COUNT_BITS), order = field_of(word, STREAM_ORDER_SHIFT, STREAM_ORDER_BITS);
  uint hidden = stream_option(STREAM_DEPTH_TESTED) ? fragment.resolved : 0u;
  for (uint i = 0u; i < SURFACES; ++i) surface[i].resolved &= ~hidden;
  uint matches = stream_matches(surface, count, fragment);
  bool merges = matches != 0u;
  uint target = count, leaving = STREAM_MAX_SURFACES;  // slot to write; slot whose surface leaves the order first
  uint listed = (1u << count) - 1u;
  bool stored = true;

  for (bool go = merges; go; go = false) {
    bool found = false;
    for (uint place = 0u; place < SURFACES; ++place) {
      uint slot = stream_slot(order, place);
      bool here = !found && place < count && (matches & (1u << slot)) != 0u;
      target = here ? slot : target;
      found = found || here;
    }
    leaving = target;
    StreamSurface old = surface[0];
    for (uint i = 1u; i < SURFACES; ++i) old = stream_select(target == i, surface[i], old);
    fragment = stream_merged(old, fragment);
    word = count_more(word, STREAM_MERGES_SHIFT, STREAM_MERGES_BITS, 1u);
  }
  for (bool go = !merges && count == SURFACES; go; go = false) {
    uint left;
    uint discarded = stream_fuse(surface, order, fragment, left);
    stored = discarded != SURFACES;
    target = leaving = discarded;
    word |= left != 0u ? 1u << STREAM_DISCARD_SHIFT : 0u;
    word = count_more(word, STREAM_DROPPED_SHIFT, STREAM_DROPPED_BITS, left);
  }

  for (uint i = 0u; i < SURFACES; ++i) {
    // Places are searched from the back, since removal shifts those behind.
    uint place = SURFACES - 1u - i;
    bool leaves = stored && place < count && stream_slot(order, place) == leaving;
    order = leaves ? stream_removed(order, place) : order;
  }
  listed &= leaving < STREAM_MAX_SURFACES ? ~(1u << leaving) : ~0u;
  uint place = stream_place(surface, listed, fragment.depth);
  order = stored ? stream_inserted(order, place, target) : order;
  count = stored && target == count ? count + 1u : count;
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = stream_select(stored && target == i, fragment, surface[i]);

  uint list_mask = (1u << (STREAM_ORDER_SHIFT + STREAM_ORDER_BITS)) - 1u;
  word = (word & ~list_mask) | count | order << STREAM_ORDER_SHIFT;
}

// Bit first + i where the depth test of stream_nearer() changed depth i.
uint stream_passed(uvec4 before, uvec4 after, uint first) {
  uvec4 bits = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), notEqual(before, after));
  return (bits.x | bits.y | bits.z | bits.w) << first;
}

// The depth test: depths of four samples where the mask has them and they are nearer than `stored`, else `stored`.
// Reversed depths are not negative, so their bits compare like the numbers.
uvec4 stream_nearer(uvec4 stored, uint samples, uint mask, uint first, DepthPlane plane) {
  uvec4 result = stored;
  for (uint i = 0u; i < 4u; ++i) {
    uint z = floatBitsToUint(sample_depth(plane, sample_offset(samples, first + i)));
    bool nearer = (mask & (1u << (first + i))) != 0u && z > stored[i];
    result[i] = nearer ? z : stored[i];
  }
  return result;
}

#endif
