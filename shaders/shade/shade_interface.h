// Slots of the passes that light full G-buffer samples and resolve their sum.
#ifndef SUBPIXEL_SHADE_INTERFACE_H
#define SUBPIXEL_SHADE_INTERFACE_H

#include "../include/interface.h"

// Sampled.
#define SHADE_SLOT_GBUFFER 1  // a layer for each sample
#define SHADE_SLOT_SUM 2

#endif
