// Slurm by its programs (sbatch, squeue, sacct, scontrol, sinfo, scancel), whose words are checked like any other's.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::server {

// A task of an array, as Slurm writes it: "17_3".
struct ArrayTask {
  std::uint64_t array = 0;
  std::uint32_t index = 0;
  auto operator<=>(const ArrayTask&) const = default;  // NOLINT(modernize-use-nullptr): there is none
};
std::optional<ArrayTask> array_task_from_text(std::string_view text);

// NOLINTNEXTLINE(bugprone-exception-escape): plain strings
struct TaskState {
  std::string state;   // "PENDING", "RUNNING", "COMPLETED", "TIMEOUT", "NODE_FAIL", "CANCELLED", ...; never empty
  std::string node;    // where it runs or ran
  std::string reason;  // why it waits
};

// Lines of `squeue -h -r -o "%i|%T|%N|%r"`; those of no array task are left out.
std::map<ArrayTask, TaskState> parse_squeue(std::string_view text);
// Lines of `sacct -n -P -X -o JobID,State,NodeList`.
std::map<ArrayTask, TaskState> parse_sacct(std::string_view text);
// What `scontrol -o show job` says of one task.
std::optional<TaskState> parse_scontrol_job(std::string_view text);

struct SlurmLimits {
  std::uint32_t array_size = 1000;  // an array's largest index
  std::uint32_t jobs = 10000;       // of all users together
  bool accounting = false;          // sacct has something to say
};

struct Submission {
  std::string name;                  // of the job; no other may have it
  std::filesystem::path script;      // run once for each index
  std::filesystem::path log;         // the folder for what tasks print
  std::uint32_t tasks = 0;           // indices from 0
  std::vector<std::uint64_t> after;  // arrays all of whose tasks must have succeeded
  std::vector<std::string> exclude;  // nodes
};

class SlurmCommands {
 public:
  // `partition` may be empty: Slurm's default. `options` go to sbatch as they are. Throws DeviceError when there is no
  // sbatch, or no Slurm answers.
  SlurmCommands(std::string partition, std::vector<std::string> options, std::uint32_t minutes);

  const SlurmLimits& limits() const { return limits_; }
  // Those that could run something, now or later, of the partition. Throws UsageError for a partition that is not
  // there.
  std::vector<std::string> usable_nodes() const;
  // How the partition's nodes are, for people: "n1 drained (broken fan), n2 down".
  std::string nodes_in_words() const;

  // The array's number; none when the queue is full, whose words are then in `refusal`. Throws UsageError for options
  // that sbatch refuses.
  std::optional<std::uint64_t> submit(const Submission& submission, std::string& refusal) const;
  // Tasks that wait or run, of all jobs of these names.
  std::map<ArrayTask, TaskState> queued(const std::vector<std::string>& names) const;
  // How tasks of an array that are in no queue any more ended, as far as Slurm still knows.
  std::map<ArrayTask, TaskState> ended(std::uint64_t array, const std::vector<std::uint32_t>& indices) const;
  void cancel(const std::vector<std::uint64_t>& arrays) const;

 private:
  struct Said {
    int code = 0;
    std::string output, errors;
    bool timed_out = false;
  };
  Said run(const std::string& program, std::vector<std::string> arguments, std::chrono::seconds longest,
           bool (*enough)(std::string_view line) = nullptr) const;
  Said ask(const std::string& program, const std::vector<std::string>& arguments) const;

  std::string partition_;
  std::vector<std::string> options_;
  std::uint32_t minutes_;
  SlurmLimits limits_;
};

}  // namespace subpixel::server
