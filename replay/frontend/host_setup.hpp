// Set-up of a frame's triangles on the threads of the host: what setup.comp and clip.comp do, to the same bits where
// the device is lavapipe (tests/technique/host_setup_test.cpp). For devices without doubles, and for CPU devices, which
// read by address lane by lane or set up triangles in full that a branch leaves out here (docs/performance.md).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "shaders/frontend/frontend_types.h"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// What set-up reads, as setup.comp does.
struct HostSetupInput {
  const gpu_types::FrameConstants& frame;
  std::uint32_t samples = 8;  // of a pixel: 1, 2, 4, 8, 16, 32 or 64
  std::span<const gpu_types::ChunkRecord> chunks;
  std::span<const glm::vec3> positions;
  std::span<const std::uint32_t> indices;
  std::span<const glm::mat4> clip_matrices;
  std::span<const gpu_types::InstanceRecord> instances;
};

// Fills `counts`, SUBPIXEL_CHUNK_TRIANGLES for each chunk, with COUNT_ bits, and the slots among `records` of whole
// triangles that are drawn; leaves the others. Returns the slots of triangles that cross a clip plane, in ascending
// order.
std::vector<std::uint32_t> set_up_on_host(const HostSetupInput& input, std::span<gpu_types::TriangleRecord> records,
                                          std::span<std::uint32_t> counts);

// Fills `pieces` with the records of those triangles' pieces; those of `slot` begin at `piece_bases[slot]`. What is
// past the end is left out.
void emit_pieces_on_host(const HostSetupInput& input, std::span<const std::uint32_t> clipped,
                         std::span<const std::uint32_t> piece_bases, std::span<gpu_types::TriangleRecord> pieces);

}  // namespace subpixel::replay
