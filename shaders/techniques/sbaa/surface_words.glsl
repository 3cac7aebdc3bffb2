// How a pixel's kept surfaces are stored: 16 bits each, two in a component of a texel.
// Reads and writes: nothing.
#ifndef SUBPIXEL_SURFACE_WORDS_GLSL
#define SUBPIXEL_SURFACE_WORDS_GLSL

// 8 bits for the surface's first sample, 8 for how many it has; 0 is none.
uint surface_word(uint mask) { return mask == 0u ? 0u : uint(bitCount(mask)) << 8 | uint(findLSB(mask)); }
uint surface_first(uint word) { return word & 255u; }
uint surface_samples(uint word) { return word >> 8; }
// Surface k of a pixel's texel, two surfaces in a component.
uint stored_surface(uvec4 texel, uint k) { return texel[k / 2u] >> 16u * (k & 1u) & 0xffffu; }

#endif
