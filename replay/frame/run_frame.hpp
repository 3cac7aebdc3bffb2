// One frame by one technique, measured: how the replay, tests and benchmarks run techniques.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "replay/frame/frame_scene.hpp"
#include "replay/frame/technique.hpp"
#include "replay/measure/image.hpp"
#include "replay/results/results.hpp"

namespace subpixel::replay {

// Prepares the front-end and counts the lists that the technique's passes go through: all that runs on the device
// before passes are recorded. `setting` and `outputs` have to outlive the result.
FrameSetup prepare_frame(FrameScene& scene, const TechniqueSetting& setting, FrameOutputs& outputs);

// A frame `steps` before `current`, of a technique that accumulates them: made current with its jitter, and how the
// scene moved since the one before it. `before`: does anything come before it?
FrameMotion move_to_step(FrameScene& scene, const TemporalParameters& parameters, std::uint32_t current,
                         std::uint32_t steps, bool before);

struct FrameImages {
  Image radiance, display;                                 // three channels: linear radiance, display values
  std::vector<float> executions;                           // lighting executions of each pixel
  std::map<std::string, std::vector<std::uint32_t>> maps;  // the technique's own, by name
};
FrameImages download_images(gpu::Device& device, const FrameOutputs& outputs);

// The times of a frame's runs, before they are summed up.
struct Runs {
  struct Pass {
    std::string name;
    std::vector<double> ms;  // of each run that counts
  };
  double cold_ms = 0;
  std::vector<Pass> passes;
  std::vector<double> processor_ms;
  std::vector<std::uint64_t> instructions;
};
Timing timing_of(const Runs& runs);

// The passes of a technique for the scene's current frame, to be run any number of times. The scene may not change
// meanwhile. Of techniques that accumulate frames, the frames before have been run, untimed, for their history.
class RecordedFrame {
 public:
  // `story`: told by the passes, too, and by story().
  RecordedFrame(FrameScene& scene, const TechniqueSetting& setting, PixelStory* story = nullptr);
  // Of what `prepare` makes, which leaves its history and whatever it sets of the scene to the caller.
  RecordedFrame(FrameScene& scene, const TechniqueSetting& setting,
                const std::function<FrameSetup(FrameOutputs&)>& prepare);
  ~RecordedFrame();
  RecordedFrame(const RecordedFrame&) = delete;
  RecordedFrame& operator=(const RecordedFrame&) = delete;

  // Runs all passes once; returns their ms.
  double run();
  // Runs them for the first time, then `repeat` times that count; the passes of a `repeat` of 0 have the first run's
  // times. `after_cold` is called between.
  Timing time(std::uint32_t repeat, const std::function<void()>& after_cold = {}) {
    return timing_of(runs(repeat, after_cold));
  }
  Runs runs(std::uint32_t repeat, const std::function<void()>& after_cold = {});

  // Of what the last run left.
  Memory memory() const;
  std::map<std::string, std::uint64_t> counters() const;
  FrameImages images() { return download_images(recorder_.device(), outputs_); }
  const FrameSetup& setup() const { return setup_; }
  const FrameOutputs& outputs() const { return outputs_; }

  // What Shading::fragments says of every pass; counted on the spot.
  std::map<std::string, std::uint64_t> count_fragments();

  // The pixel's story after a run of a frame that was recorded with one.
  nlohmann::json story();

 private:
  // A frame whose outputs the next one reads.
  struct Past {
    explicit Past(gpu::Device& device) : recorder(device) {}
    FrameOutputs outputs;
    gpu::PassRecorder recorder;
  };
  std::unique_ptr<Past> run_history();
  FrameSetup prepare();

  FrameScene& scene_;
  TechniqueSetting setting_;
  bool owns_jitter_ = true;
  std::unique_ptr<Past> past_;
  FrameOutputs outputs_;
  FrameSetup setup_;
  gpu::PassRecorder recorder_;
};

// All of it.
struct FrameRun : FrameImages {
  std::uint32_t samples = 0;  // visibility samples per pixel
  Timing ms;
  Memory memory;
  std::map<std::string, std::uint64_t> counters;
};
FrameRun run_frame(FrameScene& scene, const TechniqueSetting& setting, std::uint32_t repeat = 0);

}  // namespace subpixel::replay
