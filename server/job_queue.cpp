#include "server/job_queue.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <spdlog/spdlog.h>

#include "base/atomic_file.hpp"
#include "base/failure.hpp"
#include "base/log_fields.hpp"
#include "server/worker_session.hpp"

namespace subpixel::server {
namespace {

struct Verdict {
  RunStatus status;
  std::string reason;
};

Verdict judge(const ChildOutcome& outcome, const WorkerSession& session) {
  using Kind = ChildOutcome::Kind;
  if (outcome.kind == Kind::refused) return {RunStatus::failed, session.refusal()};
  if (!session.worker_error().empty()) return {RunStatus::failed, session.worker_error()};
  if (!outcome.reason.empty()) return {RunStatus::failed, session.place().end_in_words(outcome)};
  if (!session.done()) return {RunStatus::failed, "the worker process ended without saying that it was done"};
  if (!session.complete()) return {RunStatus::failed, "the worker process left out results"};
  return {RunStatus::done, ""};
}

// Whether it can have been the machine's fault: memory ran out, someone killed it, a driver crashed once.
bool died(const ChildOutcome& outcome) {
  return outcome.kind == ChildOutcome::Kind::signalled && outcome.code != SIGXCPU;
}

}  // namespace

Confinement confined(const WorkerOptions& worker, const std::vector<std::filesystem::path>& readable,
                     const std::vector<std::filesystem::path>& writable) {
  Confinement confinement;
  confinement.readable = worker.readable;
  for (const std::filesystem::path& path : readable) confinement.readable.push_back(path.string());
  for (const std::filesystem::path& path : writable) confinement.writable.push_back(path.string());
  return confinement;
}

JobQueue::JobQueue(Store& store, const DataFolder& folder, RunEvents& events, WorkerOptions options)
    : store_(store), folder_(folder), events_(events), options_(std::move(options)) {}

JobQueue::~JobQueue() {
  stop();
}

void JobQueue::start() {
  store_.requeue_running(false);
  for (std::uint32_t i = 0; i < options_.count; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
}

void JobQueue::notify() {
  const std::lock_guard lock(mutex_);
  ++additions_;
  wake_.notify_all();
}

bool JobQueue::cancel(std::int64_t run) {
  const std::lock_guard lock(mutex_);  // a run that is started again is queued and active for a moment
  if (store_.cancel_queued(run)) {
    events_.changed(run);
    return true;
  }
  const auto found = active_.find(run);
  return found != active_.end() && (found->second.request_stop() || found->second.stop_requested());
}

void JobQueue::stop() {
  if (threads_.empty()) return;
  for (std::jthread& thread : threads_) thread.request_stop();
  threads_.clear();  // joins
  store_.requeue_running(true);
}

void JobQueue::work(const std::stop_token& stop) {
  std::uint64_t seen = 0;
  while (!stop.stop_requested()) {
    std::optional<RunRecord> run;
    try {
      {
        const std::lock_guard lock(mutex_);
        seen = additions_;
      }
      // Under the lock no cancel can fall between taking the run and being able to stop it.
      const std::lock_guard lock(mutex_);
      run = store_.start_next_run();
      if (run) active_.emplace(run->id, std::stop_source());
    } catch (const std::exception& error) {
      spdlog::error("taking the next run: {}", error.what());
    }
    if (!run) {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, std::chrono::seconds(5), [&] { return additions_ != seen; });
      continue;
    }
    events_.changed(run->id);
    {
      const LogField field("run", std::to_string(run->id));
      execute(*run, stop);
    }
    events_.clear_progress(run->id);
    events_.changed(run->id);
    const std::lock_guard lock(mutex_);
    active_.erase(run->id);
  }
}

void JobQueue::execute(const RunRecord& run, const std::stop_token& stop) {
  std::stop_token cancelled;
  {
    const std::lock_guard lock(mutex_);
    cancelled = active_.at(run.id).get_token();
  }
  if (run.starts_without_result > run.place.retries + 1) {
    finish(run.id, RunStatus::failed,
           fmt::format("{}; given up after {} starts without a new result",
                       run.reason.empty() ? "the service ended while it ran" : run.reason, run.place.retries + 1),
           stop);
    return;
  }
  const std::filesystem::path job_folder = folder_.job(run.id);
  Verdict verdict{RunStatus::failed, ""};
  bool interrupted = false, can_go_on = false;
  try {
    std::filesystem::remove_all(job_folder);
    std::filesystem::create_directories(job_folder / "out");
    replay::ReplayJob job{folder_.capture(run.capture), job_folder / "out", folder_.cache(), run.options};
    job.options.skip = store_.stored_pairs(run.id);
    const std::filesystem::path job_file = job_folder / "job.json";
    write_file_atomically(job_file, replay::to_json(job).dump());

    WorkerSession session(store_, events_, run, job.out_dir, job.options.skip);
    std::stop_source either;
    const std::stop_callback on_shutdown(stop, [&] { either.request_stop(); });
    const std::stop_callback on_cancel(cancelled, [&] { either.request_stop(); });
    ChildLimits limits = options_.limits;
    limits.confinement = confined(options_, {job.capture}, {job_folder, folder_.cache()});
    limits.environment.push_back("MESA_SHADER_CACHE_DIR=" + (folder_.cache() / "mesa").string());
    const ChildOutcome outcome =
        run_child({options_.program.string(), "worker", "--job", job_file.string()}, limits, either.get_token(),
                  [&](std::string_view line) { return session.take_line(line); });
    interrupted = outcome.kind == ChildOutcome::Kind::stopped && !cancelled.stop_requested();
    verdict = outcome.kind == ChildOutcome::Kind::stopped ? Verdict{RunStatus::cancelled, ""} : judge(outcome, session);
    can_go_on = died(outcome) && session.worker_error().empty() && !session.done();
  } catch (const SqliteError& error) {
    verdict.reason = error.disk_full() ? "the disk is full: results can't be stored"
                                       : fmt::format("results can't be stored: {}", error.what());
  } catch (...) {
    verdict.reason = failure_of(std::current_exception()).message;
  }
  std::error_code ignored;  // what stays is removed at the next start
  std::filesystem::remove_all(job_folder, ignored);
  if (interrupted) return;  // stays `running` in the store, from where stop() puts it back
  if (can_go_on) {
    spdlog::warn("the run's worker is started again: {}", verdict.reason);
    if (start_again(run, verdict.reason)) return;
    verdict = {RunStatus::cancelled, ""};
  }
  finish(run.id, verdict.status, verdict.reason, stop);
}

bool JobQueue::start_again(const RunRecord& run, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (active_.at(run.id).stop_requested()) return false;
  try {
    store_.requeue(run.id, reason);
  } catch (const std::exception& error) {
    // It stays `running`, and is taken up by the service's next start.
    spdlog::error("the run can't be put back in the queue: {}", error.what());
  }
  return true;
}

void JobQueue::finish(std::int64_t run, RunStatus status, const std::string& reason, const std::stop_token& stop) {
  // On a full disk not even this may be storable. The run must not start again by itself, so wait for room.
  while (true) {
    try {
      store_.finish_run(run, status, reason);
      spdlog::log(status == RunStatus::failed ? spdlog::level::warn : spdlog::level::info, "the run ended as {}{}{}",
                  to_text(status), reason.empty() ? "" : ": ", reason);
      return;
    } catch (const std::exception& error) {
      spdlog::error("the run's end can't be stored: {}", error.what());
    }
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, stop, std::chrono::seconds(2), [] { return false; });
    if (stop.stop_requested()) return;
  }
}

}  // namespace subpixel::server
