// variants: = STORY=-DSTORY
// Computes: one turn's colour of each pixel. Each triangle that some of four samples see, the pixel's or those
// of each quarter, is shaded once, at the place of one of them (another one each turn, so that over all turns shading
// points cover what is seen of it evenly).
// Reads: the triangle seen by each sample, geometry, materials, textures, lights, shadow map.
// Writes: adds to the sums, with Kahan's compensation; STORY, what one pixel was shaded by.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;
#include "include/lights.glsl"
#include "include/material_factors.glsl"
#include "include/tone.glsl"
#include "reference/textures.glsl"

layout(constant_id = REFERENCE_CONSTANT_TONE_MAP_SAMPLES) const uint TONE_MAP_SAMPLES = 0u;
layout(constant_id = REFERENCE_CONSTANT_SHADE_ALL_SAMPLES) const uint SHADE_ALL_SAMPLES = 0u;
layout(set = 0, binding = SAMPLED(REFERENCE_SLOT_SEEN)) uniform usampler2D visibility;
#ifdef STORY
layout(set = 0, binding = STORAGE(REFERENCE_SLOT_STORY), std430) buffer Story { ReferenceStory told; };
#endif

vec3 normal_of(ReferenceTriangle t, vec3 local) {
  InstanceRecord instance = push.instances.at[t.source.y];
  vec3 normal = vec3(dot(instance.normal_row[0].xyz, local), dot(instance.normal_row[1].xyz, local),
                     dot(instance.normal_row[2].xyz, local));
  normal *= inversesqrt(max(dot(normal, normal), 1e-30));
  return (t.source.w & REFERENCE_BACK_FACE) != 0u ? -normal : normal;
}

vec4 tangent_of(ReferenceTriangle t, uvec3 vertex, vec3 weight) {
  vec4 local = weight.x * push.tangents.at[vertex.x] + weight.y * push.tangents.at[vertex.y] + weight.z * push.tangents.at[vertex.z];
  InstanceRecord instance = push.instances.at[t.source.y];
  vec4 tangent = vec4(dot(instance.world_row[0].xyz, local.xyz), dot(instance.world_row[1].xyz, local.xyz),
                      dot(instance.world_row[2].xyz, local.xyz), sign(local.w) * instance.normal_row[0].w);
  return (t.source.w & REFERENCE_BACK_FACE) != 0u ? -tangent : tangent;
}

// The radiance a triangle sends from `point`, pixels.
vec3 shade_at(uint number, vec2 point) {
  ReferenceTriangle t = push.triangles.at[number];
  uvec3 vertex = vertices_of(t);
  Weights w = weights_at(number, point);
  vec3 local_normal = w.value.x * push.normals.at[vertex.x] + w.value.y * push.normals.at[vertex.y] +
                      w.value.z * push.normals.at[vertex.z];
  MaterialTexels texel = MaterialTexels(vec4(1.0), vec2(1.0), vec3(1.0), vec3(1.0));
  const uint kTextured =
      FEATURE_BASE_TEXTURE | FEATURE_ROUGHNESS_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_EMISSIVE_TEXTURE;
  if (has_feature(kTextured)) {
    uint m = t.source.z;
    uvec4 numbers = material_textures[m];
    if (has_feature(FEATURE_BASE_TEXTURE)) texel.base_colour = texture_at(numbers.x, coordinates_of(vertex, w, m, 0u));
    if (has_feature(FEATURE_ROUGHNESS_TEXTURE))
      texel.roughness_metallic = texture_at(numbers.y, coordinates_of(vertex, w, m, 1u)).gb;
    if (has_feature(FEATURE_NORMAL_MAP)) texel.normal = texture_at(numbers.z, coordinates_of(vertex, w, m, 2u)).rgb;
    if (has_feature(FEATURE_EMISSIVE_TEXTURE))
      texel.emissive = texture_at(numbers.w, coordinates_of(vertex, w, m, 3u)).rgb;
  }
  if (has_feature(FEATURE_VERTEX_COLOUR)) texel.base_colour *= colour_of(vertex, w);
  vec4 tangent = has_feature(FEATURE_NORMAL_MAP) ? tangent_of(t, vertex, w.value) : vec4(0.0);
  Surface s;
  s.position = world_position(point, w.depth);
  apply_material(materials[t.source.z], texel, normal_of(t, local_normal), tangent, s);
  vec3 to_eye = frame.eye.xyz - s.position;
  return shade(s, to_eye * inversesqrt(max(dot(to_eye, to_eye), 1e-30)));
}

// The triangle that sample `s` of a pixel sees, plus 1; 0 for the sky.
uint seen_by(uvec2 pixel, uint s) { return texelFetch(visibility, ivec2(SIDE * pixel + cell_of(s)), 0).r; }

// The one of the samples `same` that their triangle is shaded at.
uint shaded_of(uint same) {
  uint count = uint(bitCount(same));
  uint before = min(uint(turn.choice.x * float(count)), count - 1u), found = 0u;
  for (uint s = 0u; s < SAMPLES_OF_TURN; ++s) {
    bool sees = (same >> s & 1u) != 0u;
    if (sees && before == 0u) found = s;
    if (sees) --before;  // past 0 it is 0 never again
  }
  return found;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  uvec2 size = uvec2(frame.viewport.xy);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint seen[16], remaining = 0u;
  for (uint s = 0u; s < SAMPLES_OF_TURN; ++s) {
    seen[s] = seen_by(pixel, s);
    remaining |= (seen[s] != 0u ? 1u : 0u) << s;
  }
  float sky_samples = float(int(SAMPLES_OF_TURN) - bitCount(remaining));
  vec3 radiance = frame.sky.rgb * sky_samples, display = vec3(0.0);
  if (TONE_MAP_SAMPLES != 0u) display = display_from_radiance(frame.sky.rgb) * sky_samples;
  for (uint i = 0u; i < SAMPLES_OF_TURN && remaining != 0u; ++i) {
    uint first = uint(findLSB(remaining)), number = seen_by(pixel, first), same = 0u;
    for (uint s = 0u; s < SAMPLES_OF_TURN; ++s) same |= (seen[s] == number ? 1u : 0u) << s;
    same &= 15u << (first & 12u);  // of one quarter, where there are sixteen
    if (SHADE_ALL_SAMPLES != 0u) {
      same = 1u << first;
    } else {
      first = shaded_of(same);
    }
    remaining &= ~same;
    float count = float(bitCount(same));
    vec3 shaded = shade_at(number - 1u, vec2(pixel) + sample_place(first));
#ifdef STORY
    for (bool tell = pixel == told.head.xy; tell; tell = false) {
      told.shading[told.head.z].of = uvec4(number - 1u, same, 0u, 0u);
      told.shading[told.head.z].at = vec4(sample_place(first), 0.0, 0.0);
      told.shading[told.head.z].radiance = vec4(shaded, 1.0);
      told.head.z += 1u;
    }
#endif
    radiance += count * shaded;
    if (TONE_MAP_SAMPLES != 0u) display += count * display_from_radiance(shaded);
  }
  uint place = pixel.y * size.x + pixel.x;
  vec3 sum = push.sums.at[place].rgb;
  precise vec3 term = radiance / float(SAMPLES_OF_TURN) - push.compensation.at[place].rgb;
  precise vec3 next = sum + term;
  precise vec3 lost = (next - sum) - term;
  push.sums.at[place] = vec4(next, 0.0);
  push.compensation.at[place] = vec4(lost, 0.0);
  if (TONE_MAP_SAMPLES != 0u) push.display_sums.at[place] += vec4(display / float(SAMPLES_OF_TURN), 0.0);
}
