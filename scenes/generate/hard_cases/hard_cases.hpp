// The hard cases: small captures that break one thing each, with what must come out. A frame is a few thousand pixels;
// sizes in the scenes are in pixels of the frame asked for, so a case stays as hard at any size.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "capture_format/capture.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::capture {

struct HardCase {
  std::string_view name, description;  // each one line
  std::string_view expectation;        // what every working technique shows
  Capture (*make)(const GenerateOptions&);
  std::uint32_t width = 64, height = 48;  // pixels, unless asked for otherwise
};

// In the order they are listed to users.
std::span<const HardCase> hard_cases();
// One frame of it at its own size.
Capture make_case(const HardCase& hard);

// Edges and coverage.
Capture hard_slivers(const GenerateOptions& options);
Capture hard_subpixel(const GenerateOptions& options);
Capture hard_shared_edges(const GenerateOptions& options);
Capture hard_t_junctions(const GenerateOptions& options);
Capture hard_fullscreen(const GenerateOptions& options);

// Positions and depths.
Capture hard_near_plane(const GenerateOptions& options);
Capture hard_grazing(const GenerateOptions& options);
Capture hard_coplanar(const GenerateOptions& options);
Capture hard_interpenetrating(const GenerateOptions& options);
Capture hard_depth_range(const GenerateOptions& options);
Capture hard_bad_vertices(const GenerateOptions& options);
Capture hard_far_origin(const GenerateOptions& options);

// How far hard_far_origin lies along x: a power of two, so that moving it back is exact.
inline constexpr double kFarOrigin = 1048576;

// Surfaces and light.
Capture hard_opposite_normals(const GenerateOptions& options);
Capture hard_roughness(const GenerateOptions& options);
Capture hard_overflow(const GenerateOptions& options);
Capture hard_alpha_foliage(const GenerateOptions& options);
Capture hard_bright_light(const GenerateOptions& options);
Capture hard_emissive_only(const GenerateOptions& options);
Capture hard_many_lights(const GenerateOptions& options);

// The papers' own failures: Crassin et al. 2016, figure 17; Wang et al. 2015, figure 10. Figure 8 of Kerzner and Salvi
// 2014 is streaming_angle.
Capture hard_shadow_albedo(const GenerateOptions& options);
Capture hard_hairs(const GenerateOptions& options);
Capture hard_railings(const GenerateOptions& options);
Capture hard_blurred_texture(const GenerateOptions& options);
Capture hard_small_angle(const GenerateOptions& options);
Capture hard_window_frame(const GenerateOptions& options);

}  // namespace subpixel::capture
