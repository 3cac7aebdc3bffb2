// A surface of decoupled coverage anti-aliasing: its numbers, how they are rounded, its plane over the pixel.
// Wang, Wyman, He and Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics 2015, sections 3.4 and 4.3.
// Reads: its arguments alone.
#ifndef SUBPIXEL_DCAA_SURFACE_GLSL
#define SUBPIXEL_DCAA_SURFACE_GLSL

#include "include/packing.glsl"
#include "techniques/dcaa/dcaa_interface.h"

layout(constant_id = DCAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
layout(constant_id = DCAA_CONSTANT_COS_NORMAL_ANGLE) const float COS_NORMAL_ANGLE = 0.98078528;
layout(constant_id = DCAA_CONSTANT_OPTIONS) const uint DCAA_OPTIONS =
    DCAA_SECOND_MERGE | DCAA_KEEP_FRONT | DCAA_TABLE | DCAA_PREPASS;
layout(constant_id = DCAA_CONSTANT_NORMAL_FORMAT) const uint NORMAL_FORMAT = DCAA_NORMAL_2X16;
layout(constant_id = DCAA_CONSTANT_DEPTH_BITS) const uint DEPTH_BITS = 24u;

// How far from the pixel's centre a surface's depth interval reaches, in pixels.
layout(constant_id = DCAA_CONSTANT_DEPTH_REACH) const float DEPTH_REACH = 0.5;
// 1 / k of equation 1 (Crassin et al. 2016), for DCAA_NEAREST.
layout(constant_id = DCAA_CONSTANT_INVERSE_LENGTH) const float INVERSE_LENGTH = 10.0;

// M(k) for each surface. Loops over surfaces have to be unrolled, or their arrays lie in memory; drivers don't unroll loops
// that hold others, or large ones.
#define EACH_SURFACE(M)     \
  M(0u)                     \
  if (SURFACES > 1u) { M(1u) } \
  if (SURFACES > 2u) { M(2u) } \
  if (SURFACES > 3u) { M(3u) } \
  if (SURFACES > 4u) { M(4u) } \
  if (SURFACES > 5u) { M(5u) } \
  if (SURFACES > 6u) { M(6u) } \
  if (SURFACES > 7u) { M(7u) }

bool dcaa_option(uint option) { return (DCAA_OPTIONS & option) != 0u; }

struct DcaaSurface {
  uvec2 coverage;  // samples
  uvec3 facet;     // normal of the triangle's plane, in world space; formats of one word use x
  float depth;     // reversed, of the plane at the pixel's centre
  uint albedo;     // this word and the next as in packing.glsl
  uint normal;
  uint roughness;  // 8 bits
  uint emission;   // shared exponent
  uvec3 moments;   // DCAA_SECOND_MOMENTS: of the shading normals, x y z: xx xy, yy xz, zz yz, 16 bits each
};

uint dcaa_count(uvec2 mask) { return bitCount(mask.x) + (SAMPLES > 32u ? bitCount(mask.y) : 0u); }

// Every operation of what follows is given its order, so that surfaces are the same bits everywhere.

vec3 dcaa_unit(vec3 v) {
  precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  precise vec3 unit = v / sqrt(max(squared, 1e-30));
  return unit;
}

// `bits` of each component, two's complement, 2^(bits - 1) - 1 standing for 1.
uint dcaa_snorm(float v, float largest, uint mask) { return round_to_even(clamp(v, -1.0, 1.0) * largest) & mask; }
float dcaa_from_snorm(uint word, uint shift, uint bits, float largest) {
  int value = int(word << (32u - bits - shift)) >> (32u - bits);
  return max(float(value) / largest, -1.0);
}

uint dcaa_pack_octahedral(vec3 n, float largest, uint bits) {
  precise float sum = abs(n.x) + abs(n.y) + abs(n.z);
  precise vec2 p = n.xy / max(sum, 1e-30);
  precise vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  p = n.z < 0.0 ? folded : p;
  uint mask = (1u << bits) - 1u;
  return dcaa_snorm(p.x, largest, mask) | dcaa_snorm(p.y, largest, mask) << bits;
}

vec3 dcaa_unpack_octahedral(uint word, float largest, uint bits) {
  vec2 p = vec2(dcaa_from_snorm(word, 0u, bits, largest), dcaa_from_snorm(word, bits, bits, largest));
  precise float z = 1.0 - abs(p.x) - abs(p.y);
  float t = max(-z, 0.0);
  precise vec2 xy = p + vec2(p.x >= 0.0 ? -t : t, p.y >= 0.0 ? -t : t);
  return dcaa_unit(vec3(xy, z));
}

// A shading normal. A mean of several has a length below 1, which DCAA_DISTRIBUTION keeps: 12 bits each of the direction and 8
// of the root of what is missing to 1, since highlights tell lengths near 1 apart.
uint dcaa_pack_shading(vec3 n) {
  if (!dcaa_option(DCAA_DISTRIBUTION)) return dcaa_pack_octahedral(n, 32767.0, 16u);
  precise float squared = n.x * n.x + n.y * n.y + n.z * n.z;
  precise float missing = sqrt(max(1.0 - sqrt(squared), 0.0)) * 255.0;
  return dcaa_pack_octahedral(n, 2047.0, 12u) | (round_to_even(missing) & 255u) << 24;
}

vec3 dcaa_shading(uint word) {
  if (!dcaa_option(DCAA_DISTRIBUTION)) return dcaa_unpack_octahedral(word, 32767.0, 16u);
  float root = float(int(word >> 24)) / 255.0;
  precise float length_of_mean = 1.0 - root * root;
  precise vec3 mean = dcaa_unpack_octahedral(word, 2047.0, 12u) * length_of_mean;
  return mean;
}

// Of one normal: squares from 0 to 1 in the low halves of the words, products from -1 to 1 in the high ones.
uvec3 dcaa_moments_of(uint normal) {
  if (!dcaa_option(DCAA_SECOND_MOMENTS)) return uvec3(0u);
  vec3 n = dcaa_unit(dcaa_shading(normal));
  precise vec3 squares = n * n * 65535.0;
  precise vec3 products = (n.xxy * n.yzz * 0.5 + 0.5) * 65535.0;
  uvec3 words;
  for (uint c = 0u; c < 3u; ++c)
    words[c] = (round_to_even(squares[c]) & 0xffffu) | (round_to_even(products[c]) & 0xffffu) << 16;
  return words;
}
void dcaa_moments(uvec3 words, out vec3 squares, out vec3 products) {
  squares = vec3(ivec3(words & 0xffffu)) * (1.0 / 65535.0);
  products = vec3(ivec3(words >> 16)) * (2.0 / 65535.0) - 1.0;
}

uvec3 dcaa_pack_facet(vec3 n) {
  if (NORMAL_FORMAT == DCAA_NORMAL_3X32) return floatBitsToUint(dcaa_unit(n));
  if (NORMAL_FORMAT == DCAA_NORMAL_2X8) return uvec3(dcaa_pack_octahedral(n, 127.0, 8u), 0u, 0u);
  if (NORMAL_FORMAT == DCAA_NORMAL_3X8) {
    vec3 u = dcaa_unit(n);
    return uvec3(dcaa_snorm(u.x, 127.0, 255u) | dcaa_snorm(u.y, 127.0, 255u) << 8 | dcaa_snorm(u.z, 127.0, 255u) << 16, 0u, 0u);
  }
  return uvec3(dcaa_pack_octahedral(n, 32767.0, 16u), 0u, 0u);
}

vec3 dcaa_facet(uvec3 words) {
  if (NORMAL_FORMAT == DCAA_NORMAL_3X32) return uintBitsToFloat(words);
  if (NORMAL_FORMAT == DCAA_NORMAL_2X8) return dcaa_unpack_octahedral(words.x, 127.0, 8u);
  if (NORMAL_FORMAT == DCAA_NORMAL_3X8)
    return dcaa_unit(vec3(dcaa_from_snorm(words.x, 0u, 8u, 127.0), dcaa_from_snorm(words.x, 8u, 8u, 127.0),
                          dcaa_from_snorm(words.x, 16u, 8u, 127.0)));
  return dcaa_unpack_octahedral(words.x, 32767.0, 16u);
}

// A depth of DEPTH_BITS < 32 bits is a float without sign whose exponent has 5 bits, from 2^-31 to 1: relative precision as
// reversed depth wants it. Returned are the stored bits.
const uint kDepthBase = 96u << 23;  // 2^-31
const uint kDepthShift = DEPTH_BITS == 32u ? 4u : 28u - DEPTH_BITS;
uint dcaa_pack_depth(float z) {
  uint bits = floatBitsToUint(z);
  if (DEPTH_BITS == 32u) return bits;
  return (clamp(bits, kDepthBase, kDepthBase + 0x0fffffffu - (1u << kDepthShift >> 1)) - kDepthBase + (1u << kDepthShift >> 1)) >> kDepthShift;
}
float dcaa_unpack_depth(uint stored) {
  return uintBitsToFloat(DEPTH_BITS == 32u ? stored : kDepthBase + (stored << kDepthShift));
}
// The depth as it will be read back.
float dcaa_rounded_depth(float z) {
  return dcaa_unpack_depth(dcaa_pack_depth(clamp(z, 0.0, 1.9999)));
}

// Screen slopes per unit of (z * rays_differ + scale), of a plane with this normal where `ray` meets it.
vec2 dcaa_slope_factors(vec3 n, vec3 ray, DcaaView view) {
  precise float along = n.x * ray.x + n.y * ray.y + n.z * ray.z;
  precise float across_x = n.x * view.ray_dx.x + n.y * view.ray_dx.y + n.z * view.ray_dx.z;
  precise float across_y = n.x * view.ray_dy.x + n.y * view.ray_dy.y + n.z * view.ray_dy.z;
  precise vec2 g = vec2(across_x, across_y) / min(along, view.ray_dx.w);
  return clamp(g, -view.ray_dy.w, view.ray_dy.w);
}

vec2 dcaa_slopes(vec3 n, float depth, vec3 ray, DcaaView view) {
  vec2 g = dcaa_slope_factors(n, ray, view);
  precise vec2 slopes = (depth * view.terms.x + view.terms.y) * g;
  return slopes;
}

vec3 dcaa_ray(ivec2 pixel, DcaaView view) {
  vec2 at = vec2(float(pixel.x), float(pixel.y) + view.ray0.w) * view.terms.x;
  precise vec3 ray = view.ray0.xyz + (at.x * view.ray_dx.xyz + at.y * view.ray_dy.xyz);
  return ray;
}

// Where on `ray` depth z is, in units of k.
float dcaa_place(float z, vec3 ray, DcaaView view) {
  precise float per_ray = sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z) * INVERSE_LENGTH;
  precise float along = view.terms.x != 0.0 ? view.terms.z / max(z + view.terms.y, 1e-30) : z;
  precise float place = along * per_ray;
  return place;
}

// Equation 1 of Crassin et al. 2016, for surfaces of one pixel: their places on the ray of its centre, their facet normals.
float dcaa_distance(float place_a, vec3 a, float place_b, vec3 b) {
  precise float away = min(abs(place_a - place_b), 1e15);
  precise float cosine = a.x * b.x + a.y * b.y + a.z * b.z;
  precise float d = away * away + (1.0 - cosine) * 0.5;
  return d;
}

// What the stored words of a surface say of its plane.
struct DcaaPlane {
  vec3 normal;
  vec2 slopes;
};
DcaaPlane dcaa_plane(DcaaSurface s, vec3 ray, DcaaView view) {
  vec3 normal = dcaa_facet(s.facet);
  return DcaaPlane(normal, dcaa_slopes(normal, s.depth, ray, view));
}

// Farthest and nearest depth of the plane over the pixel, each moved out by one unit of the stored depth, so that two
// surfaces of one plane that faces the eye overlap whatever their depths were rounded to.
vec2 dcaa_interval(DcaaPlane plane, float depth) {
  vec2 slope = abs(plane.slopes);
  float unit = uintBitsToFloat((127u + 5u - min(DEPTH_BITS, 28u)) << 23);
  precise float reach = DEPTH_REACH * (slope.x + slope.y) + depth * unit;
  precise vec2 interval = vec2(depth - reach, depth + reach);
  return interval;
}

#endif
