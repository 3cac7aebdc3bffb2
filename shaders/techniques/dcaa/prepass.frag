#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: OPAQUE= ALPHA=-DWITH_UV
// The z-prepass (Wang et al. 2015, section 4.2): a plane of depth for each pixel that no visible sample lies behind.
// Conservative by construction: fragments are gathered until together they cover every sample; what they cover then is no
// farther than a plane below them all (after masked occlusion culling: Hasselgren, Andersson and Akenine-Moller 2016).
// Reads and writes: the attachments, in primitive order. First: the bound's z, dz/dx, dz/dy (reversed depth, 0 at first), z of
// the plane below the fragments being gathered. Second: its slopes, then their samples.
#include "techniques/dcaa/fragment_mask.glsl"
#include "techniques/dcaa/depth_bound.glsl"

layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in_bound;
layout(input_attachment_index = 1, set = 0, binding = INPUT_ATTACHMENT(1)) uniform usubpassInput in_gathered;
layout(location = 0) out uvec4 out_bound;
layout(location = 1) out uvec4 out_gathered;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  vec3 own = farthest_plane(fragment_depth(pixel));
  uvec4 state = subpassLoad(in_bound);
  vec3 bound = uintBitsToFloat(state.xyz);
  bool changes = false;
  for (bool helps = own.x > bound.x; helps; helps = false) {
    PixelEdges edges = fragment_edges(pixel);
    uvec2 mask = fragment_coverage(edges);
#ifdef WITH_UV
    for (bool any_sample = mask != uvec2(0u); any_sample; any_sample = false)
      mask = alpha_coverage(mask, pixel, mask_shading_offset(edges, mask));
#endif
    changes = mask != uvec2(0u);
    for (bool go = changes; go; go = false) {
      uvec4 more = subpassLoad(in_gathered);
      DepthBound b = DepthBound(bound, uintBitsToFloat(uvec3(state.w, more.xy)), more.zw);
      gather_bound(b, own, mask, kWholePixel);
      out_bound = floatBitsToUint(vec4(b.bound, b.gathered.x));
      out_gathered = uvec4(floatBitsToUint(b.gathered.yz), b.samples);
    }
  }
  if (!changes) discard;
}
