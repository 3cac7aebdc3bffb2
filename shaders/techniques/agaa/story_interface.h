// What host and the passes agree on that tell how one pixel's aggregates come to be.
#ifndef SUBPIXEL_AGAA_STORY_INTERFACE_H
#define SUBPIXEL_AGAA_STORY_INTERFACE_H

#include "agaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define AGAA_SLOT_STORY 5  // storage: the header, then AgaaDefinition of define.frag or AgaaPart of add.comp
#define AGAA_STORY_WORDS 28

// How the samples were told apart. Positions in characteristic lengths, view space.
struct AgaaDefinition {
  uvec4 head;                           // samples that show a surface, bits 0 and 1 of their aggregates, aggregates
  vec4 mean_position, mean_normal;      // of those samples
  vec4 position[32];                    // of each sample; its distance from the mean
  vec4 normal[32];                      // of each sample
  vec4 distance[32];                    // of each sample from each seed
  // Of each aggregate the sample that it grows around, and that sample's distance from the mean or the sum of its
  // distances from the seeds before; below 0 where there is none.
  vec4 seed_position[AGAA_MAX_AGGREGATES];
  vec4 seed_normal[AGAA_MAX_AGGREGATES];
};

// What a fragment adds to an aggregate, or all that is added to one.
struct AgaaPart {
  uvec4 head;         // aggregate, samples, 1: of a fragment
  vec4 normal;        // mean; roughness
  vec4 diffuse;       // mean
  vec4 reflectance;   // mean, at normal incidence
  vec4 emissive;      // mean
  uint words[AGAA_STORY_WORDS];  // as they are added up
};

#ifdef __cplusplus
static_assert(sizeof(AgaaPart) == 5 * 16 + 4 * AGAA_STORY_WORDS);
}  // namespace subpixel::gpu_types
#endif
#endif
