// A frame as it looks, and which of its draws each pixel shows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

struct FrameViewJob {
  std::filesystem::path capture;
  std::uint32_t frame = 0;
  std::uint32_t width = 0, height = 0;  // pixels; 0: as the frame was recorded
};

inline constexpr std::uint32_t kNoDraw = 0xffffffff;  // the sky is seen

struct FrameView {
  Image picture;                     // by `noaa`, display values
  std::vector<std::uint32_t> draws;  // of each pixel, row-major: the draw at its centre, by its number in the frame
  std::string device;
};

// `device` as ReplayInspection has it. Throws UsageError (frame, size), InputError (capture) and DeviceError.
FrameView view_frame(const FrameViewJob& job, const std::string& device = {});

// Values as runs: each once, with its number of repetitions behind it.
std::vector<std::uint32_t> runs_of(const std::vector<std::uint32_t>& values);

}  // namespace subpixel::replay
