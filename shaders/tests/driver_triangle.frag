#version 460
// The number of the triangle drawn. Reads: it. Writes: one 32-bit word a sample.
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint out_triangle;
void main() { out_triangle = triangle; }
