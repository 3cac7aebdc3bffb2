#include "server/engine/slurm_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "base/error.hpp"
#include "base/numbers.hpp"
#include "base/printable.hpp"
#include "process/child_process.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxOutputBytes = std::size_t{64} << 20;  // a million lines of squeue
constexpr std::chrono::seconds kSubmitTime{60};
constexpr std::chrono::seconds kAskTime{60};

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// Of the path; empty when there is none.
std::string program_path(const std::string& name) {
  const char* const path = std::getenv("PATH");
  for (const std::string_view folder : split(path != nullptr ? path : "", ':')) {
    std::string candidate = fs::path(folder) / name;
    if (!folder.empty() && ::access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return "";
}

std::string plain(std::string_view text) {
  return printable(text, 200);
}

// "CANCELLED by 0" is CANCELLED, "COMPLETED+" too.
std::string first_word(std::string_view text) {
  return plain(text.substr(0, text.find_first_of(" +")));
}

// The value of KEY=VALUE among others, up to the next blank.
std::string value_of(std::string_view text, std::string_view key) {
  const std::string begin = std::string(key) + "=";
  for (std::size_t at = 0; (at = text.find(begin, at)) != std::string_view::npos; ++at) {
    if (at != 0 && text[at - 1] != ' ' && text[at - 1] != '\n') continue;
    const std::string_view rest = text.substr(at + begin.size());
    return plain(rest.substr(0, rest.find_first_of(" \n")));
  }
  return "";
}

std::string said(const std::string& errors) {
  return printable(joined_lines(errors), 600);
}

// sbatch itself tries again for two minutes after the first of these.
bool means_full(std::string_view words) {
  for (const char* const sign :
       {"temporarily unable to accept", "submit limit", "Unable to create job record", "MaxSubmit", "MaxJobs",
        "Resource temporarily unavailable", "QOSMaxSubmitJob", "AssocMaxSubmitJob"}) {
    if (words.find(sign) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

std::optional<ArrayTask> array_task_from_text(std::string_view text) {
  const std::size_t bar = text.find('_');
  if (bar == std::string_view::npos) return std::nullopt;
  const auto array = parse_number<std::uint64_t>(text.substr(0, bar));
  const auto index = parse_number<std::uint32_t>(text.substr(bar + 1));
  if (!array || !index) return std::nullopt;
  return ArrayTask{*array, *index};
}

std::map<ArrayTask, TaskState> parse_squeue(std::string_view text) {
  std::map<ArrayTask, TaskState> tasks;
  for (const std::string_view line : split(text, '\n')) {
    const std::vector<std::string_view> parts = split(line, '|');
    if (parts.size() < 4 || parts[1].empty()) continue;
    if (const auto task = array_task_from_text(parts[0])) {
      tasks[*task] = {first_word(parts[1]), plain(parts[2]), plain(parts[3])};
    }
  }
  return tasks;
}

std::map<ArrayTask, TaskState> parse_sacct(std::string_view text) {
  std::map<ArrayTask, TaskState> tasks;
  for (const std::string_view line : split(text, '\n')) {
    const std::vector<std::string_view> parts = split(line, '|');
    if (parts.size() < 3 || parts[1].empty()) continue;
    if (const auto task = array_task_from_text(parts[0])) {
      tasks[*task] = {first_word(parts[1]), parts[2] == "None assigned" ? "" : plain(parts[2]), ""};
    }
  }
  return tasks;
}

std::optional<TaskState> parse_scontrol_job(std::string_view text) {
  TaskState state{value_of(text, "JobState"), value_of(text, "NodeList"), value_of(text, "Reason")};
  if (state.state.empty()) return std::nullopt;
  if (state.node == "(null)") state.node.clear();
  return state;
}

SlurmCommands::SlurmCommands(std::string partition, std::vector<std::string> options, std::uint32_t minutes)
    : partition_(std::move(partition)), options_(std::move(options)), minutes_(minutes) {
  for (const char* const program : {"sbatch", "squeue", "scontrol", "sinfo", "scancel"}) {
    if (program_path(program).empty()) {
      throw DeviceError("slurm", fmt::format("there is no program {}; is Slurm installed?", program), "PATH");
    }
  }
  const Said config = ask("scontrol", {"show", "config"});
  for (const std::string_view line : split(config.output, '\n')) {
    const std::vector<std::string_view> sides = split(line, '=');
    if (sides.size() < 2) continue;
    const std::string key = joined_lines(sides[0]), value = joined_lines(sides[1]);
    if (key == "MaxArraySize") limits_.array_size = parse_number<std::uint32_t>(value).value_or(limits_.array_size);
    if (key == "MaxJobCount") limits_.jobs = parse_number<std::uint32_t>(value).value_or(limits_.jobs);
    if (key == "AccountingStorageType") {
      limits_.accounting = value != "accounting_storage/none" && value != "(null)" && !program_path("sacct").empty();
    }
  }
}

// With `enough` errors are among the output, and the program is ended at the first line of which that is true.
SlurmCommands::Said SlurmCommands::run(const std::string& program, std::vector<std::string> arguments,
                                       std::chrono::seconds longest, bool (*enough)(std::string_view)) const {
  const std::string path = program_path(program);
  if (path.empty()) throw DeviceError("slurm", "there is no program " + program, "PATH");
  arguments.insert(arguments.begin(), path);
  if (enough != nullptr) {
    const std::vector<std::string> shell{"/bin/sh", "-c", "exec \"$@\" 2>&1", "sh"};
    arguments.insert(arguments.begin(), shell.begin(), shell.end());
  }
  ChildLimits limits;
  limits.silence = limits.duration = longest;
  // Words as this reads them, whatever the user likes.
  limits.environment = {"LC_ALL=C", "SQUEUE_FORMAT=", "SQUEUE_SORT="};
  Said answer;
  const ChildOutcome outcome = run_child(arguments, limits, {}, [&](std::string_view line) {
    answer.output.append(line) += '\n';
    return answer.output.size() <= kMaxOutputBytes && (enough == nullptr || !enough(line));
  });
  answer.timed_out = outcome.kind == ChildOutcome::Kind::silent || outcome.kind == ChildOutcome::Kind::too_long;
  answer.code = outcome.kind == ChildOutcome::Kind::exited ? outcome.code : -1;
  answer.errors = enough != nullptr ? answer.output : outcome.error_tail;
  if (answer.code != 0 && answer.errors.empty()) answer.errors = outcome.reason;
  return answer;
}

SlurmCommands::Said SlurmCommands::ask(const std::string& program, const std::vector<std::string>& arguments) const {
  Said answer = run(program, arguments, kAskTime);
  if (answer.code != 0) throw DeviceError("slurm", said(answer.errors), program);
  return answer;
}

std::vector<std::string> SlurmCommands::usable_nodes() const {
  std::vector<std::string> arguments{"-h", "-N", "-o", "%N|%T|%P|%a"};
  if (!partition_.empty()) arguments.push_back("--partition=" + partition_);
  std::vector<std::string> nodes;
  bool any = false;
  for (const std::string_view line : split(ask("sinfo", arguments).output, '\n')) {
    const std::vector<std::string_view> parts = split(line, '|');
    // The default partition is the one with a star.
    if (parts.size() < 4 || (partition_.empty() && !parts[2].ends_with('*'))) continue;
    any = true;
    const std::string state(parts[1]);
    const bool out = std::ranges::any_of(
        std::initializer_list<const char*>{"down", "drain", "fail", "maint", "power", "unk", "reboot", "*"},
        [&](const char* sign) { return state.find(sign) != std::string::npos; });
    if (!out && parts[3] == "up") nodes.push_back(plain(parts[0]));
  }
  if (!any && !partition_.empty()) throw UsageError("slurm", "there is no such partition", printable(partition_, 60));
  return nodes;
}

std::string SlurmCommands::nodes_in_words() const {
  std::vector<std::string> arguments{"-h", "-N", "-o", "%N|%T|%a|%P|%E"};
  if (!partition_.empty()) arguments.push_back("--partition=" + partition_);
  std::vector<std::string> words;
  for (const std::string_view line : split(ask("sinfo", arguments).output, '\n')) {
    const std::vector<std::string_view> parts = split(line, '|');
    if (parts.size() < 5 || words.size() >= 8 || (partition_.empty() && !parts[3].ends_with('*'))) continue;
    words.push_back(fmt::format("{} {}{}{}", plain(parts[0]), plain(parts[1]),
                                parts[2] == "up" ? "" : fmt::format(", partition {}", plain(parts[2])),
                                parts[4].empty() || parts[4] == "none" ? "" : fmt::format(" ({})", plain(parts[4]))));
  }
  return words.empty() ? "there are no nodes" : fmt::format("{}", fmt::join(words, ", "));
}

std::optional<std::uint64_t> SlurmCommands::submit(const Submission& submission, std::string& refusal) const {
  std::vector<std::string> arguments{"--parsable",
                                     fmt::format("--array=0-{}", submission.tasks - 1),
                                     "--job-name=" + submission.name,
                                     "--no-requeue",
                                     "--export=ALL",
                                     "--chdir=" + submission.log.string(),
                                     "--output=" + (submission.log / "%A_%a.txt").string()};
  if (!partition_.empty()) arguments.push_back("--partition=" + partition_);
  if (minutes_ > 0) arguments.push_back(fmt::format("--time={}", minutes_));
  if (!submission.after.empty()) {
    arguments.push_back(fmt::format("--dependency=afterok:{}", fmt::join(submission.after, ":")));
    arguments.push_back("--kill-on-invalid-dep=yes");
  }
  if (!submission.exclude.empty()) {
    arguments.push_back(fmt::format("--exclude={}", fmt::join(submission.exclude, ",")));
  }
  arguments.insert(arguments.end(), options_.begin(), options_.end());
  arguments.push_back(submission.script.string());
  const Said answer = run("sbatch", arguments, kSubmitTime, means_full);
  if (answer.code == 0) {
    for (const std::string_view line : split(answer.output, '\n')) {
      if (const auto number = parse_number<std::uint64_t>(line.substr(0, line.find(';')))) return number;
    }
    throw DeviceError("slurm", "sbatch said no job number: " + plain(answer.output), "sbatch");
  }
  if (answer.timed_out || means_full(answer.errors)) {
    // It may have got through at the last moment.
    for (const auto& task : queued({submission.name})) return task.first.array;
    refusal = said(answer.errors);
    return std::nullopt;
  }
  for (const char* const sign :
       {"nvalid", "unrecognized option", "ambiguous", "not permitted", "requires an argument"}) {
    if (answer.errors.find(sign) != std::string::npos) throw UsageError("slurm", said(answer.errors), "sbatch");
  }
  throw DeviceError("slurm", fmt::format("{} ({})", said(answer.errors), nodes_in_words()), "sbatch");
}

std::map<ArrayTask, TaskState> SlurmCommands::queued(const std::vector<std::string>& names) const {
  return parse_squeue(
      ask("squeue", {"-h", "-r", "-o", "%i|%T|%N|%r", fmt::format("--name={}", fmt::join(names, ","))}).output);
}

std::map<ArrayTask, TaskState> SlurmCommands::ended(std::uint64_t array,
                                                    const std::vector<std::uint32_t>& indices) const {
  if (limits_.accounting) {
    const Said answer =
        run("sacct", {"-n", "-P", "-X", "-o", "JobID,State,NodeList", "-j", std::to_string(array)}, kAskTime);
    if (answer.code == 0) return parse_sacct(answer.output);
  }
  // slurmctld forgets them after MinJobAge.
  std::map<ArrayTask, TaskState> tasks;
  for (const std::uint32_t index : indices) {
    const Said answer = run("scontrol", {"-o", "show", "job", fmt::format("{}_{}", array, index)}, kAskTime);
    if (answer.code != 0) continue;
    if (const auto state = parse_scontrol_job(answer.output)) tasks[{array, index}] = *state;
  }
  return tasks;
}

void SlurmCommands::cancel(const std::vector<std::uint64_t>& arrays) const {
  if (arrays.empty()) return;
  std::vector<std::string> arguments{"--quiet"};
  for (const std::uint64_t array : arrays) arguments.push_back(std::to_string(array));
  run("scancel", arguments, kAskTime);  // those that have ended are no matter
}

}  // namespace subpixel::server
