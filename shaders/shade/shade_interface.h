// Slots and constants of the passes that light full G-buffer samples or visible fragments and resolve their sums.
#ifndef SUBPIXEL_SHADE_INTERFACE_H
#define SUBPIXEL_SHADE_INTERFACE_H

#include "../include/interface.h"

// Sampled.
#define SHADE_SLOT_GBUFFER 1  // a layer for each sample
#define SHADE_SLOT_SUM 2

// Storage image.
#define SHADE_SLOT_SUM_IMAGE 0

#define SHADE_CONSTANT_POINT 7  // SHADE_POINT_, where a visible fragment is lit within its pixel

#define SHADE_POINT_COVERED 0u  // the centre if the triangle covers it, else the centroid of the samples it covers
#define SHADE_POINT_VISIBLE 1u  // the centre if all samples show it, else the centroid of those that do

#endif
