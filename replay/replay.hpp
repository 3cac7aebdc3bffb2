// A capture in, measured frames out: the whole run, for the command line and for worker processes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/results/results.hpp"
#include "replay/results/worker_protocol.hpp"

namespace subpixel::replay {

struct ReplayEvents {
  std::function<void(const std::string& stage, std::uint32_t done, std::uint32_t total, const std::string& detail)>
      progress;
  std::function<void(const ResultsHead&)> head;  // before the first result and, with the wall times, after the last
  // Its images are files in the job's out_dir, complete. `ordinal`: of its technique in the job's list.
  std::function<void(std::uint32_t ordinal, const FrameResult&)> result;
};

// What lets one see inside a replay. None of it changes a result but the device.
struct ReplayInspection {
  std::string device;  // gpu::DeviceOptions::device
  // Takes what the Vulkan validation layer says, as gpu::Instance puts it, until the replay has ended.
  std::vector<std::string>* validation_messages = nullptr;
  // RenderDoc captures one more run of this technique's passes on this frame, after the timed ones, into out_dir.
  struct Captured {
    std::uint32_t frame = 0;
    std::string technique;
  };
  std::optional<Captured> capture;
};

// Replays every frame asked for through every technique. Each result's images: "image" and "reference" (PNG), "hdr"
// and "reference_hdr" (EXR, linear), "error" and "shading" (PNG maps) and the technique's own maps by name; of each map
// NAME also its numbers, "NAME_values" (EXR), and those of FLIP, "flip_values". Throws UsageError (technique,
// parameter, frame, size; an inspection of what is not replayed or without RenderDoc), InputError (capture, full disk)
// and DeviceError.
Results run_replay(const ReplayJob& job, const ReplayEvents& events, const ReplayInspection& inspection = {});

}  // namespace subpixel::replay
