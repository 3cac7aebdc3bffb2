// Slots of the passes that gather flagged pixels in a list, and of those that store full samples in submission order.
#ifndef SUBPIXEL_DEFERRED_INTERFACE_H
#define SUBPIXEL_DEFERRED_INTERFACE_H

#include "../include/interface.h"

#define DEFERRED_CONSTANT_FIRST_LAYER 7  // of the G-buffer, which a group of samples goes to

// Storage.
#define DEFERRED_SLOT_TILE_SUMS 0
#define DEFERRED_SLOT_TILE_COUNTS 1
#define DEFERRED_SLOT_PIXEL_LIST 2  // pixel_list.glsl
#define DEFERRED_SLOT_GROUPS 3      // of an indirect dispatch
#define DEFERRED_SLOT_WRITTEN 4     // by pixel, fragments that stored some sample
// Storage images.
#define DEFERRED_SLOT_SAMPLES 0
// Sampled.
#define DEFERRED_SLOT_FLAGS 1

#endif
