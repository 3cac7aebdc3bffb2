// Face normals as the clustering sees them: two bytes of spherical coordinates (AGAA paper, section 3.2).
// The paper encodes the visible hemisphere. Under perspective that is a hemisphere around the direction to the eye, which
// turns by half the field of view across the screen, so the polar angle reaches beyond a right angle by that much.
// Reads and writes: nothing.
#ifndef SUBPIXEL_AGAA_FACE_NORMAL_GLSL
#define SUBPIXEL_AGAA_FACE_NORMAL_GLSL

const float kFullTurn = 6.28318530718;

// Polar angle from +z in the low byte, [0, largest_polar] in 255 steps; azimuth in 256 steps.
uvec2 face_code(vec3 normal, float largest_polar) {
  float polar = acos(clamp(normal.z, -1.0, 1.0));
  float azimuth = (abs(normal.x) + abs(normal.y)) > 0.0 ? atan(normal.y, normal.x) : 0.0;
  return uvec2(uint(clamp(polar / largest_polar, 0.0, 1.0) * 255.0 + 0.5),
               uint(floor((azimuth / kFullTurn + 1.0) * 256.0 + 0.5)) & 255u);
}

vec3 decoded_face(uvec2 code, float largest_polar) {
  float polar = float(code.x) * (largest_polar / 255.0);
  float azimuth = float(code.y) * (kFullTurn / 256.0);
  return vec3(sin(polar) * vec2(cos(azimuth), sin(azimuth)), cos(polar));
}

#endif
