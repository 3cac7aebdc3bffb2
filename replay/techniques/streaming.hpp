// The passes of `streaming`, apart from the technique so that tests can read the state they leave.
#pragma once

#include <numbers>

#include "replay/frame/technique.hpp"
#include "replay/techniques/ordered_state.hpp"

namespace subpixel::replay {

enum class StreamingWeight { equal, coverage };
enum class StreamingOcclusion { intervals, depth_test };
enum class StreamingDiscard { uncovered, resolved };
enum class StreamingDepth { view, clip };

struct StreamingParameters : OrderedParameters {
  std::uint32_t surfaces = 3;
  double normal_angle = std::numbers::pi / 4;
  bool merge_normals = true, merge_depth = true, merge_coverage = true;
  StreamingWeight merge_weight = StreamingWeight::equal;
  StreamingOcclusion occlusion = StreamingOcclusion::intervals;
  StreamingDiscard discard = StreamingDiscard::uncovered;
  StreamingDepth depth_space = StreamingDepth::view;
};
using StreamingSetup = SetupFor<StreamingParameters>;

// All passes of the technique. The state, of words as shaders/techniques/streaming/state.glsl has them, belongs to the
// recorder.
OrderedState record_streaming(gpu::PassRecorder& recorder, const StreamingSetup& setup);

}  // namespace subpixel::replay
