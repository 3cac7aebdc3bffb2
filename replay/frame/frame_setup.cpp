#include "replay/frame/frame_setup.hpp"

namespace subpixel::replay {

gpu::Constants common_constants(const FrameSetup& setup) {
  return common_constants(setup.common);
}

std::optional<FragmentLists> record_measured_lists(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                                   const std::string& name) {
  if (!setup.lists) return std::nullopt;
  return record_fragment_lists(recorder, setup, *setup.lists, name);
}

}  // namespace subpixel::replay
