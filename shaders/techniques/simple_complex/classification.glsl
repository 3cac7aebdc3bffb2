// Do the samples of a pixel agree? Lauritzen 2010, "Deferred rendering for current and future rendering pipelines".
// The including shader defines SAMPLES (4 or more) and the functions declared here, which tell about one pixel.
// Reads and writes: nothing else.
#ifndef SUBPIXEL_CLASSIFICATION_GLSL
#define SUBPIXEL_CLASSIFICATION_GLSL

#include "frontend/frontend_types.h"

struct ClassifiedSurface {
  vec3 normal;  // unit
  uint material;
};

uvec4 quad_triangles(uint quad);  // of samples 4 quad to 4 quad + 3
vec4 quad_depths(uint quad);
ClassifiedSurface sample_surface(uint s);  // asked of covered samples only
vec2 triangle_slopes(uint triangle);       // dz/dx and dz/dy per pixel

// A pixel is complex when a sample differs from sample 0: in depth by more than |dz/dx| + |dz/dy| of sample 0's triangle times
// `depth_scale`, in normal by a cosine below `least_cosine`, in material, or in that one of them shows the sky. Samples of
// the same triangle agree, since one plane and one fragment made them.
bool pixel_is_complex(float depth_scale, float least_cosine) {
  uint zero = quad_triangles(0u).x;
  bool differs = false;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) differs = differs || quad_triangles(quad) != uvec4(zero);
  bool complex = differs && zero == SUBPIXEL_NO_TRIANGLE;
  // Loops, so that groups of pixels with nothing to compare skip the work.
  for (bool compare = differs && !complex; compare; compare = false) {
    ClassifiedSurface first = sample_surface(0u);
    float depth = quad_depths(0u).x;
    vec2 slopes = triangle_slopes(zero);
    float reach = (abs(slopes.x) + abs(slopes.y)) * depth_scale;
    for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
      uvec4 triangles = quad_triangles(quad);
      vec4 depths = quad_depths(quad);
      for (uint i = 0u; i < 4u; ++i) {
        complex = complex || triangles[i] == SUBPIXEL_NO_TRIANGLE || (triangles[i] != zero && abs(depths[i] - depth) > reach);
        for (bool other = !complex && triangles[i] != zero; other; other = false) {
          ClassifiedSurface surface = sample_surface(4u * quad + i);
          // In this order, each product and sum rounded: the decision is the same wherever it is computed.
          precise float cosine = first.normal.x * surface.normal.x;
          cosine = cosine + first.normal.y * surface.normal.y;
          cosine = cosine + first.normal.z * surface.normal.z;
          complex = cosine < least_cosine || surface.material != first.material;
        }
      }
    }
  }
  return complex;
}

#endif
