// `--engine` and what goes with it, of the verbs that replay.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/engine/replay_engine.hpp"

namespace subpixel::cli {

struct EngineFlags {
  std::string engine = "local", shared, partition;
  std::vector<std::string> sbatch;
  double shard_seconds = 300;
  std::uint32_t first_results = 16, minutes = 0, retries = 2, tasks = 1000, patience_s = 600;
};

std::shared_ptr<EngineFlags> add_engine_options(CLI::App& verb);

// The engine asked for. `shared` is the folder that nodes see unless a flag names another one, `cache` that of
// references in it. For `local` there is none: the caller has its own. Throws UsageError for flags of slurm without it.
std::unique_ptr<server::ReplayEngine> make_engine(const EngineFlags& flags, const server::WorkerProgram& worker,
                                                  const std::filesystem::path& shared,
                                                  const std::filesystem::path& cache);

}  // namespace subpixel::cli
