#include "replay/frame/frame_setup.hpp"

#include "replay/frontend/visibility.hpp"

namespace subpixel::replay {

gpu::Constants common_constants(const FrameSetup& setup) {
  return common_constants(setup.common);
}

std::optional<FragmentLists> record_measured_lists(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                                   const std::string& name) {
  if (!setup.lists) return std::nullopt;
  setup.outputs.counters["listed_fragments"] = setup.lists->kept;
  return record_fragment_lists(recorder, setup, *setup.lists, name);
}

VisibleFragments record_visible(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, setup);
  setup.outputs.counters["listed_fragments"] = setup.lists.value().kept;
  return {&visibility, record_visible_fragments(recorder, setup, visibility, *setup.lists, "list")};
}

}  // namespace subpixel::replay
