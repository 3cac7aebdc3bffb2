// One function for each procedural scene, with the numbers that shape it. generate.hpp is the way in by name.
#pragma once

#include <cstdint>

#include "capture_format/capture.hpp"
#include "capture_format/generate/generate.hpp"

namespace subpixel::capture {

// Stand-in for the grass field of Kerzner and Salvi 2014: most blades are a pixel wide or less.
struct GrassParameters {
  std::uint32_t blades_per_patch = 40;  // times density
  std::uint32_t segments = 4;           // of a blade along its length: 2 triangles each, 1 for the tip's
  double blade_height_m = 0.42;         // 60% to 140% of it
  double blade_width_m = 0.011;         // at the root
  double view_distance_m = 36;          // where the grass ends and bare hills begin
};
Capture grass(const GenerateOptions& options, const GrassParameters& parameters = {});

// A street with window frames, ledges, balcony railings, lamp posts and wires: Crassin et al. 2016 name railings and
// Wang et al. 2015 thin window frames as their hard cases.
struct CityParameters {
  std::uint32_t buildings_per_side = 11;
  double street_width_m = 10, pavement_width_m = 3;
  double railing_bar_radius_m = 0.009;
  double wire_radius_m = 0.008;
};
Capture city(const GenerateOptions& options, const CityParameters& parameters = {});

// Scenes of a few triangles, for tests.
Capture triangle(const GenerateOptions& options);
Capture empty(const GenerateOptions& options);
Capture cube(const GenerateOptions& options);
Capture quads(const GenerateOptions& options);
Capture spheres(const GenerateOptions& options);

}  // namespace subpixel::capture
