// Texture reads from a buffer: the reference shades all materials in one pass, and which textures a pixel
// needs is known only there, while descriptors that differ from pixel to pixel need a feature not every driver has.
// Reads: texel words and level records. Same filters, level of detail and wrap as textureGrad with the texture's
// sampler.
#ifndef SUBPIXEL_REFERENCE_TEXTURES_GLSL
#define SUBPIXEL_REFERENCE_TEXTURES_GLSL

#include "reference/triangles.glsl"

// sRGB bytes to linear: the exact segment near black, else a least-squares fit over the byte values, within 2e-5.
vec3 srgb_decode(vec3 s) {
  vec3 curved = ((((((-0.0596802111 * s + 0.239878153) * s - 0.446931621) * s + 0.721867228) * s + 0.510812888) * s +
                  0.033113666) * s + 0.000920098083);
  return mix(curved, s * (1.0 / 12.92), lessThan(s, vec3(0.0405)));
}

vec4 texel_of(uvec4 place, uint x, uint y) {
  vec4 value = unpackUnorm4x8(push.texels.at[place.x + y * place.y + x]);
  return vec4((place.w & LEVEL_SRGB) != 0u ? srgb_decode(value.rgb) : value.rgb, value.a);
}

vec4 bilinear(uint level, vec2 uv) {
  uvec4 place = levels[level].place;
  vec2 size = vec2(place.yz);
  vec2 at = (uv - floor(uv)) * size - 0.5;
  vec2 corner = floor(at), f = at - corner;
  uvec2 last = place.yz - 1u;
  uvec2 low = uvec2(corner.x < 0.0 ? last.x : min(uint(corner.x), last.x),
                    corner.y < 0.0 ? last.y : min(uint(corner.y), last.y));
  uvec2 high = uvec2(low.x == last.x ? 0u : low.x + 1u, low.y == last.y ? 0u : low.y + 1u);
  vec4 top = mix(texel_of(place, low.x, low.y), texel_of(place, high.x, low.y), f.x);
  vec4 bottom = mix(texel_of(place, low.x, high.y), texel_of(place, high.x, high.y), f.x);
  return mix(top, bottom, f.y);
}

// `u` moved by whole images, or clamped, so that it keeps its digits: to [0, 1], mirrored to [0, 2).
float near_image(float u, uint wrap) {
  float repeated = u - floor(u), mirrored = u - 2.0 * floor(0.5 * u);
  return wrap == 0u ? repeated : wrap == 1u ? clamp(u, 0.0, 1.0) : mirrored;
}

// The texel of row or column `i`, at most one image or, mirrored, two away (Vulkan 1.3, "Wrapping Operation").
uint wrapped(int i, int size, uint wrap) {
  int repeated = i < 0 ? i + size : i >= size ? i - size : i;
  int twice = i < 0 ? i + 2 * size : i >= 2 * size ? i - 2 * size : i;
  int mirrored = twice < size ? twice : 2 * size - 1 - twice;
  return uint(wrap == 0u ? repeated : wrap == 1u ? clamp(i, 0, size - 1) : mirrored);
}

// One level by the texture's own wrap modes, its nearest texel or the mean of four.
vec4 filtered(uint level, vec2 uv, bool nearest) {
  uvec4 place = levels[level].place;
  ivec2 size = ivec2(place.yz);
  uvec2 wrap = uvec2(place.w >> LEVEL_WRAP_U_SHIFT, place.w >> LEVEL_WRAP_V_SHIFT) & 3u;
  vec2 at = vec2(near_image(uv.x, wrap.x), near_image(uv.y, wrap.y)) * vec2(size);
  ivec2 texel = ivec2(floor(at));
  if (nearest) return texel_of(place, wrapped(texel.x, size.x, wrap.x), wrapped(texel.y, size.y, wrap.y));
  ivec2 corner = ivec2(floor(at - 0.5));
  vec2 f = at - 0.5 - vec2(corner);
  uint x0 = wrapped(corner.x, size.x, wrap.x), x1 = wrapped(corner.x + 1, size.x, wrap.x);
  uint y0 = wrapped(corner.y, size.y, wrap.y), y1 = wrapped(corner.y + 1, size.y, wrap.y);
  vec4 top = mix(texel_of(place, x0, y0), texel_of(place, x1, y0), f.x);
  vec4 bottom = mix(texel_of(place, x0, y1), texel_of(place, x1, y1), f.x);
  return mix(top, bottom, f.y);
}

// White without a texture.
vec4 texture_at(uint reference, Coordinates c) {
  bool present = reference != REFERENCE_NO_TEXTURE;
  uint first = present ? reference & 0xffffffu : 0u, count = present ? reference >> 24 : 1u;
  vec2 size = vec2(levels[first].place.yz);
  vec2 dx = c.dx * size, dy = c.dy * size;
  float rho_squared = clamp(max(dot(dx, dx), dot(dy, dy)), 1e-12, 1e12);
  if (has_feature(FEATURE_SAMPLERS)) {
    uint bits = levels[first].place.w;
    float detail = 0.5 * log2(rho_squared);
    bool nearest = (bits & (detail > 0.0 ? LEVEL_MINIFY_NEAREST : LEVEL_MAGNIFY_NEAREST)) != 0u;
    detail = clamp(detail, 0.0, float(count - 1u));
    // Halves go to the finer level (Vulkan 1.3, "Image Level(s) Selection").
    if ((bits & LEVEL_MIP_NEAREST) != 0u) detail = ceil(detail + 0.5) - 1.0;
    uint level = uint(detail);
    vec4 fine = filtered(first + level, c.uv, nearest);
    vec4 coarse = filtered(first + min(level + 1u, count - 1u), c.uv, nearest);
    return present ? mix(fine, coarse, detail - float(level)) : vec4(1.0);
  }
  float lod = clamp(0.5 * log2(rho_squared), 0.0, float(count - 1u));
  uint level = uint(lod);
  vec4 fine = bilinear(first + level, c.uv), coarse = bilinear(first + min(level + 1u, count - 1u), c.uv);
  return present ? mix(fine, coarse, lod - float(level)) : vec4(1.0);
}

#endif
