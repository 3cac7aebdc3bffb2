// What a node does with a task: replays its part in a worker process and puts the results into the shared folder.
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <set>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "server/engine/shard_folder.hpp"
#include "server/store/worker_files.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

// A folder of the node's own, gone with this.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "subpixel-shard-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw InputError("shard", std::strerror(errno), name);
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string node_name() {
  if (const char* name = std::getenv("SLURMD_NODENAME"); name != nullptr) return printable(name, 100);
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return printable(host.data(), 100);
}

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Of the results a task is for. Where its job names no frames only the worker knows how many there are.
Pairs wanted_of(const replay::ReplayJob& job) {
  Pairs wanted;
  if (!job.options.frames || job.options.references_only) return wanted;
  const std::set<std::pair<std::uint32_t, std::uint32_t>> skipped(job.options.skip.begin(), job.options.skip.end());
  const auto [first, last] = *job.options.frames;
  for (std::uint64_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t technique = 0; technique < job.options.techniques.size(); ++technique) {
      const std::pair pair{static_cast<std::uint32_t>(frame), technique};
      if (!skipped.contains(pair)) wanted.push_back(pair);
    }
  }
  return wanted;
}

}  // namespace

void run_shard_task(const fs::path& task_file) {
  const auto begin = std::chrono::steady_clock::now();
  ShardTask task = read_shard_task(task_file);
  const Pairs wanted = wanted_of(task.job);
  // What an attempt before this one left is not done again.
  for (const auto& stored : read_outcome(task.results, task.job, wanted).results) {
    bool whole = true;
    for (const auto& image : stored.second.images) {
      try {
        read_blob(task.blobs, image.second);
      } catch (const InputError&) {
        whole = false;
      }
    }
    if (whole) task.job.options.skip.push_back(stored.first);
  }
  const Scratch scratch;
  task.job.out_dir = scratch.path() / "out";
  std::string not_written;
  const auto take = [&](std::uint32_t ordinal, const replay::FrameResult& result) {
    ShardResult kept;
    kept.ordinal = ordinal;
    kept.result = result;
    const std::map<std::string, Blob> images = read_worker_images(task.job.out_dir, result);
    try {
      for (const auto& [role, file] : result.images) {
        kept.images[role] = write_blob(task.blobs, file, images.at(role));
      }
      write_result(task.results, kept);
    } catch (const InputError& error) {
      not_written = error.what();
      throw;
    }
    for (const auto& [role, file] : result.images) {
      if (role.starts_with("reference")) continue;  // results of one frame share it
      std::error_code ignored;
      fs::remove(task.job.out_dir / file, ignored);
    }
  };
  WorkerProgram worker{task.worker, {}};
  worker.limits.silence = std::chrono::seconds(task.silence_s);
  WorkerEnd ended = replay_in_worker(task.job, scratch.path() / "job.json", worker, take);
  if (!not_written.empty()) throw InputError("shard", not_written, task.results.string());
  if (ended.killed) throw DeviceError("shard", ended.end.problem, node_name());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  write_end(task.results, {std::move(ended.end), node_name(), took.count()});
}

}  // namespace subpixel::server
