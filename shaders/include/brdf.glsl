// How a surface scatters the light of one direction: glTF metallic-roughness (GGX, height-correlated Smith, Schlick,
// Lambert; Khronos glTF 2.0 appendix B), or Blinn-Phong as the AGAA paper shades with.
// Reads: SHADING_MODEL, FEATURES. No branches: lavapipe runs both sides anyway.
#ifndef SUBPIXEL_BRDF_GLSL
#define SUBPIXEL_BRDF_GLSL

#include "include/frame.glsl"
#include "include/surface.glsl"

layout(constant_id = CONSTANT_SHADING_MODEL) const uint SHADING_MODEL = SHADING_MODEL_GGX;

const float kPi = 3.14159265358979;
// Lights are points and directions, so a mirror would be a highlight of no size: the roughness floor keeps alpha^2 at
// 6e-5 and the distribution's peak near 5000.
const float kRoughnessFloor = 0.089;
// Grazing and back-turned view directions (interpolated and mapped normals do that) count as this cosine.
const float kCosineFloor = 1e-3;
const float kDielectricReflectance = 0.04;

// The surface's part of the evaluation, the same for all lights.
struct Brdf {
  vec3 normal;
  vec3 view;           // unit, surface to eye
  vec3 diffuse;        // Lambert, 1 / pi included
  vec3 reflectance;    // at normal incidence
  float grazing;       // reflectance at grazing incidence
  vec3 ambient;        // fraction of a uniform environment's radiance sent to the eye
  float cosine;        // of normal and view, of either sign
  float normal_view;   // the same, at least kCosineFloor
  float alpha_squared;
  float smith_view;    // sqrt(alpha^2 + (1 - alpha^2) cosine^2)
  float exponent;      // Blinn-Phong
};

// Schlick's reflectance at grazing incidence: 1, and less where less than a fiftieth, which no bare surface has, is
// reflected at normal incidence, so that unlit surfaces reflect nothing at any angle. Without those in the scene the
// darkest metals keep their 1.
float grazing_reflectance(vec3 reflectance) {
  if (!has_feature(FEATURE_UNLIT)) return 1.0;
  return clamp(50.0 * max(max(reflectance.r, reflectance.g), reflectance.b), 0.0, 1.0);
}

// Directional albedo of the specular lobe: Karis 2014, "Physically based shading on mobile".
vec3 environment_reflectance(vec3 reflectance, float grazing, float roughness, float normal_view) {
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a004 = min(r.x * r.x, exp2(-9.28 * normal_view)) * r.x + r.y;
  vec2 scale_bias = vec2(-1.04, 1.04) * a004 + r.zw;
  return clamp(reflectance * scale_bias.x + grazing * scale_bias.y, 0.0, 1.0);
}

Brdf prepare_brdf(Surface s, vec3 view) {
  Brdf b;
  b.normal = s.normal;
  b.view = view;
  float roughness = clamp(s.roughness, kRoughnessFloor, 1.0);
  float metallic = clamp(s.metallic, 0.0, 1.0);
  vec3 albedo = clamp(s.albedo, 0.0, 1.0);
  float alpha = roughness * roughness;
  b.alpha_squared = alpha * alpha;
  vec3 diffuse_colour = albedo * (1.0 - metallic);
  b.diffuse = diffuse_colour * (1.0 / kPi);
  b.reflectance = mix(vec3(kDielectricReflectance), albedo, metallic);
  b.grazing = grazing_reflectance(b.reflectance);
  b.cosine = dot(s.normal, view);
  b.normal_view = clamp(b.cosine, kCosineFloor, 1.0);
  b.smith_view = sqrt(b.normal_view * b.normal_view * (1.0 - b.alpha_squared) + b.alpha_squared);
  // Matches the lobe of the GGX distribution near its peak (Walter et al. 2007, section 5.1 for the relation).
  b.exponent = 2.0 / b.alpha_squared - 2.0;
  vec3 specular = environment_reflectance(b.reflectance, b.grazing, roughness, b.normal_view);
  b.ambient = diffuse_colour * (1.0 - specular) + specular;
  return b;
}

// BRDF times cosine for the unit direction `light` towards a light whose cosine with the normal is `normal_light`, in
// [0, 1]. Half-vector cosines come from the other cosines, so that each light costs one division and two square roots.
vec3 reflected(Brdf b, vec3 light, float normal_light) {
  float half_squared = max(2.0 + 2.0 * dot(light, b.view), 1e-6);  // |light + view|^2
  float sum = max(normal_light + b.cosine, 0.0);
  float sum_squared = min(sum * sum, half_squared);  // (n.h)^2 half_squared
  if (SHADING_MODEL == SHADING_MODEL_BLINN_PHONG) {
    float lobe = sum > 0.0 ? exp2(0.5 * b.exponent * log2(max(sum_squared / half_squared, 1e-30))) : 0.0;
    return (b.diffuse + b.reflectance * ((b.exponent + 8.0) * (0.125 / kPi) * lobe)) * normal_light;
  }
  float denominator = max((b.alpha_squared - 1.0) * sum_squared + half_squared, b.alpha_squared * half_squared);
  float smith_light = sqrt(normal_light * normal_light * (1.0 - b.alpha_squared) + b.alpha_squared);
  float visibility = normal_light * b.smith_view + b.normal_view * smith_light;
  float lobe = b.alpha_squared * half_squared * half_squared /
               (2.0 * kPi * denominator * denominator * visibility);
  float grazing = 1.0 - min(0.5 * sqrt(half_squared), 1.0);  // 1 - v.h
  float grazing2 = grazing * grazing;
  float schlick = grazing2 * grazing2 * grazing;
  vec3 fresnel = b.reflectance + (b.grazing - b.reflectance) * schlick;
  return (b.diffuse * (1.0 - fresnel) + fresnel * lobe) * normal_light;
}

#endif
