// What lighting needs to know of a shaded point, whatever a technique stored it as.
#ifndef SUBPIXEL_SURFACE_GLSL
#define SUBPIXEL_SURFACE_GLSL

struct Surface {
  vec3 position;  // world
  vec3 normal;    // world, unit, on the viewer's side
  vec3 albedo;    // linear base colour
  float metallic;
  float roughness;  // perceptual: alpha = roughness^2
  float occlusion;  // 1: the whole ambient term arrives
  vec3 emissive;    // linear radiance
};

#endif
