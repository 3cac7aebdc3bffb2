// One function for each procedural scene, with the numbers that shape it. generate.hpp is the way in by name.
#pragma once

#include <cstdint>

#include "capture_format/capture.hpp"
#include "scenes/generate/generate.hpp"

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

// A ball of fur: fibres of about half a pixel that hide each other, AGAA's correlated normals at their worst.
struct FurParameters {
  std::uint32_t clumps = 2100;  // times density
  std::uint32_t fibres_per_clump = 10;
  std::uint32_t segments = 3;  // of a fibre, each a prism of three sides
  double length_m = 0.32;      // the ball's radius is 1 m
  double radius_m = 0.0022;    // at the root
};
Capture fur(const GenerateOptions& options, const FurParameters& parameters = {});

// A tangle of bent metal tubes over a floor: smooth highlights, silhouettes over silhouettes. Wang et al. 2015 have
// such a scene in their tentacles.
struct TubesParameters {
  std::uint32_t tubes = 110;  // times density
  std::uint32_t rings = 64;   // along a tube
  std::uint32_t sides = 12;
};
Capture tubes(const GenerateOptions& options, const TubesParameters& parameters = {});

// A bamboo grove with branches and modelled leaves, after the bamboo scene of Wang et al. 2015.
struct BambooParameters {
  std::uint32_t stalks = 170;  // times density
  std::uint32_t leaves_per_stalk = 260;
};
Capture bamboo(const GenerateOptions& options, const BambooParameters& parameters = {});

// Trees whose leaves are alpha-tested cards: coverage that a texture decides.
struct FoliageParameters {
  std::uint32_t trees = 26;
  std::uint32_t cards_per_tree = 3600;  // times density
};
Capture foliage(const GenerateOptions& options, const FoliageParameters& parameters = {});

// A hall of columns and arches in brick and stone with a gallery, lamps on chains: architecture as in Sponza, where
// most pixels are plain and few are complex.
struct ArcadeParameters {
  std::uint32_t bays = 9;  // of 4 m along the hall
  std::uint32_t column_sides = 28;
};
Capture arcade(const GenerateOptions& options, const ArcadeParameters& parameters = {});

// The inside of a power plant, after that of Kerzner and Salvi 2014: pipes of all diameters, many of them parallel and
// about a pixel wide, railings, ladders and grated walkways before and behind each other.
struct PlantParameters {
  std::uint32_t pipes = 240;  // with bends, valves and flanges, times density
  std::uint32_t racks = 22;   // of five to twelve parallel pipes, times density
};
Capture plant(const GenerateOptions& options, const PlantParameters& parameters = {});

// The inside of a small cathedral, after the Sibenik model of Wang et al. 2015: columns, ribs, mouldings and steps in
// textured stone, of which little is smaller than a pixel.
struct CathedralParameters {
  std::uint32_t bays = 7;  // from the entrance to the apse
  std::uint32_t column_sides = 32;
};
Capture cathedral(const GenerateOptions& options, const CathedralParameters& parameters = {});

// Scenes of a few triangles, for tests.
Capture triangle(const GenerateOptions& options);
Capture empty(const GenerateOptions& options);
Capture cube(const GenerateOptions& options);
Capture quads(const GenerateOptions& options);
Capture spheres(const GenerateOptions& options);

// Where the merge metric of Kerzner and Salvi 2014 needs its conditions (figure 3) and where it fails (figure 8).
Capture streaming_normals(const GenerateOptions& options);
Capture streaming_depth(const GenerateOptions& options);
Capture streaming_coverage(const GenerateOptions& options);
Capture streaming_angle(const GenerateOptions& options);

// Where filtering over an aggregate fails, by its authors: Crassin et al. 2016, figure 17.
Capture agaa_correlation(const GenerateOptions& options);
Capture agaa_hairs(const GenerateOptions& options);
Capture agaa_railings(const GenerateOptions& options);

}  // namespace subpixel::capture
