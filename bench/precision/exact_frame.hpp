// A frame in float64 on the host: coverage of 8 samples, depth planes, surfaces and their lighting. Slow, simple and
// apart from the shaders; textures and shadows are left out, since formats are compared and not scenes.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::precision {

inline constexpr std::uint32_t kSamples = 8;

struct ExactSurface {
  glm::dvec3 position, normal, albedo, emissive;
  double metallic = 0, roughness = 1;
  bool unlit = false;
};

// What one triangle leaves in a pixel.
struct ExactFragment {
  ExactSurface surface;  // at the pixel's centre when it is covered, else at the middle of the covered samples
  glm::dvec2 at;         // that point, pixels from the pixel's centre
  double depth = 0, depth_at = 0;  // reversed depth at the pixel's centre and at `at`
  glm::dvec2 slope;                // of the reversed depth, per pixel
  std::uint32_t mask = 0;
};

class ExactFrame {
 public:
  // Frame 0. Triangles that reach behind the eye are left out.
  ExactFrame(const capture::Capture& capture, std::uint32_t width, std::uint32_t height);

  std::uint32_t width, height;
  std::vector<std::vector<ExactFragment>> pixels;
  glm::dvec3 sky;

  // The world position of a point of the window, in pixels, at a reversed depth.
  glm::dvec3 world(const glm::dvec2& window, double depth) const;
  // The distance along the view at a reversed depth, and back; 0 under a parallel projection.
  double distance(const glm::dvec2& window, double depth) const;
  double depth_of_distance(const glm::dvec2& window, double distance) const;
  bool perspective() const { return row_.z != 0; }
  double near_plane() const { return near_; }
  // Linear radiance towards the eye: shaders/include/lights.glsl and brdf.glsl (GGX) without shadows.
  glm::dvec3 shade(const ExactSurface& surface) const;

  // Reversed depth of a fragment at a sample.
  static double depth_at_sample(const ExactFragment& fragment, std::uint32_t sample);
  static glm::dvec2 sample_offset(std::uint32_t sample);  // pixels from the centre

  // Display value of linear radiance: shaders/include/tone.glsl.
  glm::dvec3 display(const glm::dvec3& radiance) const;

 private:
  const capture::Frame& frame_;
  glm::dmat4 inverse_;
  glm::dvec4 row_;  // 1 / distance of (x, y, z, 1) in normalized coordinates
  glm::dvec3 eye_;
  double near_ = 0;
};

}  // namespace subpixel::precision
