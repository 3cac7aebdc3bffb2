// The radiance an aggregate sends to the eye: lighting filtered over the distribution of its normals and positions.
// Reads: frame constants, shadow map. An aggregate of one normal and one position is lit as shade() of lights.glsl would.
#ifndef SUBPIXEL_AGAA_SHADING_GLSL
#define SUBPIXEL_AGAA_SHADING_GLSL

#include "include/lights.glsl"
#include "techniques/agaa/aggregate.glsl"

layout(constant_id = AGAA_CONSTANT_SHADOW_TAPS) const uint SHADOW_TAPS = 4u;

// GGX alpha^2 that a unit of variance of the normals adds: Toksvig's exponent is 1 / variance, and alpha^2 = 2 / (exponent + 2).
const float kSlopeVariance = 2.0;

// Where an aggregate is: mean and spread of its samples' positions, world space.
struct Footprint {
  vec3 mean;
  vec3 axis[3];  // columns of a square root of the covariance matrix
};

// The distribution's part of the evaluation, the same for all lights.
struct Lobe {
  Brdf brdf;          // around the mean direction
  vec3 mean;          // of the normals, not longer than 1
  vec3 axis;          // its direction
  vec2 spread;        // variance of the normals along the mean direction and across it, when isotropic
  vec3 moments, mixed_moments;
  float cosine_variance;  // of the cosine with the light at hand, by the spread of its directions
  // GGX alpha^2 as a matrix (xx, xy, yy) on the tangents, its inverse, its determinant's root; anisotropic only
  vec3 tangent, bitangent, matrix, inverse;
  float root;
};

// x^T M x for a symmetric matrix as moments are kept.
float quadratic(vec3 diagonal, vec3 mixed, vec3 x) {
  return dot(diagonal, x * x) + 2.0 * dot(mixed, x.xxy * x.yzz);
}
float quadratic(vec3 matrix, vec2 x) { return matrix.x * x.x * x.x + 2.0 * matrix.y * x.x * x.y + matrix.z * x.y * x.y; }

bool anisotropic() { return agaa_option(AGAA_SGGX | AGAA_LEAN); }

// Variance over the normals of their cosine with the unit vector `direction`.
float cosine_variance(Lobe lobe, vec3 direction) {
  if (agaa_option(AGAA_SGGX)) {
    float mean = dot(lobe.mean, direction);
    return max(quadratic(lobe.moments, lobe.mixed_moments, direction) - mean * mean, 0.0);
  }
  float c = dot(lobe.axis, direction);
  return lobe.spread.y + (lobe.spread.x - lobe.spread.y) * c * c;
}

// What a uniform environment adds: its mean over the normals, each with the material's own roughness, by three points of
// Gauss and Hermite in the cosine with the view. At the mean direction with the widened roughness, as a light's highlight
// is filtered, it would be too dark at grazing angles and too bright head-on.
vec3 filtered_ambient(Lobe lobe, vec3 diffuse, float roughness) {
  float mean = dot(lobe.mean, lobe.brdf.view), reach = sqrt(3.0 * cosine_variance(lobe, lobe.brdf.view));
  vec3 at[3];
  for (int i = 0; i < 3; ++i) {
    float cosine = clamp(mean + float(i - 1) * reach, kCosineFloor, 1.0);
    vec3 specular = environment_reflectance(lobe.brdf.reflectance, lobe.brdf.grazing, roughness, cosine);
    at[i] = diffuse * (1.0 - specular) + specular;
  }
  return at[1] + (at[0] + at[2] - 2.0 * at[1]) * (1.0 / 6.0);
}

// Sets the highlights' width and what follows from it.
void set_width(inout Lobe lobe, float alpha_squared) {
  float normal_view = lobe.brdf.normal_view;
  lobe.brdf.alpha_squared = alpha_squared;
  lobe.brdf.exponent = exponent_of(alpha_squared);
  lobe.brdf.smith_view = sqrt(normal_view * normal_view * (1.0 - alpha_squared) + alpha_squared);
}
void set_width(inout Lobe lobe, vec3 matrix, float least_determinant) {
  float normal_view = lobe.brdf.normal_view;
  lobe.matrix = matrix;
  float determinant = max(matrix.x * matrix.z - matrix.y * matrix.y, least_determinant);
  lobe.inverse = vec3(matrix.z, -matrix.y, matrix.x) / determinant;
  lobe.root = sqrt(determinant);
  lobe.brdf.alpha_squared = min(lobe.root, 1.0);
  lobe.brdf.exponent = exponent_of(lobe.brdf.alpha_squared);
  vec2 view_slope = vec2(dot(lobe.tangent, lobe.brdf.view), dot(lobe.bitangent, lobe.brdf.view));
  lobe.brdf.smith_view = sqrt(normal_view * normal_view + quadratic(matrix, view_slope));
}

Lobe prepare_lobe(Aggregate a, vec3 view) {
  Lobe lobe;
  float mean_length = min(length(a.normal), 1.0);
  bool directed = mean_length > 1e-4;
  vec3 direction = directed ? a.normal / mean_length : view;
  lobe.mean = a.normal;
  lobe.axis = direction;
  lobe.cosine_variance = 0.0;
  lobe.moments = a.moments;
  lobe.mixed_moments = a.mixed_moments;
  // Moments of the von Mises-Fisher distribution with this mean (Banerjee et al. 2005 for its concentration): across
  // length / concentration, along what is left of 1.
  float across = (1.0 - mean_length * mean_length) / (3.0 - mean_length * mean_length);
  lobe.spread = vec2(max(1.0 - 2.0 * across - mean_length * mean_length, 0.0), across);

  float alpha_squared = alpha_squared_of_roughness(a.roughness);
  float filtered;
  if (agaa_option(AGAA_ROUGHNESS_IN_NORMAL)) {
    filtered = clamp(alpha_squared_of(mean_length / max(1.0 - mean_length, 1e-6)), alpha_squared_of_roughness(0.0), 1.0);
  } else {
    // Steps 1 to 4 of section 3.5.2.
    float exponent = exponent_of(alpha_squared);
    float toksvig = mean_length / (mean_length + exponent * (1.0 - mean_length));
    filtered = alpha_squared_of(toksvig * exponent);
  }
  lobe.tangent = lobe.bitangent = lobe.matrix = lobe.inverse = vec3(0.0);
  lobe.root = 0.0;
  vec3 spread = vec3(0.0);  // of the normals on the tangents: GGX alpha^2 as a matrix
  if (agaa_option(AGAA_SGGX)) {
    // The SGGX matrix of a rough surface (Heitz et al. 2015) averaged over the normals, in the frame of the mean direction and
    // scaled to 1 along it.
    tangents_of(direction, lobe.tangent, lobe.bitangent);
    vec3 m = vec3(quadratic(a.moments, a.mixed_moments, lobe.tangent), 0.0,
                  quadratic(a.moments, a.mixed_moments, lobe.bitangent));
    vec3 t = lobe.tangent, b = lobe.bitangent;
    m.y = dot(a.moments, t * b) + dot(a.mixed_moments, t.xxy * b.yzz + t.yzz * b.xxy);
    float along = max(quadratic(a.moments, a.mixed_moments, direction), 1e-2);
    spread = max(m * (kSlopeVariance / along), vec3(0.0, -1.0, 0.0));
  }
  if (agaa_option(AGAA_LEAN)) {
    // Around the normal of the mean slope, the covariance of the slopes turned into its frame by the slopes' derivative there.
    mat3 axes = slope_frame(view);
    float steepness = inversesqrt(1.0 + dot(a.slope, a.slope));
    direction = axes * vec3(a.slope, 1.0) * steepness;
    tangents_of(direction, lobe.tangent, lobe.bitangent);
    vec2 t = (lobe.tangent * axes).xy * steepness, b = (lobe.bitangent * axes).xy * steepness;
    vec3 covariance = a.slope_moments - a.slope.xxy * a.slope.xyy;
    covariance.xz = max(covariance.xz, 0.0);
    covariance.y = clamp(covariance.y, -sqrt(covariance.x * covariance.z), sqrt(covariance.x * covariance.z));
    float mixed = covariance.x * t.x * b.x + covariance.y * (t.x * b.y + t.y * b.x) + covariance.z * t.y * b.y;
    spread = kSlopeVariance * vec3(quadratic(covariance, t), mixed, quadratic(covariance, b));
  }

  Brdf b;
  b.normal = direction;
  b.view = view;
  b.diffuse = a.diffuse * (1.0 / kPi);
  b.reflectance = a.reflectance;
  b.grazing = grazing_reflectance(b.reflectance);
  b.cosine = dot(direction, view);
  b.normal_view = clamp(b.cosine, kCosineFloor, 1.0);
  b.alpha_squared = b.exponent = b.smith_view = 0.0;
  lobe.brdf = b;
  if (anisotropic())
    set_width(lobe, spread + vec3(alpha_squared, 0.0, alpha_squared), alpha_squared * alpha_squared);
  else
    set_width(lobe, filtered);
  // Where the roughness is only known as part of the normals' spread, there is no other.
  float roughness =
      agaa_option(AGAA_ROUGHNESS_IN_NORMAL) ? sqrt(sqrt(lobe.brdf.alpha_squared)) : clamp(a.roughness, kRoughnessFloor, 1.0);
  lobe.brdf.ambient = filtered_ambient(lobe, a.diffuse, roughness);
  return lobe;
}

// The mean over the normals of max(cosine with `light`, 0). With m and v the mean and the variance of the cosine,
// (m + sqrt(m^2 + 2 v / pi)) / 2: exact for v = 0, and at m = 0 for a normal distribution. Filters diffuse light as Baker and
// Hill 2012 do with a table, by moments that Toksvig's vector or the second moments give.
float filtered_cosine(Lobe lobe, vec3 light) {
  float mean = dot(lobe.mean, light), variance = cosine_variance(lobe, light) + lobe.cosine_variance;
  return 0.5 * (mean + sqrt(mean * mean + (2.0 / kPi) * variance));
}

// What reflects: colours of one aggregate, all of it or the sunlit part.
struct Reflecting {
  vec3 diffuse;      // 1 / pi included
  vec3 reflectance;  // at normal incidence
  float grazing;     // at grazing incidence
};

// BRDF times cosine, as reflected() of brdf.glsl, filtered.
vec3 lobe_reflected(Lobe lobe, vec3 light, Reflecting r) {
  Brdf b = lobe.brdf;
  float diffuse_cosine = filtered_cosine(lobe, light);
  float normal_light = clamp(dot(b.normal, light), 0.0, 1.0);
  float half_squared = max(2.0 + 2.0 * dot(light, b.view), 1e-6);
  float sum = max(normal_light + b.cosine, 0.0);
  float sum_squared = min(sum * sum, half_squared);
  if (!anisotropic()) {
    if (SHADING_MODEL == SHADING_MODEL_BLINN_PHONG) {
      float lobe = sum > 0.0 ? exp2(0.5 * b.exponent * log2(max(sum_squared / half_squared, 1e-30))) : 0.0;
      return r.diffuse * diffuse_cosine + r.reflectance * ((b.exponent + 8.0) * (0.125 / kPi) * lobe * normal_light);
    }
    float denominator = max((b.alpha_squared - 1.0) * sum_squared + half_squared, b.alpha_squared * half_squared);
    float smith_light = sqrt(normal_light * normal_light * (1.0 - b.alpha_squared) + b.alpha_squared);
    float visibility = normal_light * b.smith_view + b.normal_view * smith_light;
    float value = b.alpha_squared * half_squared * half_squared / (2.0 * kPi * denominator * denominator * visibility);
    float grazing = 1.0 - min(0.5 * sqrt(half_squared), 1.0);
    float schlick = grazing * grazing * grazing * grazing * grazing;
    vec3 fresnel = b.reflectance + (b.grazing - b.reflectance) * schlick;
    vec3 specular = r.reflectance + (r.grazing - r.reflectance) * schlick;
    return r.diffuse * (1.0 - fresnel) * diffuse_cosine + specular * (value * normal_light);
  }
  vec2 halfway = vec2(dot(lobe.tangent, light + b.view), dot(lobe.bitangent, light + b.view));
  float sloped = quadratic(lobe.inverse, halfway);
  if (SHADING_MODEL == SHADING_MODEL_BLINN_PHONG) {
    // The exponent across the highlight changes with the direction, as in Ashikhmin and Shirley 2000.
    float exponent = max(2.0 * sloped / max(dot(halfway, halfway), 1e-20) - 2.0, 0.0);
    float value = sum > 0.0 ? exp2(0.5 * exponent * log2(max(sum_squared / half_squared, 1e-30))) : 0.0;
    return r.diffuse * diffuse_cosine + r.reflectance * ((b.exponent + 8.0) * (0.125 / kPi) * value * normal_light);
  }
  // D(h) = 1 / (pi sqrt|A| (n.h^2 + t^T A^-1 t)^2), times |h|^4.
  float denominator = sum_squared + sloped;
  vec2 light_slope = vec2(dot(lobe.tangent, light), dot(lobe.bitangent, light));
  float smith_light = sqrt(normal_light * normal_light + quadratic(lobe.matrix, light_slope));
  float visibility = max(normal_light * b.smith_view + b.normal_view * smith_light, 1e-6);
  float value = half_squared * half_squared / (2.0 * kPi * lobe.root * denominator * denominator * visibility);
  float grazing = 1.0 - min(0.5 * sqrt(half_squared), 1.0);
  float schlick = grazing * grazing * grazing * grazing * grazing;
  vec3 fresnel = b.reflectance + (b.grazing - b.reflectance) * schlick;
  vec3 specular = r.reflectance + (r.grazing - r.reflectance) * schlick;
  return r.diffuse * (1.0 - fresnel) * diffuse_cosine + specular * (value * normal_light);
}

// The lit fraction of the footprint: the mean over points whose mean and covariance are the footprint's (4: corners of a
// tetrahedron, 8: of a cube). A footprint within a shadow texel is one point: the shadow's own filter is wider.
float footprint_visibility(Footprint f, vec3 normal, float normal_light) {
  float visibility = 0.0;
  vec2 quadrant;
  float texel = shadow_cascade((frame.shadow_matrix * vec4(f.mean, 1.0)).xyz, 0.5 * float(textureSize(shadow_map, 0).x), quadrant).w;
  float size = dot(f.axis[0], f.axis[0]) + dot(f.axis[1], f.axis[1]) + dot(f.axis[2], f.axis[2]);
  bool wide = SHADOW_TAPS > 1u && size > 0.25 * texel * texel;
  // Loops, so that groups of aggregates take the side all of them need.
  for (bool narrow = !wide; narrow; narrow = false) visibility = sun_visibility(f.mean, normal, normal_light);
  for (uint i = 0u; wide && i < SHADOW_TAPS; ++i) {
    uint signs = SHADOW_TAPS == 8u ? i : (SHADOW_TAPS == 4u ? i | ((i ^ (i >> 1)) & 1u) << 2 : i * 7u);
    vec3 point = f.mean;
    for (uint k = 0u; k < 3u; ++k) point += (signs & (1u << k)) != 0u ? f.axis[k] : -f.axis[k];
    visibility += sun_visibility(point, normal, normal_light) / float(SHADOW_TAPS);
  }
  return visibility;
}

// The lobe as point light i sees it, `light` being the direction to it from the mean position: the spread of its directions over
// the footprint is added to that of the normals (AGAA paper, section 3.5.2), halfway vectors turning as the light does divided by
// |light + view|.
Lobe lobe_of_light(Lobe lobe, Footprint f, uint i, vec3 light) {
  vec3 away = frame.point_lights[i].position_range.xyz - f.mean;
  float square = dot(away, away);
  for (uint k = 0u; k < 3u; ++k) square += dot(f.axis[k], f.axis[k]);
  float inverse = inversesqrt(max(square, 1e-20));
  float inverse_half = inversesqrt(max(2.0 + 2.0 * dot(light, lobe.brdf.view), 1e-2));
  vec3 halfway = (light + lobe.brdf.view) * inverse_half, matrix = vec3(0.0);
  float cosine = 0.0, turned = 0.0;
  for (uint k = 0u; k < 3u; ++k) {
    vec3 turn = (f.axis[k] - light * dot(light, f.axis[k])) * inverse;
    float along = dot(lobe.mean, turn);
    cosine += along * along;
    turn = (turn - halfway * dot(halfway, turn)) * inverse_half;
    turned += dot(turn, turn);
    vec2 on_tangents = vec2(dot(lobe.tangent, turn), dot(lobe.bitangent, turn));
    matrix += on_tangents.xxy * on_tangents.xyy;
  }
  lobe.cosine_variance = cosine;
  // Of two directions, each has half of what turns.
  if (anisotropic())
    set_width(lobe, lobe.matrix + kSlopeVariance * matrix, lobe.root * lobe.root);
  else
    set_width(lobe, min(lobe.brdf.alpha_squared + 0.5 * kSlopeVariance * turned, 1.0));
  return lobe;
}

// Radiance towards the eye along the unit vector `view`.
vec3 shade_aggregate(Aggregate a, Footprint f, vec3 view) {
  Lobe lobe = prepare_lobe(a, view);
  vec3 radiance = frame.ambient.rgb * lobe.brdf.ambient + a.emissive;
  Reflecting all = Reflecting(lobe.brdf.diffuse, lobe.brdf.reflectance, lobe.brdf.grazing);
  if (has_feature(FEATURE_SUN)) {
    vec3 light = -frame.sun_direction.xyz;
    Reflecting lit = all;
    if (has_feature(FEATURE_SHADOWS) && agaa_option(AGAA_LIT)) {
      // Section 3.5.3: multiplied by the shadow before they were averaged. The lit fraction itself is that of the reflectance.
      float fraction = min(luma(a.lit_reflectance) / max(luma(a.reflectance), 1e-4), 1.0);
      lit = Reflecting(a.lit_diffuse * (1.0 / kPi), a.lit_reflectance, all.grazing * fraction);
    }
    vec3 sun = frame.sun_irradiance.rgb * lobe_reflected(lobe, light, lit);
    float normal_light = clamp(dot(lobe.brdf.normal, light), 0.0, 1.0);
    if (has_feature(FEATURE_SHADOWS) && !agaa_option(AGAA_LIT))
      sun *= footprint_visibility(f, lobe.brdf.normal, normal_light);
    radiance += sun;
  }
  if (has_feature(FEATURE_POINT_LIGHTS)) {
    // Attenuated at the mean of the positions, so that the lights that may reach it are all.
    uint cell = light_cell(f.mean);
    for (uint word = 0u; word < frame.light_cells.slices.z; ++word) {
      for (uint near = light_cells[cell + word]; near != 0u; near &= near - 1u) {
        uint i = word * 32u + uint(findLSB(near));
        vec3 light;
        float attenuation = point_light_attenuation(i, f.mean, light);
        Lobe seen = lobe;
        if (agaa_option(AGAA_LIGHT_VARIANCE)) seen = lobe_of_light(lobe, f, i, light);
        radiance += frame.point_lights[i].intensity.rgb * (attenuation * lobe_reflected(seen, light, all));
      }
    }
  }
  return max(min(radiance, vec3(kRadianceCeiling)), vec3(0.0));
}

#endif
