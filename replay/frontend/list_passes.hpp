// What the passes that make lists by pixel or by block of pixels share.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "replay/gpu/pass_recorder.hpp"

namespace subpixel::replay {

// Workgroups that a device takes in each dimension: Vulkan's required limit.
inline constexpr std::uint32_t kMostGroups = 65535;
// Workgroups of 64 for `items`.
std::uint32_t groups_of(std::uint64_t items);
// The same in rows of at most so many, for any number of items.
std::array<std::uint32_t, 3> grid_of(std::uint64_t items);

// The same dealt out to the device's threads, a row for each and more where rows are full (dealt_item() of
// small_walk.glsl).
std::array<std::uint32_t, 3> dealt_grid_of(std::uint64_t items);

// Does the device run loops as long as they are? Mesa 22.3 ends them after 65,535 turns, all of an invocation together.
// A run on the spot tells.
bool runs_long_loops(gpu::Device& device);

// Replaces x of the first `count` elements (uvec4) of `sums` by the sum of those before; the total goes to
// sums[count].x, and so for y, z and w.
void record_scan(gpu::PassRecorder& recorder, const std::string& name, gpu::Buffer& sums, std::uint32_t count);

// Replaces the `count` numbers (32 bits) by the sum of those before each. `sums`: 16 bytes for each 64 of them, and 16
// more.
void record_bases(gpu::PassRecorder& recorder, const std::string& name, gpu::Buffer& numbers, gpu::Buffer& sums,
                  std::uint32_t count);

}  // namespace subpixel::replay
