// The radiance a surface sends to the eye: sun with shadow map, point lights, ambient, emission.
// Reads: frame constants; the shadow map, when the scene has shadows; of point lights, their cells and cones.
// Returns linear radiance, finite and not negative for every finite surface; a normal of no length is lit as if it
// faced the viewer, other values are clamped as brdf.glsl says.
#ifndef SUBPIXEL_LIGHTS_GLSL
#define SUBPIXEL_LIGHTS_GLSL

#include "include/frame.glsl"
#include "include/brdf.glsl"

layout(set = 0, binding = SAMPLED(FRAME_SLOT_SHADOW_MAP)) uniform sampler2D shadow_map;
layout(set = 0, binding = STORAGE(FRAME_SLOT_SPOT_CONES), std430) readonly buffer SpotCones { SpotConeConstants spot_cones[]; };
layout(set = 0, binding = STORAGE(FRAME_SLOT_LIGHT_CELLS), std430) readonly buffer LightCells { uint light_cells[]; };

// Below this fraction of its range a point light gets no brighter.
const float kInnermostFraction = 0.01;
const float kRadianceCeiling = 60000.0;  // stays finite in half floats

// Texels around a point that its filter and its lift may need: a point nearer to a cascade's border uses the next one.
const float kShadowMargin = 8.0;

// The cascade that decides at `point` of the sun's view, with `side` texels along a cascade.
vec4 shadow_cascade(vec3 point, float side, out vec2 quadrant) {
  vec4 cascade = frame.shadow_cascades[SUBPIXEL_SHADOW_CASCADES - 1];
  quadrant = vec2(1.0);
  for (int c = SUBPIXEL_SHADOW_CASCADES - 2; c >= 0; --c) {
    vec4 nearer = frame.shadow_cascades[c];
    vec2 from_centre = abs(point.xy * nearer.x + nearer.yz - 0.5);
    bool inside = max(from_centre.x, from_centre.y) < 0.5 - kShadowMargin / side;
    cascade = inside ? nearer : cascade;
    quadrant = inside ? vec2(c & 1, c >> 1) : quadrant;
  }
  return cascade;
}

// The lit fraction of the 3x3 texels around a point, borders weighted by overlap: a box filter that moves smoothly.
// The point is lifted along its normal by the filter's reach times the sine of the sun's angle, plus a little.
float sun_visibility(vec3 position, vec3 normal, float normal_light) {
  vec3 point = (frame.shadow_matrix * vec4(position, 1.0)).xyz;
  float side = 0.5 * float(textureSize(shadow_map, 0).x);  // texels of a cascade
  vec2 quadrant;
  vec4 cascade = shadow_cascade(point, side, quadrant);
  float lift = cascade.w * (0.5 + 2.5 * sqrt(max(1.0 - normal_light * normal_light, 0.0)));
  point += (frame.shadow_matrix * vec4(normal * lift, 0.0)).xyz;
  vec2 local = point.xy * cascade.x + cascade.yz;
  bool covered = all(greaterThanEqual(local, vec2(0.0))) && all(lessThanEqual(local, vec2(1.0)));
  // Far outside is lit anyway; gathers want finite coordinates, and none of another cascade.
  local = clamp(local, 2.0 / side, 1.0 - 2.0 / side);
  vec2 texel = (local + quadrant) * side - 0.5;
  vec2 corner = floor(texel);
  vec2 f = texel - corner;
  // Gathers return the 2x2 texels around a corner they share, counter-clockwise from (0, 1).
  float unit = 0.5 / side;
  vec2 base = corner * unit;
  vec4 g00 = textureGather(shadow_map, base);
  vec4 g20 = textureGather(shadow_map, base + vec2(2.0 * unit, 0.0));
  vec4 g02 = textureGather(shadow_map, base + vec2(0.0, 2.0 * unit));
  vec4 g22 = textureGather(shadow_map, base + vec2(2.0 * unit));
  float z = min(point.z - cascade.w * frame.sun_direction.w, 1.0);
  vec4 lit00 = vec4(lessThanEqual(vec4(z), g00)), lit20 = vec4(lessThanEqual(vec4(z), g20));
  vec4 lit02 = vec4(lessThanEqual(vec4(z), g02)), lit22 = vec4(lessThanEqual(vec4(z), g22));
  vec4 row0 = vec4(lit00.wz, lit20.wz), row1 = vec4(lit00.xy, lit20.xy);
  vec4 row2 = vec4(lit02.wz, lit22.wz), row3 = vec4(lit02.xy, lit22.xy);
  vec4 across = vec4(1.0 - f.x, 1.0, 1.0, f.x);
  float sum = dot(row0 * (1.0 - f.y) + row1 + row2 + row3 * f.y, across);
  return covered ? sum * (1.0 / 9.0) : 1.0;
}

// The first word of the lights that may reach `position` (replay/scene/light_cells.hpp); a word has 32 of them.
uint light_cell(vec3 position) {
  LightCellConstants cells = frame.light_cells;
  vec4 point = vec4(position, 1.0);
  float depth = max(dot(cells.rows[2], point), 1.17549435e-38);
  vec2 tile = vec2(dot(cells.rows[0], point), dot(cells.rows[1], point)) / depth;
  tile = max(min(floor(tile), cells.tiles.xy), vec2(0.0));
  uint slice = min(uint(max(int(floatBitsToUint(depth) >> LIGHT_SLICE_SHIFT) - int(cells.slices.x), 0)), cells.slices.y);
  // Drivers convert lane by lane: an integer below 2^23 added to it stands in a float's low bits.
  uint in_slice = floatBitsToUint(tile.y * cells.tiles.z + tile.x + 8388608.0) & 0x7fffffu;
  return (slice * cells.slices.w + in_slice) * cells.slices.z;
}

// Irradiance per intensity of point light i at `position`; `light`: the unit vector towards it.
float point_light_attenuation(uint i, vec3 position, out vec3 light) {
  vec4 position_range = frame.point_lights[i].position_range;
  float inverse_range_squared = frame.point_lights[i].intensity.w;
  vec3 to_light = position_range.xyz - position;
  float distance_squared = dot(to_light, to_light);
  float inverse = inversesqrt(max(distance_squared, 1e-20));
  light = to_light * inverse;
  float x = distance_squared * inverse_range_squared;  // (distance / range)^2
  float window = max(1.0 - x * x, 0.0);
  float ceiling = inverse_range_squared * (1.0 / (kInnermostFraction * kInnermostFraction));
  float attenuation = window * window * min(inverse * inverse, ceiling);
  if (has_feature(FEATURE_SPOT_LIGHTS)) {
    vec4 plane = spot_cones[i].plane;
    float inside = clamp(plane.w - dot(plane.xyz, light), 0.0, 1.0);
    attenuation *= inside * inside;
  }
  return attenuation;
}

// Radiance towards the eye along `view_direction`, the unit vector from the surface to the eye.
vec3 shade(Surface s, vec3 view_direction) {
  float length_squared = dot(s.normal, s.normal);
  bool usable = length_squared > 1e-12 && length_squared < 1e12;
  s.normal = usable ? s.normal * inversesqrt(length_squared) : view_direction;
  Brdf b = prepare_brdf(s, view_direction);
  vec3 radiance = frame.ambient.rgb * b.ambient * s.occlusion;
  if (has_feature(FEATURE_EMISSIVE)) radiance += s.emissive;
  if (has_feature(FEATURE_SUN)) {
    vec3 light = -frame.sun_direction.xyz;
    float normal_light = clamp(dot(s.normal, light), 0.0, 1.0);
    vec3 sun = frame.sun_irradiance.rgb * reflected(b, light, normal_light);
    if (has_feature(FEATURE_SHADOWS)) sun *= sun_visibility(s.position, s.normal, normal_light);
    radiance += sun;
  }
  if (has_feature(FEATURE_POINT_LIGHTS)) {
    uint cell = light_cell(s.position);
    for (uint word = 0u; word < frame.light_cells.slices.z; ++word) {
      for (uint near = light_cells[cell + word]; near != 0u; near &= near - 1u) {
        uint i = word * 32u + uint(findLSB(near));
        vec3 light;
        float attenuation = point_light_attenuation(i, s.position, light);
        radiance += frame.point_lights[i].intensity.rgb *
                    (attenuation * reflected(b, light, clamp(dot(s.normal, light), 0.0, 1.0)));
      }
    }
  }
  // min and max return the other operand for a NaN, so what an infinite position could make ends here.
  return max(min(radiance, vec3(kRadianceCeiling)), vec3(0.0));
}

#endif
