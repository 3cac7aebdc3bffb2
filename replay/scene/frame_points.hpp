// Points of what a frame draws, by number: where lights may be placed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/scene/geometry.hpp"
#include "replay/scene/lights.hpp"

namespace subpixel::replay {

// The frames of so many that placed lights are shared by: up to eight, spread evenly. All of a capture's are placed for
// the same ones, whichever frames are drawn, so that a frame has its lights whatever is drawn with it.
std::vector<std::uint32_t> light_stage_frames(std::size_t frame_count);

// The stage of one frame: its points are the triangles' centroids, all instances included. `plan`, `positions` and
// `indices` must outlive it.
LightStage light_stage(const capture::Capture& capture, std::uint32_t frame, const GeometryPlan& plan,
                       std::span<const float> positions, std::span<const std::uint32_t> indices);

}  // namespace subpixel::replay
