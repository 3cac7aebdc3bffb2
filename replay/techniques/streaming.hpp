// The passes of `streaming`, apart from the technique so that tests can read the state they leave.
#pragma once

#include "replay/techniques/ordered_state.hpp"

namespace subpixel::replay {

// All passes of the technique. The state, of words as shaders/techniques/streaming/state.glsl has them, belongs to the
// recorder.
OrderedState record_streaming(gpu::PassRecorder& recorder, const FrameSetup& setup);

}  // namespace subpixel::replay
