// The analysis of `sbaa` written anew for the host: which samples of a pixel are one surface, and which surfaces are
// kept.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "shaders/tests/test_interface.h"

namespace subpixel::replay::sbaa_transcription {

using Sample = gpu_types::AnalysedTestSample;

struct Options {
  bool merge = true;
  std::uint32_t keep = 4;
  double angle = 0.785;  // normals closer than this are aligned
  float cosine() const { return static_cast<float>(std::cos(angle)); }
};

// A surface as the host sees it: the samples in it, and what of its first sample decides merging.
struct HostSurface {
  std::vector<std::uint32_t> samples;
  glm::vec3 normal{0};
  float nearest = 0, farthest = 0;
  std::uint32_t mask() const {
    std::uint32_t bits = 0;
    for (const auto s : samples) bits |= 1u << s;
    return bits;
  }
};

// Fibonacci hashing to 8 bits.
inline std::uint32_t hash(std::uint32_t number) {
  return static_cast<std::uint32_t>((number * 2654435769ull & 0xffffffffull) >> 24);
}

// All surfaces of a pixel, in the order in which they are found.
inline std::vector<HostSurface> find_surfaces(const std::vector<Sample>& pixel, Options options) {
  std::vector<HostSurface> primitives;
  std::map<std::uint32_t, std::size_t> by_hash;
  for (std::uint32_t s = 0; s < pixel.size(); ++s) {
    if (pixel[s].triangle == SUBPIXEL_NO_TRIANGLE) continue;
    const auto [found, fresh] = by_hash.emplace(hash(pixel[s].triangle), primitives.size());
    if (fresh)
      primitives.push_back({{}, pixel[s].normal, pixel[s].depth + pixel[s].slope, pixel[s].depth - pixel[s].slope});
    primitives[found->second].samples.push_back(s);
  }
  std::vector<HostSurface> surfaces;
  for (const HostSurface& primitive : primitives) {
    const auto fits = [&](const HostSurface& surface) {
      float cosine = surface.normal.x * primitive.normal.x;
      cosine = cosine + surface.normal.y * primitive.normal.y;
      cosine = cosine + surface.normal.z * primitive.normal.z;
      return cosine > options.cosine() && primitive.farthest <= surface.nearest &&
             surface.farthest <= primitive.nearest;
    };
    const auto into = options.merge ? std::ranges::find_if(surfaces, fits) : surfaces.end();
    if (into == surfaces.end()) {
      surfaces.push_back(primitive);
      continue;
    }
    into->samples.insert(into->samples.end(), primitive.samples.begin(), primitive.samples.end());
    into->nearest = std::max(into->nearest, primitive.nearest);
    into->farthest = std::min(into->farthest, primitive.farthest);
  }
  return surfaces;
}

// The masks of those that are kept, most samples first, of equal ones the first found; 0 behind the last.
inline std::vector<std::uint32_t> analyse(const std::vector<Sample>& pixel, Options options) {
  std::vector<HostSurface> surfaces = find_surfaces(pixel, options);
  std::ranges::stable_sort(surfaces, [](const auto& a, const auto& b) { return a.samples.size() > b.samples.size(); });
  std::vector<std::uint32_t> masks(8, 0);
  for (std::size_t k = 0; k < std::min<std::size_t>(options.keep, surfaces.size()); ++k) masks[k] = surfaces[k].mask();
  return masks;
}

}  // namespace subpixel::replay::sbaa_transcription
