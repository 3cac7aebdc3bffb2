// What the passes over fragment lists share. A fragment's masks are 0 until some pass has made them; its record has a bit set once
// it is kept, and all bits when it covers nothing.
#ifndef SUBPIXEL_DCAA_LISTED_GLSL
#define SUBPIXEL_DCAA_LISTED_GLSL

#include "techniques/dcaa/dcaa_interface.h"

const uint kKept = 0x80000000u, kNothing = 0xffffffffu;

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer ListedSurfaces { DcaaListedSurface surface[]; };

#endif
