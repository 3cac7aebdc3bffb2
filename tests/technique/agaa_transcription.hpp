// Algorithm 1 of Crassin et al. 2016 written anew for the host: which samples of a pixel make an aggregate.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace subpixel::replay::agaa_transcription {

struct Given {
  glm::vec3 position, normal;
};
static_assert(sizeof(Given) == 24);

// Equation 1 with positions in characteristic lengths.
inline float distance(const Given& a, const glm::vec3& position, const glm::vec3& normal) {
  const glm::vec3 d = a.position - position;
  const float apart = d.x * d.x + d.y * d.y + d.z * d.z;
  const float cosine = a.normal.x * normal.x + a.normal.y * normal.y + a.normal.z * normal.z;
  return apart + (1.0f - cosine) * 0.5f;
}
inline float distance(const Given& a, const Given& b) {
  return distance(a, b.position, b.normal);
}

// For each sample its aggregate; none where it isn't covered.
struct Aggregates {
  std::vector<std::optional<std::size_t>> of;
  std::vector<std::size_t> seeds;
  std::size_t count = 0;
};

inline Aggregates paper_aggregates(const std::vector<Given>& samples, std::uint32_t covered, std::size_t most,
                                   float separation) {
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (covered >> i & 1u) seen.push_back(i);
  Aggregates result;
  result.of.resize(samples.size());
  if (seen.empty()) return result;
  // 1 (b): average position and normal.
  glm::vec3 position(0), normal(0);
  for (const std::size_t i : seen) {
    position += samples[i].position;
    normal += samples[i].normal;
  }
  position /= static_cast<float>(seen.size());
  const float square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
  normal = square > 1e-12f ? normal / std::sqrt(square) : glm::vec3(0);
  // 1 (c): the sample farthest from the average.
  std::vector<std::size_t> seeds{
      *std::ranges::max_element(seen, {}, [&](std::size_t i) { return distance(samples[i], position, normal); })};
  // 1 (d) and (e): the largest sum of distances, of those far enough from all seeds.
  while (seeds.size() < most) {
    std::optional<std::size_t> next;
    float largest = -1;
    for (const std::size_t i : seen) {
      float sum = 0;
      bool separate = true;
      for (const std::size_t seed : seeds) {
        sum += distance(samples[i], samples[seed]);
        separate = separate && distance(samples[i], samples[seed]) > separation;
      }
      if (separate && sum > largest) {
        largest = sum;
        next = i;
      }
    }
    if (!next) break;
    seeds.push_back(*next);
  }
  // 2: every sample to the closest.
  for (const std::size_t i : seen) {
    std::size_t closest = 0;
    for (std::size_t a = 1; a < seeds.size(); ++a)
      if (distance(samples[i], samples[seeds[a]]) < distance(samples[i], samples[seeds[closest]])) closest = a;
    result.of[i] = closest;
  }
  result.count = seeds.size();
  result.seeds = seeds;
  return result;
}

}  // namespace subpixel::replay::agaa_transcription
