#include "replay/inspection.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"

namespace subpixel::replay {

gpu::DeviceOptions device_options(const ReplayInspection& inspection) {
  gpu::DeviceOptions options;
  options.device = inspection.device;
  options.names = inspection.capture.has_value();
  options.validation_messages = inspection.validation_messages;
  return options;
}

std::optional<gpu::RenderDoc> require_render_doc(const ReplayInspection& inspection, std::uint32_t first,
                                                 std::uint32_t last, std::span<const std::string_view> techniques) {
  if (!inspection.capture) return std::nullopt;
  const auto& wanted = *inspection.capture;
  const auto refuse = [](const std::string& why) { throw UsageError("RenderDoc capture", why, "--capture-frame"); };
  if (wanted.frame < first || wanted.frame > last)
    refuse(fmt::format("frame {} is not within those replayed, {}-{}", wanted.frame, first, last));
  if (std::ranges::find(techniques, wanted.technique) == techniques.end())
    refuse(
        fmt::format("'{}' is not one of the techniques replayed, {}", wanted.technique, fmt::join(techniques, ", ")));
  auto render_doc = gpu::RenderDoc::of_process();
  if (!render_doc) refuse("subpixel does not run under RenderDoc (renderdoccmd capture -w subpixel replay ...)");
  return render_doc;
}

}  // namespace subpixel::replay
