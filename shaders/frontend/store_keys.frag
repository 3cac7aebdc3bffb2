#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16
// Visibility of small triangles from keys into the image.
// Reads: keys. Writes: the attachments, as visibility.frag does.
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleKeys { uint64_t key[]; };
layout(push_constant, scalar) uniform Push {
  SampleKeys keys;
  uint width, height;
} push;
#if GROUP < 4
layout(location = 0) out uvec4 out_state;
#else
layout(location = 0) out uvec4 out_texels[GROUP / 2];
#endif

uvec2 depth_and_triangle(uint index) {
  uvec2 words = unpackUint2x32(push.keys.key[index]);
  return uvec2(words.y, ~words.x);
}

void main() {
  // Devices shade whole blocks: beyond the border, too, nothing outside the buffer may be read.
  uvec2 pixel = min(uvec2(gl_FragCoord.xy), uvec2(push.width, push.height) - 1u);
  uint base = (pixel.y * push.width + pixel.x) * GROUP;
#if GROUP == 1
  out_state = uvec4(depth_and_triangle(base), 0u, 0u);
#elif GROUP == 2
  uvec2 first = depth_and_triangle(base), second = depth_and_triangle(base + 1u);
  out_state = uvec4(first.x, second.x, first.y, second.y);
#else
  for (uint quad = 0u; quad < GROUP / 4u; ++quad) {
    uvec4 depths, triangles;
    for (uint i = 0u; i < 4u; ++i) {
      uvec2 both = depth_and_triangle(base + 4u * quad + i);
      depths[i] = both.x;
      triangles[i] = both.y;
    }
    out_texels[quad] = depths;
    out_texels[GROUP / 4 + quad] = triangles;
  }
#endif
}
