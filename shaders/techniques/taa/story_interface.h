// What host and the variant of the pass agree on that tells how one pixel is accumulated.
#ifndef SUBPIXEL_TAA_STORY_INTERFACE_H
#define SUBPIXEL_TAA_STORY_INTERFACE_H

#include "taa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define TAA_SLOT_STORY 5  // storage: the header, then one TaaStory

struct TaaStory {
  // 1: there is a history; 1: its place is in the image; 1: what is seen now was open there; 1: bounds moved it
  uvec4 head;
  uvec4 front;        // the front-most pixel of 3x3; its triangle, the instance whose motion is taken
  vec4 motion;        // where the pixel was, pixels; the depth now, and the depth that it would have had
  vec4 own;           // value of this frame, compressed if it is; its share
  vec4 before;        // the history there; frames in it
  vec4 low, high;     // the bounds, YCoCg
  vec4 kept;          // the history within them
  vec4 value;         // what is stored; frames in it
  vec4 neighbourhood[9];  // YCoCg, by rows from the north-west
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
