#include "replay/single_frame.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "replay/results/limits.hpp"
#include "replay/scene/frame_points.hpp"

namespace subpixel::replay {

capture::Capture load_frames(const capture::CaptureFile& file, std::uint32_t first, std::uint32_t last,
                             std::optional<std::uint32_t> point_lights) {
  const bool placed = point_lights.value_or(0) > 0;
  return file.load(first, last, capture::CaptureFile::Triangles::lists,
                   placed ? light_stage_frames(file.frame_count()) : std::vector<std::uint32_t>{});
}

capture::Capture load_frame(const std::filesystem::path& path, std::uint32_t frame, std::uint32_t history,
                            std::optional<std::uint32_t> point_lights) {
  const capture::CaptureFile file(path);
  if (file.frame_count() == 0) throw InputError("capture", "it has no frames", path.string());
  if (frame >= file.frame_count())
    throw UsageError("frame", fmt::format("{} is not within 0-{}", frame, file.frame_count() - 1), "--frame");
  return load_frames(file, frame - std::min(history, frame), frame, point_lights);
}

FrameChoice choose_size(const capture::Capture& capture, std::uint32_t frame, std::uint32_t width, std::uint32_t height,
                        std::uint32_t limit) {
  if (width != 0) kWidthLimit.require(width);
  if (height != 0) kHeightLimit.require(height);
  const capture::Frame& recorded = capture.frames[frame];
  const FrameChoice choice{frame, width == 0 ? recorded.width : width, height == 0 ? recorded.height : height};
  if (choice.width == 0 || choice.height == 0 || choice.width > limit || choice.height > limit)
    throw DeviceError(
        "size",
        fmt::format("{}x{} is not within 1x1 and the device's {}x{}", choice.width, choice.height, limit, limit),
        "--size");
  return choice;
}

}  // namespace subpixel::replay
