// Replays on the nodes of a Slurm cluster: requests are divided into shards, shards run as job arrays after the arrays
// that compute their references, each task in a worker process that leaves its results in a folder all nodes see
// (shard_folder.hpp). What is lost with a node or a time limit is done again elsewhere, without what is there already.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/engine/replay_engine.hpp"
#include "server/engine/shard_plan.hpp"

namespace subpixel::server {

struct SlurmOptions {
  std::filesystem::path shared;     // a folder at the same path on every node; subfolder `slurm` of it is used
  std::filesystem::path cache;      // of references, seen by every node
  std::filesystem::path program;    // run as `program shard --task FILE` on nodes
  std::string partition;            // empty: Slurm's default
  std::vector<std::string> sbatch;  // further options
  ShardSize size;
  std::uint32_t minutes = 0;                // time limit of a task; 0: the partition's
  std::uint32_t retries = 2;                // further attempts in a row at a shard without a new result
  std::uint32_t in_flight = 1000;           // tasks submitted at a time
  std::chrono::seconds patience{600};       // with a full queue or no node that could run anything
  const std::atomic<bool>* stop = nullptr;  // set from outside: cancels what was submitted
};

class SlurmEngine : public ReplayEngine {
 public:
  // `worker.path` and the folders must be there on every node.
  SlurmEngine(WorkerProgram worker, SlurmOptions options) : worker_(std::move(worker)), options_(std::move(options)) {}
  void replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) override;

 private:
  WorkerProgram worker_;
  SlurmOptions options_;
};

}  // namespace subpixel::server
