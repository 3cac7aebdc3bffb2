// Where techniques whose pixels merge fragments in submission order keep what they know of a pixel: 32-bit words, four
// of them a quad, in colour attachments or in a buffer. Included by host and shaders.
#ifndef SUBPIXEL_ORDERED_STATE_H
#define SUBPIXEL_ORDERED_STATE_H

#include "interface.h"

// Passes that read the state, and those that write it in a buffer.
#define ORDERED_SLOT_ADDRESS 0  // storage: the address of the quads, pixel after pixel, row by row
#define ORDERED_SLOT_ATTACHMENTS 0  // sampled: the attachments, a layer each
// Attachments of one ordered pass. Vulkan requires 4; devices that run us have 8.
#define ORDERED_FEWEST_ATTACHMENTS 3
#define ORDERED_MOST_ATTACHMENTS 8

#define ORDERED_QUADS_OF(words) (((words) + 3u) / 4u)

BUFFER_REFERENCE(StateQuads)

#endif
