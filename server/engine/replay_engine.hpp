// Where replays run. Whoever wants captures replayed hands requests to an engine and gets, whichever it is, the same
// results with the same images in the same order; only times differ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/failure.hpp"
#include "process/child_process.hpp"
#include "replay/results/results.hpp"
#include "replay/results/worker_protocol.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// NOLINTNEXTLINE(bugprone-exception-escape): moving JSON is declared noexcept
struct ReplayRequest {
  std::string name;  // of the capture, for people
  std::string capture_hash;
  // out_dir is the engine's own while it replays; cache_dir may be replaced by one that all nodes see.
  replay::ReplayJob job;
  // What each technique of the job took over all its frames the last time; empty when that is not known.
  std::vector<double> technique_seconds;
};

// What a request came to after its results.
struct ReplayEnd {
  std::optional<replay::ResultsHead> head;
  std::string problem;          // why it is not complete; empty when it is
  int exit_code = kDeviceExit;  // what a program that can't go on for it ends with (base/failure.hpp)
};

// NOLINTNEXTLINE(bugprone-exception-escape): moving functions is declared noexcept
struct ReplaySink {
  // `request`: index into the list; `ordinal`: the technique's place in its job. Images by role.
  std::function<void(std::size_t request, std::uint32_t ordinal, replay::FrameResult result,
                     std::map<std::string, Blob> images)>
      result;
  std::function<void(std::size_t request, ReplayEnd end)> end;
  std::function<void(const std::string& line)> progress;  // one line for people; may be absent
};

class ReplayEngine {
 public:
  virtual ~ReplayEngine() = default;
  // Ends of requests come in the list's order, each after its results by frame and technique. A request that fails has
  // an end that says so. Throws what ends all of them: DeviceError, or what the sink throws.
  virtual void replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) = 0;
};

// What runs one replay in a process.
struct WorkerProgram {
  std::filesystem::path path;  // run as `path worker --job FILE`
  ChildLimits limits;
};

// One request after the other, each in a worker process of this machine.
class LocalEngine : public ReplayEngine {
 public:
  // `folder` holds the job's file while it runs.
  LocalEngine(WorkerProgram worker, std::filesystem::path folder)
      : worker_(std::move(worker)), folder_(std::move(folder)) {}
  void replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) override;

 private:
  WorkerProgram worker_;
  std::filesystem::path folder_;
};

// One job in a confined worker process.
struct WorkerEnd {
  ReplayEnd end;
  bool killed = false;  // by SIGKILL, which is never the job's own doing
};
// `take` gets each result while its files are in the job's out_dir, with the place of its technique in the job's list.
// What `take` throws of subpixel::Error ends the worker and is its problem.
WorkerEnd replay_in_worker(const replay::ReplayJob& job, const std::filesystem::path& job_file,
                           const WorkerProgram& worker,
                           const std::function<void(std::uint32_t, const replay::FrameResult&)>& take);

}  // namespace subpixel::server
