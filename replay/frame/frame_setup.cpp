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

double fitted_surface_bits(SceneFeatures features) {
  double bits = 24 + 32;  // albedo, normal
  if (features.has(FEATURE_METAL)) bits += 8;
  if (features.has(FEATURE_VARYING_ROUGHNESS)) bits += 8;
  if (features.has(FEATURE_EMISSIVE)) bits += 32;
  return bits;
}

}  // namespace subpixel::replay
