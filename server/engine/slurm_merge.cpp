// From shards to requests: results in the order of a replay that was not divided.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "server/engine/slurm_replaying.hpp"

namespace subpixel::server {

void Replaying::deliver() {
  while (next_ < requests_.size()) {
    const bool open = std::ranges::any_of(tasks_, [&](const Task& task) {
      return task.request == next_ && (task.stage == Stage::waiting || task.stage == Stage::submitted);
    });
    if (open || !merge(next_)) return;
    ++next_;
  }
}

// Hands a request's results on. False when an image turns out to be damaged; its shard goes back to be done again.
bool Replaying::merge(std::size_t request) {
  struct Part {
    std::uint32_t frame, ordinal;
    std::size_t task;
    ShardResult result;
  };
  std::vector<Part> parts;
  ReplayEnd end;
  std::set<std::string> processors, drivers;
  double wall_s = 0, outside_s = 0;
  std::map<std::string, double> outside_parts_s;
  std::uint32_t shards = 0;
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    Task& task = tasks_[i];
    if (task.request != request || task.references) continue;
    ++shards;
    ShardOutcome outcome = read_outcome(folder_ / "results" / task.id, task.job, task.shard.pairs);
    for (auto& [pair, result] : outcome.results) parts.push_back({pair.first, pair.second, i, std::move(result)});
    if (end.problem.empty() && !task.problem.empty()) end.problem = fmt::format("{}: {}", describe(task), task.problem);
    if (!outcome.end) continue;
    if (end.problem.empty() && !outcome.end->end.problem.empty()) {
      end.problem = outcome.end->end.problem;
      end.exit_code = outcome.end->end.exit_code;
    }
    if (!outcome.end->end.head) continue;
    const replay::ResultsHead& head = *outcome.end->end.head;
    if (head.capture_hash != requests_[request].capture_hash && !head.capture_hash.empty() && end.problem.empty()) {
      end.problem =
          fmt::format("node {} replayed another capture: {}", outcome.end->node, printable(head.capture_hash, 40));
    }
    processors.insert(head.cpu_model);
    drivers.insert(head.driver_version);
    wall_s += head.wall_s;
    outside_s += head.outside_gpu_s;
    for (const auto& [part, seconds] : head.outside_parts_s) outside_parts_s[part] += seconds;
    if (!end.head) end.head = head;
  }
  if (!frames_[request] && end.problem.empty()) end.problem = "how many frames it has could not be found out";
  if (end.head) {
    end.head->wall_s = wall_s;
    end.head->outside_gpu_s = outside_s;
    end.head->outside_parts_s = outside_parts_s;
    // Gates are exact on one kind of machine only: several kinds are none of them.
    end.head->cpu_model = fmt::format("{}", fmt::join(processors, " + "));
    end.head->driver_version = fmt::format("{}", fmt::join(drivers, " + "));
    if (processors.size() > 1) {
      say(fmt::format("{} was replayed on several kinds of processors: {}", requests_[request].name,
                      fmt::join(processors, ", ")));
    }
  }
  std::ranges::sort(parts, {}, [](const Part& part) { return std::pair(part.frame, part.ordinal); });
  std::vector<std::map<std::string, Blob>> images(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    try {
      for (const auto& [role, image] : parts[i].result.images) images[i][role] = read_blob(folder_ / "blobs", image);
    } catch (const InputError& error) {
      Task& task = tasks_[parts[i].task];
      if (task.stage == Stage::failed) {  // given up already: this result is lost too
        parts[i].result.result.images.clear();
        continue;
      }
      say(fmt::format("{}: {}", describe(task), error.what()));
      std::error_code ignored;
      fs::remove_all(folder_ / "results" / task.id, ignored);
      task.results = 0;
      lost(task, error.what(), true);
      return false;
    }
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool given_up = parts[i].result.result.images.empty() && !parts[i].result.images.empty();
    if (given_up) continue;
    sink_.result(request, parts[i].ordinal, std::move(parts[i].result.result), std::move(images[i]));
  }
  say(fmt::format("{} ({}/{}): {} results of {} shards", requests_[request].name, request + 1, requests_.size(),
                  parts.size(), shards));
  sink_.end(request, std::move(end));
  for (const Task& task : tasks_) {
    std::error_code ignored;
    if (task.request == request) fs::remove_all(folder_ / "results" / task.id, ignored);
  }
  return true;
}

}  // namespace subpixel::server
