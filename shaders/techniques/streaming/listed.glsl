// What streaming's passes over fragment lists share. The third word of a fragment is its mask, the fourth the samples that
// passed the depth test in their turn.
#ifndef SUBPIXEL_STREAMING_LISTED_GLSL
#define SUBPIXEL_STREAMING_LISTED_GLSL

#include "techniques/streaming/streaming_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ListedSurfaces { StreamListedSurface surface[]; };

#endif
