// The passes of `streaming`, apart from the technique so that tests can read the state they leave.
#pragma once

#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

// Each pixel's state as in shaders/techniques/streaming/state.glsl, in one of the two: quads are layers of an RGBA32UI
// image, or lie together, pixel after pixel, row by row.
struct StreamingState {
  gpu::Image* image = nullptr;
  gpu::Buffer* words = nullptr;
};

// All passes of the technique; the state belongs to the recorder.
StreamingState record_streaming(gpu::PassRecorder& recorder, const FrameSetup& setup);

}  // namespace subpixel::replay
