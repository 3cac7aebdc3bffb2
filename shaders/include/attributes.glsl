// Perspective-correct interpolation over a triangle given by its homogeneous corners, and its analytic derivatives.
// Works for corners behind the eye, since nothing is divided by w before the interpolation (Olano and Greer 1997).
// Reads: nothing.
#ifndef SUBPIXEL_ATTRIBUTES_GLSL
#define SUBPIXEL_ATTRIBUTES_GLSL

struct Weights {
  vec3 value, dx, dy;  // of the three corners; derivatives per pixel
};

// Of each corner, the area of the triangle that `point` makes with the other two, twice and times all three w: linear in
// the point, as is 1 / w, to which their sum is proportional. Derivatives per pixel are those in all of the plane.
struct CornerAreas {
  vec3 value, dx, dy;
};

// Corners as (x w, y w, w) with x and y in pixels; `point` in pixels.
CornerAreas corner_areas(vec3 c0, vec3 c1, vec3 c2, vec2 point) {
  vec2 p0 = c0.xy - point * c0.z, p1 = c1.xy - point * c1.z, p2 = c2.xy - point * c2.z;
  CornerAreas a;
  a.value = vec3(p1.x * p2.y - p1.y * p2.x, p2.x * p0.y - p2.y * p0.x, p0.x * p1.y - p0.y * p1.x);
  a.dx = vec3(p1.y * c2.z - c1.z * p2.y, p2.y * c0.z - c2.z * p0.y, p0.y * c1.z - c0.z * p1.y);
  a.dy = vec3(c1.z * p2.x - p1.x * c2.z, c2.z * p0.x - p2.x * c0.z, c0.z * p1.x - p0.x * c1.z);
  return a;
}

// Corners and point as corner_areas() has them. Weights are not negative and add up to 1: a point that rounding puts
// outside is pulled onto the triangle, so attributes are never extrapolated.
Weights interpolation_weights(vec3 c0, vec3 c1, vec3 c2, vec2 point) {
  CornerAreas a = corner_areas(c0, c1, c2, point);
  float sum = a.value.x + a.value.y + a.value.z;
  float inverse = sum != 0.0 ? 1.0 / sum : 0.0;
  Weights w;
  w.value = max(a.value * inverse, 0.0);
  float total = w.value.x + w.value.y + w.value.z;
  w.value = total > 0.0 ? w.value / total : vec3(1.0 / 3.0);
  w.dx = clamp((a.dx - w.value * (a.dx.x + a.dx.y + a.dx.z)) * inverse, -1e4, 1e4);
  w.dy = clamp((a.dy - w.value * (a.dy.x + a.dy.y + a.dy.z)) * inverse, -1e4, 1e4);
  return w;
}

vec2 interpolate(vec3 weight, vec2 a, vec2 b, vec2 c) { return weight.x * a + weight.y * b + weight.z * c; }
vec3 interpolate(vec3 weight, vec3 a, vec3 b, vec3 c) { return weight.x * a + weight.y * b + weight.z * c; }
vec4 interpolate(vec3 weight, vec4 a, vec4 b, vec4 c) { return weight.x * a + weight.y * b + weight.z * c; }

#endif
