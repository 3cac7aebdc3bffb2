// ReplayInspection on the device.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "replay/gpu/device.hpp"
#include "replay/gpu/renderdoc.hpp"
#include "replay/replay.hpp"

namespace subpixel::replay {

gpu::DeviceOptions device_options(const ReplayInspection& inspection);

// RenderDoc, when something is to be captured. Throws UsageError when that is not among the frames `first` to `last`
// or the `techniques`, or when the process does not run under RenderDoc.
std::optional<gpu::RenderDoc> require_render_doc(const ReplayInspection& inspection, std::uint32_t first,
                                                 std::uint32_t last, std::span<const std::string_view> techniques);

}  // namespace subpixel::replay
