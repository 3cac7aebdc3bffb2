// How the clustering tells what it does: with STORY that of the story's pixel goes into a log.
// Reads and writes: the log.
#ifdef STORY
#include "techniques/agaa/story_interface.h"

layout(set = 0, binding = STORAGE(AGAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, definitions
  AgaaDefinition definition;
};

bool is_told() { return ivec2(gl_FragCoord.xy) == ivec2(told.xy); }

void tell_mean(ClusterSample s[SAMPLES], vec3 position, vec3 normal) {
  for (bool tell = is_told(); tell; tell = false) {
    definition.mean_position = vec4(position, 0.0);
    definition.mean_normal = vec4(normal, 0.0);
    for (uint i = 0u; i < SAMPLES; ++i) {
      definition.position[i] = vec4(s[i].position, cluster_distance(s[i], position, normal));
      definition.normal[i] = vec4(s[i].normal, 0.0);
    }
  }
}

void tell_seed(uint aggregate, ClusterSample seed, float largest, ClusterSample s[SAMPLES]) {
  for (bool tell = is_told(); tell; tell = false) {
    definition.seed_position[aggregate] = vec4(seed.position, largest);
    definition.seed_normal[aggregate] = vec4(seed.normal, 0.0);
    for (uint i = 0u; i < SAMPLES; ++i)
      definition.distance[i][aggregate] = cluster_distance(s[i], seed.position, seed.normal);
  }
}

void tell_clusters(uint covered, Clusters clusters) {
  for (bool tell = is_told(); tell; tell = false) {
    definition.head = uvec4(covered, clusters.low, clusters.high, clusters.count);
    told.z = 1u;
  }
}
#define TELL_MEAN(s, position, normal) tell_mean(s, position, normal)
#define TELL_SEED(aggregate, seed, largest, s) tell_seed(aggregate, seed, largest, s)
#define TELL_CLUSTERS(covered, clusters) tell_clusters(covered, clusters)
#else
#define TELL_MEAN(s, position, normal)
#define TELL_SEED(aggregate, seed, largest, s)
#define TELL_CLUSTERS(covered, clusters)
#endif
