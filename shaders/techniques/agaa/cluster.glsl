// Which samples of a pixel make an aggregate: algorithm 1 of the AGAA paper with the distance of its equation 1.
// The including shader defines SAMPLES (4 to 32), AGGREGATES (1 to 4) and the function declared here, which tells about one
// pixel.
// Reads and writes: nothing else.
#ifndef SUBPIXEL_AGAA_CLUSTER_GLSL
#define SUBPIXEL_AGAA_CLUSTER_GLSL

struct ClusterSample {
  vec3 position;  // in characteristic lengths k
  vec3 normal;    // unit
};
ClusterSample cluster_sample(uint s);  // asked of every sample; of one that shows the sky, anything finite

struct Clusters {
  uint low, high;  // bits 0 and 1 of every sample's aggregate, sample s in bit s
  uint count;      // aggregates
};

// Equation 1. Each product and sum rounded, in this order: the decision is the same wherever it is computed.
float cluster_distance(ClusterSample a, vec3 position, vec3 normal) {
  precise vec3 away = a.position - position;
  precise float d = away.x * away.x;
  d = d + away.y * away.y;
  d = d + away.z * away.z;
  precise float c = a.normal.x * normal.x;
  c = c + a.normal.y * normal.y;
  c = c + a.normal.z * normal.z;
  precise float turned = (1.0 - c) * 0.5;
  d = d + turned;
  return d;
}

#include "techniques/agaa/cluster_story.glsl"

// `covered`: samples that show a surface. The first aggregate grows around the sample farthest from the mean, each further one
// around the sample with the largest sum of distances to those before, as long as one lies more than `separation` from all
// of them. Of equal distances the first sample, of equally near aggregates the first one is taken.
Clusters cluster_pixel(uint covered, float separation) {
  ClusterSample s[SAMPLES];
  float sums[SAMPLES], nearest[SAMPLES];
  precise vec3 position = vec3(0.0), normal = vec3(0.0);
  precise float count = 0.0;
  for (uint i = 0u; i < SAMPLES; ++i) {
    bool here = (covered & (1u << i)) != 0u;
    s[i] = cluster_sample(i);
    position = position + (here ? s[i].position : vec3(0.0));
    normal = normal + (here ? s[i].normal : vec3(0.0));
    count = count + (here ? 1.0 : 0.0);
  }
  position = position / max(count, 1.0);
  // The mean of opposite normals has no direction: every sample is then turned from it by the same.
  precise float square = normal.x * normal.x;
  square = square + normal.y * normal.y;
  square = square + normal.z * normal.z;
  normal = square > 1e-12 ? normal / sqrt(square) : vec3(0.0);
  TELL_MEAN(s, position, normal);

  float best = -1.0;
  ClusterSample seed = s[0];
  for (uint i = 0u; i < SAMPLES; ++i) {
    float d = cluster_distance(s[i], position, normal);
    bool farther = (covered & (1u << i)) != 0u && d > best;
    best = farther ? d : best;
    seed.position = farther ? s[i].position : seed.position;
    seed.normal = farther ? s[i].normal : seed.normal;
  }
  TELL_SEED(0u, seed, best, s);
  for (uint i = 0u; i < SAMPLES; ++i) {
    sums[i] = cluster_distance(s[i], seed.position, seed.normal);
    nearest[i] = sums[i];
  }
  Clusters clusters = Clusters(0u, 0u, covered != 0u ? 1u : 0u);
  for (uint a = 1u; a < AGGREGATES; ++a) {
    best = -1.0;
    for (uint i = 0u; i < SAMPLES; ++i) {
      bool farther = (covered & (1u << i)) != 0u && nearest[i] > separation && sums[i] > best;
      best = farther ? sums[i] : best;
      seed.position = farther ? s[i].position : seed.position;
      seed.normal = farther ? s[i].normal : seed.normal;
    }
    TELL_SEED(a, seed, best, s);
    uint closer = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) {
      float d = cluster_distance(s[i], seed.position, seed.normal);
      closer |= d < nearest[i] ? 1u << i : 0u;
      precise float sum = sums[i] + d;
      sums[i] = sum;
      nearest[i] = min(nearest[i], d);
    }
    closer = best >= 0.0 ? closer & covered : 0u;
    clusters.count += best >= 0.0 ? 1u : 0u;
    clusters.low = (a & 1u) != 0u ? clusters.low | closer : clusters.low & ~closer;
    clusters.high = (a & 2u) != 0u ? clusters.high | closer : clusters.high & ~closer;
  }
  TELL_CLUSTERS(covered, clusters);
  return clusters;
}

#endif
