// A list of pixels that a compute pass works through: the pixels of an image of flags, tile by tile, so that those of one
// workgroup lie together. The order and so every result is the same however the device runs the passes.
// The list's first word is its length; pixels follow as x | y << 16.
#ifndef SUBPIXEL_PIXEL_LIST_GLSL
#define SUBPIXEL_PIXEL_LIST_GLSL

#include "deferred/deferred_interface.h"

const uint kTile = 8u;             // pixels along a tile's side
const uint kPixelGroup = 64u;      // invocations of a workgroup that works through a list
const uint kRowGroups = 65535u;    // workgroups in x before y counts on: the least maximum that Vulkan requires

uint pixel_list_place(uvec3 group, uint lane) { return (group.y * kRowGroups + group.x) * kPixelGroup + lane; }

#endif
