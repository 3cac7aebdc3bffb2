#version 460
// Stands in for shade/resolve.frag as an edit of it would: every pixel is red.
// Reads: nothing. Writes: as that one.
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

void main() {
  out_radiance = out_display = vec4(1.0, 0.0, 0.0, 1.0);
}
