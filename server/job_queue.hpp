// Takes queued runs from the store and has each replayed by a worker process, confined to the run's capture, a folder
// of its own and the cache. A worker that hangs, reports an error or writes garbage ends its run with a reason; one
// that dies by a signal is started again as often as the run allows. Runs that this process leaves unfinished, however
// it ends, are taken up by the next one. Whoever goes on with a run is told to skip what is stored.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "process/child_process.hpp"
#include "server/run_events.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

struct WorkerOptions {
  std::filesystem::path program;  // run as `program worker --job FILE` and `program info FILE --json`
  std::uint32_t count = 1;        // runs at a time
  ChildLimits limits;
  std::vector<std::string> readable;  // files and folders that every worker may read, drivers outside of /usr
};

// What a process that is to read and write these may do besides.
Confinement confined(const WorkerOptions& worker, const std::vector<std::filesystem::path>& readable,
                     const std::vector<std::filesystem::path>& writable);

class JobQueue {
 public:
  // All arguments outlive the queue. Nothing runs before start().
  JobQueue(Store& store, const DataFolder& folder, RunEvents& events, WorkerOptions options);
  ~JobQueue();

  // Puts back what an ended process left running and begins to work.
  void start();
  // A run was added.
  void notify();
  // Cancels a queued or running run; false when it has ended already or does not exist. A running one ends soon after.
  bool cancel(std::int64_t run);
  // Ends all workers; their runs are resumed by the next start. Returns when they are gone.
  void stop();

 private:
  void work(const std::stop_token& stop);
  void execute(const RunRecord& run, const std::stop_token& stop);
  // Puts a run whose worker died back in the queue; false when it was cancelled meanwhile.
  bool start_again(const RunRecord& run, const std::string& reason);
  void finish(std::int64_t run, RunStatus status, const std::string& reason, const std::stop_token& stop);

  Store& store_;
  const DataFolder& folder_;
  RunEvents& events_;
  WorkerOptions options_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::uint64_t additions_ = 0;
  std::map<std::int64_t, std::stop_source> active_;  // by run; requested to stop: cancelled by a user
  std::vector<std::jthread> threads_;
};

}  // namespace subpixel::server
