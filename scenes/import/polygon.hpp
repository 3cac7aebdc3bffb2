// Triangles of a polygon that may be concave and need not be quite flat.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace subpixel::capture {

// Ear clipping looks at every pair of corners of a concave polygon.
inline constexpr std::size_t kMaxConcaveCorners = 10000;

// Appends the corner numbers of count - 2 triangles that turn as the polygon does. Convex ones become a fan about
// their first corner, a concave quadrilateral one about its inward corner; others lose one ear after another (Meisters
// 1975) in the plane of Newell's normal. A polygon that crosses itself gets some triangles. False, with nothing
// appended, when it is concave and has more than kMaxConcaveCorners.
bool triangulate(std::span<const glm::dvec3> polygon, std::vector<std::uint32_t>& triangles);

}  // namespace subpixel::capture
