#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY MAPS=-DMAPS
// Adds a frame to what was accumulated before it, at the place where the pixel's surface was then.
// Karis 2014, "High-quality temporal supersampling"; Salvi 2016, "An excursion in temporal supersampling" (bounds of
// variance); Yang, Liu and Salvi 2020, "A survey of temporal antialiasing techniques".
// Reads: visibility; the pixels' resolvable values; triangle records; matrices of motion; history and depth before.
// Writes: linear radiance with the lighting executions in a; display values; history, a the frames in it; depth. MAPS, in
// their place: one where the history was rejected; how far bounds moved it, in 255ths.
#include "include/resolve.glsl"
#include "include/visibility.glsl"
#include "techniques/taa/taa_interface.h"

layout(buffer_reference, scalar) readonly buffer TaaRecords { TriangleRecord of[]; };
layout(set = 0, binding = SAMPLED(TAA_SLOT_VALUES)) uniform sampler2D values;
layout(set = 0, binding = SAMPLED(TAA_SLOT_HISTORY)) uniform sampler2D history;
layout(set = 0, binding = SAMPLED(TAA_SLOT_DEPTH_BEFORE)) uniform sampler2D depth_before;
layout(set = 0, binding = STORAGE(TAA_SLOT_MOTION), scalar) readonly buffer Motion { mat4 motion[]; };
layout(push_constant, scalar) uniform Push { TaaPush push; };

#ifdef MAPS
layout(location = 0) out uint out_rejected;
layout(location = 1) out uint out_clipped;
#else
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;
layout(location = 2) out vec4 out_history;
layout(location = 3) out float out_depth;
#endif

#include "techniques/taa/story.glsl"

const vec3 LUMA = vec3(0.2126, 0.7152, 0.0722);
const float MOST_LUMA = 0.99999;

ivec2 within(ivec2 p) { return clamp(p, ivec2(0), textureSize(values, 0) - 1); }
// Of the frame, whose history is whole where frames are drawn in bands.
ivec2 within_history(ivec2 p) { return clamp(p, ivec2(0), ivec2(frame.viewport.xy) - 1); }

// Karis: bright values weigh less, as if after a tone curve that can be undone. Tone-mapped values need no other.
bool compresses() { return push.compress != 0u && RESOLVE_TONE_MAPPED == 0u; }
vec3 compressed(vec3 value) { return compresses() ? value / (1.0 + dot(value, LUMA) * frame.tone.x) : value; }
vec3 decompressed(vec3 value) {
  return compresses() ? value / (1.0 - min(dot(value, LUMA) * frame.tone.x, MOST_LUMA)) : value;
}

vec3 value_at(ivec2 p) { return compressed(texelFetch(values, within(p), 0).rgb); }

vec3 ycocg(vec3 c) {
  return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}
vec3 rgb(vec3 c) { return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z); }

// The surface whose motion the pixel has: the front-most of 3x3, so that outlines move with what they belong to (Karis).
struct Mover {
  ivec2 pixel;
  float depth;
  uint triangle;
};
Mover front_most(ivec2 p) {
  uvec2 own = visible_sample(p);
  Mover front = Mover(p, uintBitsToFloat(own.x), own.y);
  for (int k = 0; k < 9; ++k) {
    ivec2 q = within(p + ivec2(k % 3 - 1, k / 3 - 1));
    uvec2 found = visible_sample(q);
    float depth = uintBitsToFloat(found.x);
    if (found.y != SUBPIXEL_NO_TRIANGLE && (front.triangle == SUBPIXEL_NO_TRIANGLE || depth > front.depth))
      front = Mover(q, depth, found.y);
  }
  return front;
}

float distance_of(float depth) {
  vec4 d = push.distance_before;
  float w = d.z * depth + d.w;
  return (d.x * depth + d.y) / (abs(w) < 1e-12 ? 1e-12 : w);
}

// Of Catmull and Rom 1974, for the texels -1 to 2.
vec4 cubic(float t) {
  return vec4(((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0, ((-1.5 * t + 2.0) * t + 0.5) * t,
              (0.5 * t - 0.5) * t * t);
}

// History at `position`, pixels; a of the nearest texel.
vec4 history_at(vec2 position) {
  ivec2 low = ivec2(floor(position - 0.5));
  vec2 t = position - 0.5 - vec2(low);
  vec4 across = push.reading == TAA_CATMULL_ROM ? cubic(t.x) : vec4(0.0, 1.0 - t.x, t.x, 0.0);
  vec4 down = push.reading == TAA_CATMULL_ROM ? cubic(t.y) : vec4(0.0, 1.0 - t.y, t.y, 0.0);
  vec3 sum = vec3(0.0);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      sum += across[x] * down[y] * texelFetch(history, within_history(low + ivec2(x, y) - 1), 0).rgb;
  return vec4(max(sum, vec3(0.0)), texelFetch(history, within_history(ivec2(floor(position))), 0).a);
}

// Could what is now in front be seen there, or did something nearer hide it? Any of 3x3 texels may show it, since
// samples move within their pixels, and one that shows something farther hides nothing.
bool was_open(vec2 position, bool sky, float expected) {
  ivec2 at = ivec2(floor(position));
  float own = distance_of(expected), least = own - push.depth_tolerance * abs(own);
  bool found = push.depth_test == 0u;
  for (int k = 0; k < 9 && !found; ++k) {
    float depth = texelFetch(depth_before, within_history(at + ivec2(k % 3 - 1, k / 3 - 1)), 0).r;
    found = depth == 0.0 || (!sky && distance_of(depth) >= least);
  }
  return found;
}

// The history brought into the box of the neighbourhood's colours.
vec3 bounded(ivec2 p, vec3 before) {
  if (push.bounds == TAA_BOUNDS_NONE) return before;
  vec3 low = vec3(1e30), high = vec3(-1e30), sum = vec3(0.0), squares = vec3(0.0);
  for (int k = 0; k < 9; ++k) {
    vec3 colour = ycocg(value_at(p + ivec2(k % 3 - 1, k / 3 - 1)));
    low = min(low, colour);
    high = max(high, colour);
    sum += colour;
    squares += colour * colour;
    TELL(tell_neighbour(k, colour);)
  }
  if (push.bounds == TAA_BOUNDS_VARIANCE) {
    vec3 mean = sum / 9.0;
    vec3 reach = push.deviations * sqrt(max(squares / 9.0 - mean * mean, vec3(0.0)));
    low = mean - reach;
    high = mean + reach;
  }
  vec3 colour = ycocg(before), inside = clamp(colour, low, high);
  TELL(tell_bounds(low, high, inside != colour);)
  if (inside == colour) return before;
  if (push.bounds != TAA_BOUNDS_CLAMP) {
    // Towards the middle of the box, until it is reached.
    vec3 middle = 0.5 * (low + high), way = colour - middle, half_size = 0.5 * (high - low);
    vec3 lengths = abs(way) / max(half_size, vec3(1e-7));
    inside = middle + way / max(max(lengths.x, max(lengths.y, lengths.z)), 1.0);
  }
  return max(rgb(inside), vec3(0.0));
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec2 size = frame.viewport.xy;
  vec4 own = texelFetch(values, p, 0);
  vec3 value = compressed(own.rgb);
  float frames = 1.0;
  uint rejected = 0u, moved = 0u;
  TELL(tell_begin(); float share = 1.0;)
  if (push.has_history != 0u) {
    Mover front = front_most(p);
    bool sky = front.triangle == SUBPIXEL_NO_TRIANGLE;
    uint instance = push.still;
    if (!sky) instance = push.records.of[front.triangle].hull2_id.w;
    vec2 ndc = (vec2(frame_pixel(front.pixel)) + 0.5) / size * 2.0 - 1.0;
    vec4 change = motion[instance] * vec4(ndc, front.depth, 1.0);
    float w = 1.0 + change.w;
    vec2 centre = ndc + push.unjitter;
    vec2 came_from = vec2(frame_pixel(p)) + 0.5 + (w > 0.0 ? (change.xy - centre * change.w) / w * 0.5 * size : size * 2.0);
    bool inside = all(greaterThanEqual(came_from, vec2(0.0))) && all(lessThan(came_from, size));
    TELL(tell_motion(front.pixel, front.triangle, instance, front.depth, came_from, (front.depth + change.z) / w,
                     inside);)
    if (inside && was_open(came_from, sky, (front.depth + change.z) / w)) {
      vec4 before = history_at(came_from);
      vec3 kept = bounded(p, before.rgb);
      moved = uint(min(length(ycocg(kept) - ycocg(before.rgb)), 1.0) * 255.0 + 0.5);
      frames = min(before.a + 1.0, 1024.0);
      float alpha = push.progressive != 0u ? max(push.alpha, 1.0 / frames) : push.alpha;
      TELL(tell_history(before, kept); share = alpha;)
      value = kept + alpha * (value - kept);
    } else {
      rejected = 1u;
    }
  }
  TELL(tell_value(compressed(own.rgb), share, value, frames);)
#ifdef MAPS
  out_rejected = rejected;
  out_clipped = moved;
#else
  vec3 radiance = resolved_radiance(decompressed(value));
  out_radiance = vec4(radiance, own.a);
  out_display = vec4(display_from_radiance(radiance), 1.0);
  out_history = vec4(value, frames);
  uvec2 here = visible_sample(p);
  out_depth = here.y == SUBPIXEL_NO_TRIANGLE ? 0.0 : max(uintBitsToFloat(here.x), 1e-30);
#endif
}
