// How tasks end: by their results, by what Slurm says, or not at all.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/plain_file.hpp"
#include "base/printable.hpp"
#include "server/engine/slurm_replaying.hpp"

namespace subpixel::server {
namespace {

// A shared folder may show a file later than Slurm says that its task has ended.
constexpr std::chrono::seconds kLateFiles{15};

}  // namespace

void Replaying::follow() {
  std::vector<std::string> names;
  std::set<std::size_t> open;
  for (const Task& task : tasks_) {
    if (task.stage == Stage::submitted) open.insert(task.batch);
  }
  if (open.empty()) return;
  names.reserve(open.size());
  for (const std::size_t array : open) names.push_back(arrays_[array].name);
  const std::map<ArrayTask, TaskState> queue = slurm_.queued(names);
  std::map<std::size_t, std::vector<std::uint32_t>> left;  // by array: tasks that are in no queue
  for (Task& task : tasks_) {
    if (task.stage != Stage::submitted) continue;
    const auto found = queue.find({arrays_[task.batch].number, task.index});
    if (found == queue.end() || found->second.state == "COMPLETING") {
      left[task.batch].push_back(task.index);
    } else if (!found->second.node.empty()) {
      task.node = found->second.node;
    }
  }
  for (const auto& [array, indices] : left) {
    std::vector<std::uint32_t> unknown;
    for (const std::uint32_t index : indices) {
      Task& task = tasks_[arrays_[array].tasks[index]];
      if (looks_done(task)) {
        task.stage = Stage::done;
      } else {
        unknown.push_back(index);
      }
    }
    if (unknown.empty()) continue;
    const std::map<ArrayTask, TaskState> ended = slurm_.ended(arrays_[array].number, unknown);
    for (const std::uint32_t index : unknown) {
      const auto state = ended.find({arrays_[array].number, index});
      take_end(tasks_[arrays_[array].tasks[index]], state == ended.end() ? nullptr : &state->second);
    }
  }
  watch_for_standstill(queue);
}

// Whether a task's results say that it is through.
bool Replaying::looks_done(Task& task) {
  const fs::path results = folder_ / "results" / task.id;
  const ShardOutcome outcome =
      read_outcome(results, task.job, task.references ? decltype(task.shard.pairs){} : task.shard.pairs);
  for (const std::string& refused : outcome.refused) say(fmt::format("{}: {}", describe(task), refused));
  if (!outcome.end) return false;
  if (task.references && outcome.end->end.problem.empty()) {
    write_file_atomically(reference_note(task), std::string_view());
  }
  return !outcome.end->end.problem.empty() || task.references || task.shard.pairs.empty() ||
         outcome.results.size() == task.shard.pairs.size();
}

void Replaying::take_end(Task& task, const TaskState* state) {
  if (!task.gone) task.gone = Clock::now();
  const bool waited = Clock::now() - *task.gone >= kLateFiles;
  if (state == nullptr) {
    if (!waited) return;
    // What was cancelled before it ran slurmctld forgets at once; what ran has left a log.
    if (!fs::exists(log_of(task))) return cancelled(task);
    return lost(task, "Slurm does not know it any more", true);
  }
  if (!state->node.empty()) task.node = state->node;
  const std::string& name = state->state;
  if (name == "PENDING" || name == "RUNNING" || name == "COMPLETING" || name == "CONFIGURING" || name == "SUSPENDED") {
    return;  // it was between two answers
  }
  if (name == "CANCELLED") return cancelled(task);
  if (name == "COMPLETED" && !waited) return;
  if (name == "TIMEOUT") {
    lost(task,
         options_.minutes > 0 ? fmt::format("it ran past its time limit of {} min", options_.minutes)
                              : "it ran past the partition's time limit",
         true);
  } else if (name == "COMPLETED") {
    lost(task, "it ended without its results", true);
  } else {
    lost(task, name, true);
  }
}

void Replaying::cancelled(Task& task) {
  // Slurm cancels by itself what waits for an array that failed.
  const bool waits = !task.references && task.node.empty() && std::ranges::any_of(tasks_, [&](const Task& other) {
    return other.references && other.request == task.request && other.attempts > 0;
  });
  if (waits) return lost(task, "its references were lost", false);
  task.stage = Stage::failed;
  task.problem = fmt::format("the Slurm job {}_{} was cancelled", arrays_[task.batch].number, task.index);
  say(fmt::format("{}: {}", describe(task), task.problem));
}

// Puts a task back, or gives it up. `ran`: it had its chance.
void Replaying::lost(Task& task, const std::string& why, bool ran) {
  const std::string words = last_words(task);
  const std::string where = task.node.empty() ? "" : " on " + task.node;
  if (ran) {
    const std::size_t there = read_outcome(folder_ / "results" / task.id, task.job, task.shard.pairs).results.size();
    task.attempts = there > task.results ? 1 : task.attempts + 1;
    task.results = there;
    if (!task.node.empty()) task.lost_on.insert(task.node);
  }
  if (task.attempts > options_.retries) {
    task.problem = fmt::format("lost {} times{}: {}{}", task.attempts,
                               task.lost_on.empty() ? "" : fmt::format(" (on {})", fmt::join(task.lost_on, ", ")), why,
                               words.empty() ? "" : "; its last words: " + words);
    // Without its references a shard computes them itself.
    task.stage = task.references ? Stage::done : Stage::failed;
    say(fmt::format("{} is given up: {}", describe(task), task.problem));
    return;
  }
  say(fmt::format("{} was lost{} ({}{}); once more", describe(task), where, why, words.empty() ? "" : ": " + words));
  task.stage = Stage::waiting;
}

std::string Replaying::last_words(const Task& task) const {
  try {
    std::string text = read_plain_file(log_of(task), std::uint64_t{1} << 20, "log", "");
    while (text.ends_with('\n')) text.pop_back();
    const std::size_t line = text.rfind('\n');
    return printable(line == std::string::npos ? text : text.substr(line + 1), 300);
  } catch (const Error&) {
    return "";
  }
}

// Work that waits for what will not come by itself: nodes that are down or drained, a limit, a hold.
void Replaying::watch_for_standstill(const std::map<ArrayTask, TaskState>& queue) {
  static const std::set<std::string> kTakesTime{"",           "None",      "Priority",          "Resources",
                                                "Dependency", "BeginTime", "JobArrayTaskLimit", "Prolog",
                                                "Cleaning",   "(null)",    "Reservation",       "NodesBusy"};
  std::set<std::string> reasons;
  bool moves = queue.empty(), could = false;
  for (const auto& task : queue) {
    if (task.second.state != "PENDING") moves = true;
    reasons.insert(task.second.reason);
    if (task.second.reason != "Dependency" && kTakesTime.contains(task.second.reason)) could = true;
  }
  // What waits for others waits for as long as they do, and a moment more.
  if (reasons == std::set<std::string>{"Dependency"}) could = true;
  if (!moves && could) could = !slurm_.usable_nodes().empty();
  if (moves || could) {
    still_since_.reset();
    return;
  }
  if (!still_since_) {
    still_since_ = Clock::now();
    say(fmt::format("nothing can run now ({}): {}", fmt::join(reasons, "; "), slurm_.nodes_in_words()));
  }
  if (Clock::now() - *still_since_ < options_.patience) return;
  throw DeviceError("slurm",
                    fmt::format("no node could run anything for {} s ({}): {}", options_.patience.count(),
                                fmt::join(reasons, "; "), slurm_.nodes_in_words()),
                    options_.partition.empty() ? "the default partition" : "partition " + options_.partition);
}

}  // namespace subpixel::server
