#include "server/engine/slurm_engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <random>
#include <thread>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/json_document.hpp"
#include "base/numbers.hpp"
#include "server/engine/slurm_replaying.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxSummaryBytes = std::size_t{16} << 20;

// A word in single quotes for a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

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
    sleep();
  }
}

// A signal ends it early.
void Replaying::sleep() const {
  const Clock::time_point end = Clock::now() + pause_;
  while (Clock::now() < end && (options_.stop == nullptr || !*options_.stop)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
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
    fs::create_directories(root / "noted");
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
  return options_.shared / "slurm" / "noted" / content_hash_hex(std::as_bytes(std::span(what)));
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

void Replaying::cancel_all() {
  std::set<std::uint64_t> open;
  for (const Task& task : tasks_) {
    if (task.stage == Stage::submitted) open.insert(arrays_[task.batch].number);
  }
  slurm_.cancel({open.begin(), open.end()});
}

void SlurmEngine::replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) {
  if (requests.empty()) return;
  Replaying(worker_, options_, requests, sink).run();
}

}  // namespace subpixel::server
