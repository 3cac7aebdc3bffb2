#include "replay/frontend/list_passes.hpp"

#include <algorithm>
#include <array>
#include <thread>

#include "shaders/frontend/frontend_interface.h"

namespace subpixel::replay {

std::uint32_t groups_of(std::uint64_t items) {
  return static_cast<std::uint32_t>((items + 63) / 64);
}

std::array<std::uint32_t, 3> grid_of(std::uint64_t items) {
  const std::uint32_t groups = groups_of(items), row = std::clamp(groups, 1u, kMostGroups);
  return {row, (groups + row - 1) / row, 1};
}

std::array<std::uint32_t, 3> dealt_grid_of(std::uint64_t items) {
  const std::uint32_t groups = std::max(groups_of(items), 1u), threads = std::thread::hardware_concurrency();
  const std::uint32_t rows = std::max(std::clamp(threads, 1u, 64u), (groups + kMostGroups - 1) / kMostGroups);
  return {(groups + rows - 1) / rows, rows, 1};
}

bool runs_long_loops(gpu::Device& device) {
  gpu::PassRecorder recorder(device);
  gpu::Buffer& turns = recorder.buffer("turns", 4 * sizeof(std::uint32_t));
  constexpr std::uint32_t kWanted = 1'000'000;
  std::ranges::copy(std::array<std::uint32_t, 4>{kWanted, 0, 1, 1}, turns.as<std::uint32_t>().begin());
  gpu::ComputePass pass;
  pass.name = "turns";
  pass.shader = "frontend/count_turns.comp";
  pass.bindings = {gpu::writes(FRONTEND_SLOT_TURNS, turns)};
  recorder.compute(std::move(pass));
  recorder.run();
  return turns.as<std::uint32_t>()[1] == kWanted;
}

void record_scan(gpu::PassRecorder& recorder, const std::string& name, gpu::Buffer& sums, std::uint32_t count) {
  gpu::ComputePass scan;
  scan.name = name;
  scan.shader = "frontend/scan.comp";
  scan.bindings = {gpu::writes(FRONTEND_SLOT_SUMS, sums)};
  scan.push = gpu::PushConstants(gpu_types::ScanPush{count});
  recorder.compute(std::move(scan));
}

void record_bases(gpu::PassRecorder& recorder, const std::string& name, gpu::Buffer& numbers, gpu::Buffer& sums,
                  std::uint32_t count) {
  const std::uint32_t groups = groups_of(count);
  const gpu_types::PixelBasesPush range{groups, count};
  gpu::ComputePass pass;
  pass.name = name;
  pass.bindings = {gpu::writes(FRONTEND_SLOT_ITEMS, numbers), gpu::writes(FRONTEND_SLOT_SUMS, sums)};
  pass.push = gpu::PushConstants(range);
  pass.groups = {groups_of(groups), 1, 1};
  pass.shader = "frontend/pixel_bases.comp:SUM";
  recorder.compute(pass);
  record_scan(recorder, name, sums, groups);
  pass.shader = "frontend/pixel_bases.comp:BASE";
  recorder.compute(pass);
}

}  // namespace subpixel::replay
