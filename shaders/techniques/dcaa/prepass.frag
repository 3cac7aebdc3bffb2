#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: OPAQUE= ALPHA=-DWITH_UV
// The z-prepass (Wang et al. 2015, section 4.2): a depth for each pixel that no visible sample lies behind. Conservative by
// construction: fragments are gathered until together they cover every sample; what they cover then is no farther than the
// farthest of them (after masked occlusion culling: Hasselgren, Andersson and Akenine-Moller 2016).
// Reads and writes: the attachment, in primitive order. x: the bound, reversed depth, 0 at first. y: farthest depth of the
// fragments being gathered, zw: their samples.
#include "techniques/dcaa/fragment_mask.glsl"

layout(input_attachment_index = 0, set = 0, binding = 24) uniform usubpassInput in_bound;
layout(location = 0) out uvec4 out_bound;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  DepthPlane plane = fragment_depth(pixel);
  // Rounding of the plane's sums moves depths by less than this.
  float farthest = pixel_depths(plane).x * (1.0 - 1.0 / 1048576.0);
  uvec4 state = subpassLoad(in_bound);
  bool helps = farthest > uintBitsToFloat(state.x);
  bool changes = false;
  for (bool go = helps; go; go = false) {
    PixelEdges edges = fragment_edges(pixel);
    uvec2 mask = fragment_coverage(edges);
#ifdef WITH_UV
    for (bool any_sample = mask != uvec2(0u); any_sample; any_sample = false)
      mask = alpha_coverage(mask, pixel, mask_shading_offset(edges, mask));
#endif
    changes = mask != uvec2(0u);
    float bound = uintBitsToFloat(state.x), gathered = uintBitsToFloat(state.y);
    bool none = state.zw == uvec2(0u);
    // A fragment far in front of what is gathered starts anew: it would lose its depth by joining.
    bool joins = state.zw != uvec2(0u) && farthest - gathered <= gathered - bound;
    uvec2 samples = joins ? state.zw | mask : mask;
    float depth = joins ? min(gathered, farthest) : farthest;
    // A whole pixel stands for itself; what was gathered stays if it is nearer.
    bool whole = mask == kWholePixel, complete = samples == kWholePixel;
    bound = whole ? farthest : complete ? depth : bound;
    bool keeps = whole && gathered > farthest;
    state.x = floatBitsToUint(bound);
    state.y = floatBitsToUint(whole ? gathered : depth);
    state.zw = keeps ? state.zw : whole || complete ? uvec2(0u) : samples;
    out_bound = state;
  }
  if (!changes) discard;
}
