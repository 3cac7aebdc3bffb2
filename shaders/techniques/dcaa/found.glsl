// Where examine.frag leaves what it finds: four words a pixel, row by row.
#ifndef SUBPIXEL_DCAA_FOUND_GLSL
#define SUBPIXEL_DCAA_FOUND_GLSL

#include "include/frame.glsl"
#include "techniques/dcaa/dcaa_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer FoundWords { uint word[]; };
layout(set = 0, binding = STORAGE(DCAA_SLOT_FOUND), scalar) readonly buffer Found { FoundWords words; } found;

uint found_word(ivec2 pixel) { return 4u * (uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)); }

#endif
