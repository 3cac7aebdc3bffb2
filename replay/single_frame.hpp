// Frames of a capture's file; one of them at a size, for whoever looks into it and measures nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "capture_format/reading/capture_file.hpp"
#include "replay/frame/frame_scene.hpp"

namespace subpixel::replay {

// Frames `first` to `last` of a file, and where `point_lights` asks for lights that are placed, those that all of the
// capture's frames share them with (light_stage_frames()). Throws InputError as CaptureFile::load() does.
capture::Capture load_frames(const capture::CaptureFile& file, std::uint32_t first, std::uint32_t last,
                             std::optional<std::uint32_t> point_lights);

// `frame` with as many before it as `history` says and there are. Throws UsageError when it is not there, InputError
// when the capture can't be read or has no frames.
capture::Capture load_frame(const std::filesystem::path& file, std::uint32_t frame, std::uint32_t history = 0,
                            std::optional<std::uint32_t> point_lights = std::nullopt);

// The frame at `width` x `height` pixels, 0: as it was recorded. Throws UsageError for what no frame may have and
// DeviceError for what is above `limit`, the device's.
FrameChoice choose_size(const capture::Capture& capture, std::uint32_t frame, std::uint32_t width, std::uint32_t height,
                        std::uint32_t limit);

}  // namespace subpixel::replay
