// What a technique gets for one frame, and what it leaves.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "replay/frame/common_parameters.hpp"
#include "replay/frontend/fragment_lists.hpp"
#include "replay/scene/motion.hpp"

namespace subpixel::replay {

class PixelStory;

// Images the technique allocated from its recorder and filled.
struct FrameOutputs {
  gpu::Image* radiance = nullptr;  // RGBA32F: rgb linear radiance, a lighting executions of the pixel
  gpu::Image* display = nullptr;   // RGBA32F: rgb display values in [0, 1]
  // Further maps by the name of their MapDescription: R32_UINT, one value a pixel.
  std::vector<std::pair<std::string, gpu::Image*>> maps;
  // What the passes of the next frame read, of techniques that accumulate frames.
  std::vector<gpu::Image*> history;
  // Counters filled by the technique's host steps while the passes run: of what they drew; of the frame, whatever rows
  // of it were drawn; and numbers of records, of which the counter of that name is how many there are.
  std::map<std::string, std::uint64_t> counters, frame_counters;
  std::map<std::string, std::vector<bool>> records;
};

struct FrameSetup : FrontendFrame {
  FrameSetup(const FrontendFrame& frame, const CommonParameters& parameters, FrameOutputs& frame_outputs)
      : FrontendFrame(frame),
        scene(frame.frontend.scene()),
        common(parameters),
        outputs(frame_outputs),
        samples(parameters.samples) {}

  // Rows of the frame, of which `height` may be a part.
  std::uint32_t frame_height() const { return static_cast<std::uint32_t>(scene.constants().viewport.y); }

  GpuScene& scene;
  const CommonParameters& common;  // of the technique's own type
  FrameOutputs& outputs;
  const std::uint32_t samples;
  // Of techniques that go through lists of fragments, where this frame has them.
  std::optional<FragmentListSizes> lists;
  // Of techniques that accumulate frames: what the frame before left, nothing for the first one, and how the scene
  // moved since.
  std::vector<gpu::Image*> history;
  std::optional<FrameMotion> motion;
  // Of frames of which a pixel's story is told: what techniques add theirs to.
  PixelStory* story = nullptr;
};

// The same for a technique whose parameters are `P`. Throws std::bad_cast when they are another's.
template <typename P>
struct SetupFor : FrameSetup {
  explicit SetupFor(const FrameSetup& setup) : FrameSetup(setup), parameters(dynamic_cast<const P&>(setup.common)) {}

  const P& parameters;
};

// Specialization constants of what all techniques let one choose.
gpu::Constants common_constants(const FrameSetup& setup);

// Set-up, visibility and the measured lists of what it shows, passes "setup", "visibility" and "list". The technique's
// `lists` is `visible`.
struct VisibleFragments {
  gpu::Image* visibility = nullptr;
  FragmentLists lists;
};
VisibleFragments record_visible(gpu::PassRecorder& recorder, const FrameSetup& setup);

// The lists that were measured for the frame, passes `name`; none where none were.
std::optional<FragmentLists> record_measured_lists(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                                   const std::string& name);

}  // namespace subpixel::replay
