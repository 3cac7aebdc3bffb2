// The frame's constants and the scene's features, shared by all passes.
// Reads: the uniform buffer, FEATURES.
// Needs `#extension GL_GOOGLE_include_directive : require` in the including shader, as all files of this folder do.
#ifndef SUBPIXEL_FRAME_GLSL
#define SUBPIXEL_FRAME_GLSL

#include "include/interface.h"
#include "include/shared_types.h"

layout(constant_id = CONSTANT_FEATURES) const uint FEATURES = 0xffffffffu;

layout(set = 0, binding = UNIFORM_BINDING, std140) uniform FrameBlock { FrameConstants frame; };

bool has_feature(uint feature) { return (FEATURES & feature) != 0u; }

// A frame may be drawn in bands of rows, each with images and buffers of its own. Pixels are the band's, and so are
// triangle records; where floats are made of pixels they are the frame's, so that bands change no bit.
ivec2 band_size() { return ivec2(int(frame.viewport.x), int(frame.band.y)); }
ivec2 frame_pixel(ivec2 pixel) { return ivec2(pixel.x, pixel.y + int(frame.band.x)); }

// World position of a point of the frame: `pixel_position` in pixels from the top left corner (the centre of pixel
// (x, y) is (x + 0.5, y + 0.5)), `depth` reversed. Depth 0 of an infinite projection is far away, not infinite.
vec3 world_position(vec2 pixel_position, float depth) {
  vec2 ndc = pixel_position * frame.viewport.zw * 2.0 - 1.0;
  vec4 world = frame.inverse_view_projection * vec4(ndc, depth, 1.0);
  return world.xyz / (abs(world.w) < 1e-12 ? 1e-12 : world.w);
}

#endif
