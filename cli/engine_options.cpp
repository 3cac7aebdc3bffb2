#include "cli/engine_options.hpp"

#include <atomic>
#include <csignal>

#include "base/error.hpp"
#include "server/engine/slurm_engine.hpp"

namespace subpixel::cli {
namespace {

// Signals can reach nothing else. NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> stop_asked{false};

void ask_to_stop(int) {
  stop_asked = true;
}

}  // namespace

std::shared_ptr<EngineFlags> add_engine_options(CLI::App& verb) {
  const auto flags = std::make_shared<EngineFlags>();
  verb.add_option("--engine", flags->engine, "Where captures are replayed: local, or slurm (docs/nightly.md)")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  const auto group = [&](CLI::Option* option) { return option->group("With --engine slurm"); };
  group(verb.add_option("--shared", flags->shared,
                        "Folder that is at the same path on every node; default: the one results go to"));
  group(verb.add_option("--partition", flags->partition, "Partition; default: Slurm's"));
  group(verb.add_option("--sbatch", flags->sbatch,
                        "An option for sbatch, as --sbatch=--exclusive; more than once for more")
            ->allow_extra_args(false));
  group(verb.add_option("--shard-seconds", flags->shard_seconds, "Work of a shard by the last night's times")
            ->check(CLI::Range(1.0, 1e6))
            ->capture_default_str());
  group(verb.add_option("--shard-results", flags->first_results,
                        "Results (frame x technique) of a shard where no times are known")
            ->check(CLI::Range(1, 1'000'000))
            ->capture_default_str());
  group(verb.add_option("--shard-minutes", flags->minutes, "Time limit of a shard; default: the partition's")
            ->check(CLI::Range(1, 1'000'000)));
  group(verb.add_option("--shard-retries", flags->retries,
                        "Further attempts in a row at a shard that was lost without a new result")
            ->check(CLI::Range(0, 100))
            ->capture_default_str());
  group(verb.add_option("--slurm-tasks", flags->tasks, "Most tasks submitted at a time")
            ->check(CLI::Range(1, 1'000'000))
            ->capture_default_str());
  group(verb.add_option("--slurm-patience", flags->patience_s,
                        "Seconds to wait while the queue is full or no node can run anything")
            ->check(CLI::Range(0, 1'000'000))
            ->capture_default_str());
  return flags;
}

std::unique_ptr<server::ReplayEngine> make_engine(const EngineFlags& flags, const server::WorkerProgram& worker,
                                                  const std::filesystem::path& shared,
                                                  const std::filesystem::path& cache) {
  if (flags.engine != "slurm") {
    if (!flags.shared.empty() || !flags.partition.empty() || !flags.sbatch.empty()) {
      throw UsageError("command line", "it is of --engine slurm", "--shared, --partition, --sbatch");
    }
    return nullptr;
  }
  server::SlurmOptions options;
  options.shared = std::filesystem::absolute(flags.shared.empty() ? shared : std::filesystem::path(flags.shared));
  options.cache = flags.shared.empty() ? std::filesystem::absolute(cache) : options.shared / "cache";
  options.program = std::filesystem::read_symlink("/proc/self/exe");
  options.partition = flags.partition;
  options.sbatch = flags.sbatch;
  options.size = {flags.shard_seconds, flags.first_results};
  options.minutes = flags.minutes;
  options.retries = flags.retries;
  options.in_flight = flags.tasks;
  options.patience = std::chrono::seconds(flags.patience_s);
  options.stop = &stop_asked;
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  return std::make_unique<server::SlurmEngine>(worker, options);
}

}  // namespace subpixel::cli
