#include "server/engine/slurm_engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <random>
#include <set>
#include <thread>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/json_document.hpp"
#include "base/numbers.hpp"
#include "base/plain_file.hpp"
#include "base/printable.hpp"
#include "server/engine/shard_folder.hpp"
#include "server/engine/slurm_commands.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kShortPause{300}, kLongPause{10'000};
// A shared folder may show a file later than Slurm says that its task has ended.
constexpr std::chrono::seconds kLateFiles{15};
// Few tasks that depend on each other in one go: a shard waits for the references of its batch, not of all.
constexpr std::size_t kBatchTasks = 128;
constexpr std::size_t kMaxSummaryBytes = std::size_t{16} << 20;

// A word in single quotes for a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

enum class Stage { waiting, submitted, done, failed };

// One task: of references (no pairs) or of results.
struct Task {
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

void Replaying::run() {
  prepare_folder();
  plan();
  while (next_ < requests_.size()) {
    if (options_.stop != nullptr && *options_.stop)
      throw DeviceError("slurm", "ended by a signal; its jobs are cancelled", "");
    submit_some();
    const std::size_t open_before = count(Stage::submitted);
    follow();
    deliver();
    if (next_ >= requests_.size()) break;
    const bool moved = count(Stage::submitted) != open_before;
    pause_ = moved ? kShortPause : std::min(pause_ * 5 / 4, kLongPause);
    std::this_thread::sleep_for(pause_);
  }
}

void Replaying::prepare_folder() {
  const fs::path root = options_.shared / "slurm";
  try {
    fs::create_directories(root);
    cancel_leftovers();
    std::random_device random;
    name_ = fmt::format("subpixel-{:08x}", random());
    folder_ = fs::canonical(root) / name_;
    for (const char* const part : {"tasks", "results", "blobs", "log", "captures"})
      fs::create_directories(folder_ / part);
    for (int i = 0; i < 256; ++i) fs::create_directories(folder_ / "blobs" / fmt::format("{:02x}", i));
    fs::create_directories(options_.cache);
    fs::create_directories(options_.cache / "noted");
  } catch (const fs::filesystem_error& error) {
    throw InputError("can't use the shared folder", error.code().message(), root.string());
  }
}

// Of a process that was killed: its jobs would go on for nobody.
void Replaying::cancel_leftovers() const {
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.shared / "slurm")) {
    if (!entry.path().filename().string().starts_with("subpixel-")) continue;
    std::vector<std::uint64_t> arrays;
    std::ifstream list(entry.path() / "arrays");
    for (std::string line; arrays.size() < 100'000 && std::getline(list, line);) {
      if (const auto number = parse_number<std::uint64_t>(line)) arrays.push_back(*number);
    }
    slurm_.cancel(arrays);
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

// Of a capture whose frames are not named a process says how many there are: this one decodes nothing of others.
std::optional<std::pair<std::uint32_t, std::uint32_t>> Replaying::frames_of_request(
    const ReplayRequest& request) const {
  if (request.job.options.frames) return request.job.options.frames;
  ChildLimits limits = worker_.limits;
  limits.silence = limits.duration = std::chrono::minutes(5);
  limits.confinement.emplace();
  limits.confinement->readable = {request.job.capture.string()};
  std::string output;
  const ChildOutcome outcome = run_child({worker_.path.string(), "info", request.job.capture.string(), "--json"},
                                         limits, {}, [&](std::string_view line) {
                                           output.append(line) += '\n';
                                           return output.size() <= kMaxSummaryBytes;
                                         });
  if (!outcome.reason.empty()) return std::nullopt;
  try {
    const nlohmann::json document = parse_json_document(output, "capture summary", "the worker's answer");
    const std::uint32_t count = JsonField(document, "capture summary").member("frame_count").u32();
    if (count == 0 || count > 1'000'000) return std::nullopt;
    return std::pair(0u, count - 1);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void Replaying::plan() {
  frames_.resize(requests_.size());
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    const ReplayRequest& request = requests_[i];
    frames_[i] = frames_of_request(request);
    // What can't be read is replayed in one piece, which says why not.
    const auto frames = frames_[i].value_or(std::pair(0u, 0u));
    std::vector<Shard> shards = plan_shards(request, i, frames.first, frames.second, options_.size);
    if (frames_[i] && request.job.options.reference_samples > 0) {
      for (std::uint64_t frame = frames.first; frame <= frames.second; ++frame) {
        Shard one{i, {}, 0};
        for (std::uint32_t t = 0; t < request.job.options.techniques.size(); ++t)
          one.pairs.emplace_back(static_cast<std::uint32_t>(frame), t);
        add_task(i, std::move(one), true, frames);
      }
    }
    if (!frames_[i]) {
      shards.resize(1);
      shards[0].pairs.clear();
    }
    for (Shard& shard : shards) add_task(i, std::move(shard), false, frames);
  }
  const auto references = static_cast<std::size_t>(
      std::ranges::count_if(tasks_, [](const Task& task) { return task.references && task.stage == Stage::waiting; }));
  const auto shards =
      static_cast<std::size_t>(std::ranges::count_if(tasks_, [](const Task& task) { return !task.references; }));
  say(fmt::format("{} captures in {} shards, {} frames' references first", requests_.size(), shards, references));
}

void Replaying::add_task(std::size_t request, Shard shard, bool references,
                         std::pair<std::uint32_t, std::uint32_t> frames) {
  Task task;
  task.request = request;
  task.id = fmt::format("{}{:05}", references ? "r" : "s", tasks_.size());
  task.references = references;
  task.job = requests_[request].job;
  task.job.out_dir.clear();
  task.job.cache_dir = options_.cache;
  // A link where it can be one: nodes see the bytes that were hashed, wherever they came from.
  const fs::path placed = folder_ / "captures" / (requests_[request].capture_hash + ".spcap");
  std::error_code error;
  if (!fs::exists(placed)) {
    fs::create_hard_link(task.job.capture, placed, error);
    if (error) fs::copy_file(task.job.capture, placed, error);
    if (error) throw InputError("can't use the shared folder", error.message(), placed.string());
  }
  task.job.capture = placed;
  if (frames_[request]) {
    // All frames stay named: what a scene keeps of its frames is the same then, and so are all bits.
    task.job.options.frames = frames;
    task.job.options.skip = left_out(shard.pairs, frames.first, frames.second, task.job.options.techniques.size());
  }
  task.job.options.references_only = references;
  task.shard = std::move(shard);
  if (references && fs::exists(reference_note(task))) task.stage = Stage::done;
  tasks_.push_back(std::move(task));
}

// That a frame's references were computed by this build into this cache. It saves a task; a shard that does not find
// them (another driver, a cache that was cleared) computes them itself.
fs::path Replaying::reference_note(const Task& task) const {
  replay::ReplayJob job = task.job;
  job.capture = requests_[task.request].capture_hash;
  job.options.repeat = 0;
  std::string what = replay::to_json(job).dump();
  std::error_code ignored;
  what += fmt::format(" {}", fs::last_write_time(worker_.path, ignored).time_since_epoch().count());
  return options_.cache / "noted" / content_hash_hex(std::as_bytes(std::span(what)));
}

std::string Replaying::describe(const Task& task) const {
  const std::string& name = requests_[task.request].name;
  if (task.shard.pairs.empty()) return name;
  const auto [first, last] = std::ranges::minmax(task.shard.pairs, {}, [](const auto& pair) { return pair.first; });
  std::set<std::uint32_t> techniques;
  for (const auto& pair : task.shard.pairs) techniques.insert(pair.second);
  const std::string frames = first.first == last.first ? fmt::format("frame {}", first.first)
                                                       : fmt::format("frames {}-{}", first.first, last.first);
  if (task.references) return fmt::format("{} {}, its references", name, frames);
  return fmt::format("{} {}, {} of {} techniques", name, frames, techniques.size(), task.job.options.techniques.size());
}

// As much as there is room for. What is retried comes in arrays of its own, which leave nodes out.
void Replaying::submit_some() {
  const std::size_t most = std::min<std::size_t>(options_.in_flight, std::max(slurm_.limits().jobs / 2, 1u));
  const std::size_t array_size = std::clamp<std::size_t>(slurm_.limits().array_size, 1, kBatchTasks);
  while (true) {
    const std::size_t room = std::min({most - std::min(most, count(Stage::submitted)), 2 * array_size, batch_limit_});
    std::vector<std::size_t> references, shards;
    std::optional<bool> retried;
    for (std::size_t i = 0; i < tasks_.size() && references.size() + shards.size() < room; ++i) {
      const Task& task = tasks_[i];
      if (task.stage != Stage::waiting || retried.value_or(!task.lost_on.empty()) == task.lost_on.empty()) continue;
      std::vector<std::size_t>& list = task.references ? references : shards;
      if (list.size() >= array_size) break;
      retried = !task.lost_on.empty();
      list.push_back(i);
    }
    if (references.empty() && shards.empty()) return;
    if (!references.empty() && !submit_array(references)) return;
    if (!shards.empty() && !submit_array(shards)) return;
  }
}

bool Replaying::submit_array(const std::vector<std::size_t>& tasks) {
  Array array;
  array.name = fmt::format("{}-{}", name_, arrays_.size());
  array.tasks = tasks;
  std::set<std::string> exclude;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const Task& task = tasks_[tasks[i]];
    ShardTask written{
        task.job, folder_ / "results" / task.id, folder_ / "blobs", worker_.path,
        static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::seconds>(worker_.limits.silence).count())};
    fs::create_directories(written.results);
    write_file_atomically(folder_ / "tasks" / fmt::format("{}-{}.json", arrays_.size(), i),
                          std::string_view(to_json(written).dump()));
    exclude.insert(task.lost_on.begin(), task.lost_on.end());
  }
  Submission submission;
  submission.name = array.name;
  submission.script = folder_ / "tasks" / fmt::format("{}.sh", arrays_.size());
  submission.log = folder_ / "log";
  submission.tasks = static_cast<std::uint32_t>(tasks.size());
  submission.after = arrays_before(tasks);
  if (!exclude.empty()) {
    const std::vector<std::string> usable = slurm_.usable_nodes();
    // Better on the same node again than on none.
    const bool any_left = std::ranges::any_of(usable, [&](const std::string& node) { return !exclude.contains(node); });
    if (any_left) submission.exclude.assign(exclude.begin(), exclude.end());
  }
  write_file_atomically(submission.script, std::string_view(fmt::format(
                                               "#!/bin/sh\nexec {} shard --task {}-\"$SLURM_ARRAY_TASK_ID\".json\n",
                                               quoted(options_.program.string()),
                                               quoted((folder_ / "tasks" / std::to_string(arrays_.size())).string()))));
  std::string refusal;
  const std::optional<std::uint64_t> number = slurm_.submit(submission, refusal);
  if (!number) {
    if (refusal_.empty()) say("the queue is full, waiting: " + refusal);
    refusal_ = refusal;
    if (!full_since_) full_since_ = Clock::now();
    batch_limit_ = std::max<std::size_t>(tasks.size() / 2, 1);  // a part may still fit
    if (count(Stage::submitted) == 0 && Clock::now() - *full_since_ >= options_.patience) {
      throw DeviceError("slurm",
                        fmt::format("the queue has been full for {} s, nothing could be submitted ({})",
                                    options_.patience.count(), refusal),
                        "sbatch");
    }
    return false;
  }
  full_since_.reset();
  refusal_.clear();
  batch_limit_ = std::min(2 * batch_limit_, kBatchTasks * 2);
  array.number = *number;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    Task& task = tasks_[tasks[i]];
    task.stage = Stage::submitted;
    task.batch = arrays_.size();
    task.index = static_cast<std::uint32_t>(i);
    task.gone.reset();
    task.node.clear();
  }
  arrays_.push_back(std::move(array));
  remember_arrays();
  return true;
}

// Those that compute references for these tasks and have not ended.
std::vector<std::uint64_t> Replaying::arrays_before(const std::vector<std::size_t>& tasks) const {
  std::set<std::size_t> requests;
  for (const std::size_t i : tasks) {
    if (!tasks_[i].references) requests.insert(tasks_[i].request);
  }
  std::set<std::uint64_t> arrays;
  for (const Task& task : tasks_) {
    if (task.references && task.stage == Stage::submitted && requests.contains(task.request))
      arrays.insert(arrays_[task.batch].number);
  }
  return {arrays.begin(), arrays.end()};
}

void Replaying::remember_arrays() const {
  std::string list;
  for (const Array& array : arrays_) list += fmt::format("{}\n", array.number);
  write_file_atomically(folder_ / "arrays", std::string_view(list));
}

void Replaying::follow() {
  std::vector<std::string> names;
  std::set<std::size_t> open;
  for (const Task& task : tasks_) {
    if (task.stage == Stage::submitted) open.insert(task.batch);
  }
  if (open.empty()) return;
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

void Replaying::cancel_all() {
  std::set<std::uint64_t> open;
  for (const Task& task : tasks_) {
    if (task.stage == Stage::submitted) open.insert(arrays_[task.batch].number);
  }
  slurm_.cancel({open.begin(), open.end()});
}

}  // namespace

void SlurmEngine::replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) {
  if (requests.empty()) return;
  Replaying(worker_, options_, requests, sink).run();
}

}  // namespace subpixel::server
