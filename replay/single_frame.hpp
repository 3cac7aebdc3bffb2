// One frame of a capture at a size, for whoever looks into it and measures nothing.
#pragma once

#include <cstdint>
#include <filesystem>

#include "capture_format/capture.hpp"
#include "replay/frame/frame_scene.hpp"

namespace subpixel::replay {

// `frame` with as many before it as `history` says and there are. Throws UsageError when it is not there, InputError
// when the capture can't be read or has no frames.
capture::Capture load_frame(const std::filesystem::path& file, std::uint32_t frame, std::uint32_t history = 0);

// The frame at `width` x `height` pixels, 0: as it was recorded. Throws UsageError for what no frame may have and
// DeviceError for what is above `limit`, the device's.
FrameChoice choose_size(const capture::Capture& capture, std::uint32_t frame, std::uint32_t width, std::uint32_t height,
                        std::uint32_t limit);

}  // namespace subpixel::replay
