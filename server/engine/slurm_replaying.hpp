// One call of SlurmEngine::replay: its tasks from the plan to the merged results. slurm_engine.cpp plans and submits,
// slurm_follow.cpp follows what was submitted, slurm_merge.cpp hands results on.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/engine/shard_folder.hpp"
#include "server/engine/slurm_commands.hpp"
#include "server/engine/slurm_engine.hpp"

namespace subpixel::server {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kShortPause{300}, kLongPause{10'000};
// Few tasks that depend on each other in one go: a shard waits for the references of its batch, not of all.
constexpr std::size_t kBatchTasks = 128;

enum class Stage { waiting, submitted, done, failed };

// One task: of references (no pairs) or of results.
struct Task {  // NOLINT(bugprone-exception-escape): moving JSON is declared noexcept
  std::string id;
  std::size_t request = 0;
  Shard shard;
  replay::ReplayJob job;
  bool references = false;
  Stage stage = Stage::waiting;
  std::size_t batch = std::numeric_limits<std::size_t>::max();  // it was last submitted in
  std::uint32_t index = 0;                                      // in its array
  std::uint32_t attempts = 0;                                   // in a row without a new result
  std::size_t results = 0;                                      // there after the last attempt
  std::set<std::string> lost_on;
  std::string node;                       // it was last seen on
  std::optional<Clock::time_point> gone;  // when it was first in no queue
  std::string problem;                    // why it failed
};

// An array that was submitted.
struct Array {
  std::string name;
  std::uint64_t number = 0;
  std::vector<std::size_t> tasks;  // by index
};

class Replaying {
 public:
  Replaying(const WorkerProgram& worker, const SlurmOptions& options, const std::vector<ReplayRequest>& requests,
            const ReplaySink& sink)
      : worker_(worker),
        options_(options),
        requests_(requests),
        sink_(sink),
        slurm_(options.partition, options.sbatch, options.minutes) {}
  ~Replaying() {
    try {
      cancel_all();
      std::error_code ignored;
      fs::remove_all(folder_, ignored);
    } catch (...) {  // NOLINT(bugprone-empty-catch): what could not be cancelled ends by itself
    }
  }
  Replaying(const Replaying&) = delete;
  Replaying& operator=(const Replaying&) = delete;

  void run();

 private:
  void say(const std::string& line) const {
    if (sink_.progress) sink_.progress("slurm: " + line);
  }
  void sleep() const;
  void prepare_folder();
  void cancel_leftovers() const;
  void plan();
  std::optional<std::pair<std::uint32_t, std::uint32_t>> frames_of_request(const ReplayRequest& request) const;
  void add_task(std::size_t request, Shard shard, bool references, std::pair<std::uint32_t, std::uint32_t> frames);
  fs::path reference_note(const Task& task) const;
  void submit_some();
  bool submit_array(const std::vector<std::size_t>& tasks);
  std::vector<std::uint64_t> arrays_before(const std::vector<std::size_t>& tasks) const;
  void follow();
  void take_end(Task& task, const TaskState* state);
  bool looks_done(Task& task);
  void cancelled(Task& task);
  void lost(Task& task, const std::string& why, bool ran);
  void watch_for_standstill(const std::map<ArrayTask, TaskState>& queue);
  void deliver();
  bool merge(std::size_t request);
  void cancel_all();
  void remember_arrays() const;
  std::string describe(const Task& task) const;
  std::string last_words(const Task& task) const;
  fs::path log_of(const Task& task) const {
    return folder_ / "log" / fmt::format("{}_{}.txt", arrays_[task.batch].number, task.index);
  }
  std::size_t count(Stage stage) const {
    return static_cast<std::size_t>(std::ranges::count(tasks_, stage, &Task::stage));
  }

  const WorkerProgram& worker_;
  const SlurmOptions& options_;
  const std::vector<ReplayRequest>& requests_;
  const ReplaySink& sink_;
  SlurmCommands slurm_;
  fs::path folder_;
  std::string name_;  // that jobs' names begin with
  std::vector<Task> tasks_;
  std::vector<Array> arrays_;
  std::vector<std::optional<std::pair<std::uint32_t, std::uint32_t>>> frames_;  // by request
  std::size_t next_ = 0;  // the first request that is not delivered
  std::optional<Clock::time_point> full_since_, still_since_;
  std::string refusal_;
  std::size_t batch_limit_ = kBatchTasks * 2;
  std::chrono::milliseconds pause_ = kShortPause;
};

}  // namespace subpixel::server
