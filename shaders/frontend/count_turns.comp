#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// How many turns of a loop a shader makes of those it is asked for: some drivers end loops early, without a word.
// Reads: ones, turns wanted. Writes: turns made.
layout(local_size_x = 1) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_TURNS), scalar) buffer Turns {
  uint wanted, made;
  uint ones[2];  // what the compiler can't know to be 1
};

void main() {
  uint x = 1u, count = 0u;
  for (uint i = 0u; i < wanted; ++i) {
    x = x * 1664525u + 1013904223u;
    count += ones[x >> 31];
  }
  made = count;
}
