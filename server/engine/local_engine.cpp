#include <fmt/format.h>

#include <csignal>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/engine/replay_engine.hpp"
#include "server/engine/worker_place.hpp"
#include "server/store/worker_files.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

int exit_code_from(const JsonField& message) {
  const std::uint64_t code = message.has("exit") ? message.member("exit").u64() : 0;
  return code == kUsageExit || code == kInputExit || code == kInternalExit ? static_cast<int>(code) : kDeviceExit;
}

}  // namespace

WorkerEnd replay_in_worker(const replay::ReplayJob& job, const std::filesystem::path& job_file,
                           const WorkerProgram& worker,
                           const std::function<void(std::uint32_t, const replay::FrameResult&)>& take) {
  write_file_atomically(job_file, std::string_view(replay::to_json(job).dump()));
  WorkerEnd ended;
  std::string error;
  WorkerPlace place;
  bool done = false;
  const auto take_line = [&](std::string_view line) {
    try {
      const json document = parse_json_document(line, "worker message", "the line");
      const JsonField message(document, "worker message");
      const std::string type = message.member("type").text();
      if (type == "progress") {
        place.progress(message.member("stage").text(), message.has("detail") ? message.member("detail").text() : "");
      }
      if (type == "head") ended.end.head = replay::results_head_from_json(message.member("head").raw());
      if (type == "result") {
        const std::uint32_t ordinal = message.member("ordinal").u32();
        const replay::FrameResult result = replay::frame_result_from_json(message.member("result").raw());
        if (ordinal >= job.options.techniques.size() || job.options.techniques[ordinal].technique != result.technique)
          throw InputError("worker result", "it is not of this job", printable(result.technique, 60));
        take(ordinal, result);
      }
      if (type == "error") {
        error = printable(message.member("message").text(), 1000);
        ended.end.exit_code = exit_code_from(message);
      }
      if (type == "done") done = true;
      return true;
    } catch (const json::exception& failure) {
      error = printable(failure.what(), 300);
    } catch (const Error& failure) {
      error = printable(failure.what(), 300);
    }
    return false;
  };
  std::filesystem::create_directories(job.out_dir);  // what is not there can't be allowed
  std::filesystem::create_directories(job.cache_dir);
  ChildLimits limits = worker.limits;
  limits.confinement.emplace();
  limits.confinement->readable = {job.capture.string(), job_file.string()};
  limits.confinement->writable = {job.out_dir.string(), job.cache_dir.string()};
  limits.counts_instructions = true;
  limits.environment.push_back("MESA_SHADER_CACHE_DIR=" + (job.cache_dir / "mesa").string());
  const ChildOutcome outcome =
      run_child({worker.path.string(), "worker", "--job", job_file.string()}, limits, {}, take_line);
  ended.killed = outcome.kind == ChildOutcome::Kind::signalled && outcome.code == SIGKILL;
  if (!error.empty()) {
    ended.end.problem = error;
  } else if (!outcome.reason.empty()) {
    ended.end.problem = place.end_in_words(outcome);
  } else if (!done) {
    ended.end.problem = "the worker process ended without saying that it was done";
  }
  return ended;
}

void LocalEngine::replay(const std::vector<ReplayRequest>& requests, const ReplaySink& sink) {
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const ReplayRequest& request = requests[i];
    if (sink.progress) {
      sink.progress(fmt::format("{} ({}/{}): {} techniques", request.name, i + 1, requests.size(),
                                request.job.options.techniques.size()));
    }
    std::filesystem::create_directories(request.job.out_dir);
    const auto take = [&](std::uint32_t ordinal, const replay::FrameResult& result) {
      sink.result(i, ordinal, result, read_worker_images(request.job.out_dir, result));
    };
    WorkerEnd ended = replay_in_worker(request.job, folder_ / "job.json", worker_, take);
    std::filesystem::remove_all(request.job.out_dir);
    sink.end(i, std::move(ended.end));
  }
}

}  // namespace subpixel::server
