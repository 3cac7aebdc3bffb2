// What visibility_unordered.frag finds: a word for each sample of a group, pixel after pixel.
#ifndef SUBPIXEL_NEAREST_WORDS_GLSL
#define SUBPIXEL_NEAREST_WORDS_GLSL

#include "frontend/frontend_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer NearestWords { uint word[]; };

#endif
