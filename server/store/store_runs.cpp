// Runs, their results and the queue's state in the store.
#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "base/error.hpp"
#include "server/store/store.hpp"
#include "server/store/store_access.hpp"

namespace subpixel::server {
namespace {

constexpr std::array<std::string_view, 2> kKinds{"run", "thumbnail"};
constexpr std::array<std::string_view, 5> kStatuses{"queued", "running", "done", "failed", "cancelled"};

template <typename Enum, std::size_t N>
Enum from_text(const std::array<std::string_view, N>& names, std::string_view text) {
  for (std::size_t i = 0; i < N; ++i) {
    if (names[i] == text) return static_cast<Enum>(i);
  }
  throw InputError("can't read the store", fmt::format("unknown value {}", text), "runs");
}

constexpr std::string_view kRunColumns =
    "SELECT runs.id, kind, capture, captures.name, captures.title, status, reason, created_utc, started_utc, "
    "finished_utc, request, head, expected_results, (SELECT count(*) FROM frame_results WHERE run = runs.id), "
    "starts_without_result, priority, retries, submitter FROM runs JOIN captures ON captures.hash = runs.capture ";

// The options' JSON form is the worker protocol's, so a run means the same in the store and in a job file.
std::string options_text(const replay::ReplayOptions& options) {
  replay::ReplayJob job;
  job.options = options;
  job.options.skip.clear();
  return replay::to_json(job).dump();
}

RunRecord read_run(Statement& row) {
  RunRecord run;
  run.id = row.integer();
  run.kind = from_text<RunKind>(kKinds, row.text());
  run.capture = row.text();
  run.capture_name = row.text();
  run.capture_title = row.text();
  run.status = from_text<RunStatus>(kStatuses, row.text());
  run.reason = row.text();
  run.created_utc = row.text();
  run.started_utc = row.text();
  run.finished_utc = row.text();
  run.options = replay::replay_job_from_json(nlohmann::json::parse(row.text())).options;
  if (const std::optional<std::string> head = row.optional_text()) run.head = nlohmann::json::parse(*head);
  run.expected_results = static_cast<std::uint64_t>(row.integer());
  run.stored_results = static_cast<std::uint64_t>(row.integer());
  run.starts_without_result = static_cast<std::uint32_t>(row.integer());
  run.place.priority = static_cast<std::uint32_t>(row.integer());
  run.place.retries = static_cast<std::uint32_t>(row.integer());
  run.place.submitter = row.text();
  return run;
}

std::optional<RunRecord> select_run(const Connection& connection, std::int64_t id) {
  Statement select(connection, std::string(kRunColumns) + "WHERE runs.id = ?");
  select.bind(id);
  if (!select.step()) return std::nullopt;
  return read_run(select);
}

std::vector<StoredResult> read_results(Statement& select) {
  std::vector<StoredResult> results;
  while (select.step()) {
    const std::int64_t sequence = select.integer();
    const auto ordinal = static_cast<std::uint32_t>(select.integer());
    results.push_back({sequence, ordinal, nlohmann::json::parse(select.text())});
  }
  return results;
}

std::int64_t insert_result(const Connection& connection, std::int64_t run, std::uint32_t technique_ordinal,
                           const replay::FrameResult& result) {
  const std::string document = replay::to_json(result).dump();
  Statement insert(connection,
                   "INSERT INTO frame_results (run, sequence, frame, technique_ordinal, technique, total_ms, "
                   "fitted_bytes_per_pixel, executions, mse, flip_mean, document) VALUES (?1, "
                   "(SELECT coalesce(max(sequence), 0) + 1 FROM frame_results WHERE run = ?1), ?, ?, ?, ?, ?, ?, ?, ?, "
                   "?)");
  insert.bind(run)
      .bind(std::int64_t{result.frame})
      .bind(std::int64_t{technique_ordinal})
      .bind(result.technique)
      .bind(result.ms.total_ms)
      .bind(result.memory.fitted_bytes_per_pixel)
      .bind(static_cast<std::int64_t>(result.shading.executions))
      .bind(result.error.mse)
      .bind(result.error.flip_mean)
      .bind(document)
      .run();
  return connection.last_insert_id();
}

}  // namespace

std::string_view to_text(RunKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}
std::string_view to_text(RunStatus status) {
  return kStatuses[static_cast<std::size_t>(status)];
}

std::optional<std::int64_t> Store::add_run(RunKind kind, std::string_view capture, const replay::ReplayOptions& options,
                                           std::uint64_t expected_results, const QueuePlace& place) {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  const std::string created = utc_now();
  const std::string request = options_text(options);
  Statement insert(writer_,
                   "INSERT INTO runs (kind, capture, status, created_utc, request, expected_results, priority, "
                   "retries, submitter) SELECT ?, hash, 'queued', ?, ?, ?, ?, ?, ? FROM captures WHERE hash = ?");
  insert.bind(to_text(kind))
      .bind(created)
      .bind(request)
      .bind(static_cast<std::int64_t>(expected_results))
      .bind(std::int64_t{place.priority})
      .bind(std::int64_t{place.retries})
      .bind(place.submitter)
      .bind(capture)
      .run();
  if (writer_.changes() == 0) return std::nullopt;
  const std::int64_t id = writer_.last_insert_id();
  for (std::size_t i = 0; i < options.techniques.size(); ++i) {
    const replay::TechniqueRequest& technique = options.techniques[i];
    const std::string parameters = nlohmann::json(technique.parameters).dump();
    Statement(writer_, "INSERT INTO run_techniques (run, ordinal, technique, parameters) VALUES (?, ?, ?, ?)")
        .bind(id)
        .bind(static_cast<std::int64_t>(i))
        .bind(technique.technique)
        .bind(parameters)
        .run();
  }
  transaction.commit();
  return id;
}

std::optional<RunRecord> Store::run(std::int64_t id) const {
  const ReadLease reader = read();
  return select_run(reader.connection(), id);
}

std::vector<RunRecord> Store::runs(std::uint32_t limit, std::int64_t before, std::string_view capture) const {
  const ReadLease reader = read();
  std::string sql = std::string(kRunColumns) + "WHERE kind = 'run'";
  if (before > 0) sql += " AND runs.id < ?";
  if (!capture.empty()) sql += " AND capture = ?";
  Statement select(reader.connection(), sql + " ORDER BY runs.id DESC LIMIT ?");
  if (before > 0) select.bind(before);
  if (!capture.empty()) select.bind(capture);
  select.bind(std::int64_t{limit});
  std::vector<RunRecord> runs;
  while (select.step()) runs.push_back(read_run(select));
  return runs;
}

std::optional<RunRecord> Store::start_next_run() {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  std::int64_t id = 0;
  bool is_thumbnail = false;
  {
    Statement next(writer_,
                   "SELECT id, kind = 'thumbnail' AS small FROM runs LEFT JOIN submitters ON name = submitter "
                   "WHERE status = 'queued' "
                   "ORDER BY small DESC, priority DESC, coalesce(last_turn, 0), id LIMIT 1");
    if (!next.step()) return std::nullopt;
    id = next.integer();
    is_thumbnail = next.integer() != 0;
  }
  if (!is_thumbnail) {
    Statement(writer_,
              "INSERT INTO submitters (name, last_turn) "
              "SELECT submitter, (SELECT coalesce(max(last_turn), 0) + 1 FROM submitters) FROM runs WHERE id = ? "
              "ON CONFLICT (name) DO UPDATE SET last_turn = excluded.last_turn")
        .bind(id)
        .run();
    // Who has nothing queued has nothing to wait for; the table stays as small as the queue.
    writer_.execute(
        "DELETE FROM submitters WHERE name NOT IN (SELECT submitter FROM runs WHERE status IN ('queued', 'running'))");
  }
  const std::string now = utc_now();
  Statement(writer_,
            "UPDATE runs SET status = 'running', started_utc = coalesce(started_utc, ?), "
            "starts_without_result = starts_without_result + 1 WHERE id = ?")
      .bind(now)
      .bind(id)
      .run();
  std::optional<RunRecord> run = select_run(writer_, id);
  transaction.commit();
  return run;
}

void Store::requeue(std::int64_t id, std::string_view reason) {
  const std::lock_guard lock(write_mutex_);
  Statement(writer_, "UPDATE runs SET status = 'queued', reason = ? WHERE id = ? AND status = 'running'")
      .bind(reason)
      .bind(id)
      .run();
}

void Store::requeue_running(bool graceful) {
  const std::lock_guard lock(write_mutex_);
  writer_.execute(fmt::format("UPDATE runs SET status = 'queued'{} WHERE status = 'running'",
                              graceful ? ", starts_without_result = 0" : ""));
}

bool Store::finish_run(std::int64_t id, RunStatus status, std::string_view reason) {
  const std::lock_guard lock(write_mutex_);
  const std::string now = utc_now();
  Statement(writer_,
            "UPDATE runs SET status = ?, reason = ?, finished_utc = ? WHERE id = ? AND status IN ('queued', 'running')")
      .bind(to_text(status))
      .bind(reason)
      .bind(now)
      .bind(id)
      .run();
  return writer_.changes() > 0;
}

bool Store::cancel_queued(std::int64_t id) {
  const std::lock_guard lock(write_mutex_);
  const std::string now = utc_now();
  Statement(writer_, "UPDATE runs SET status = 'cancelled', finished_utc = ? WHERE id = ? AND status = 'queued'")
      .bind(now)
      .bind(id)
      .run();
  return writer_.changes() > 0;
}

void Store::set_head(std::int64_t id, const nlohmann::json& head) {
  const std::lock_guard lock(write_mutex_);
  const std::string text = head.dump();
  Statement(writer_, "UPDATE runs SET head = ? WHERE id = ?").bind(text).bind(id).run();
}

bool Store::add_result(std::int64_t run, std::uint32_t technique_ordinal, const replay::FrameResult& result,
                       const std::map<std::string, Blob>& images) {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  {
    Statement wanted(writer_,
                     "SELECT 1 FROM runs WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM frame_results WHERE run = ?1 AND "
                     "frame = ? AND technique_ordinal = ?)");
    wanted.bind(run).bind(std::int64_t{result.frame}).bind(std::int64_t{technique_ordinal});
    if (!wanted.step()) return false;
  }
  replay::FrameResult stored = result;
  stored.images.clear();
  for (const auto& [role, blob] : images) stored.images[role] = store_blob(writer_, blob);

  const std::int64_t id = insert_result(writer_, run, technique_ordinal, stored);
  for (std::size_t i = 0; i < stored.ms.passes.size(); ++i) {
    Statement(writer_, "INSERT INTO pass_times (result, ordinal, name, median_ms) VALUES (?, ?, ?, ?)")
        .bind(id)
        .bind(static_cast<std::int64_t>(i))
        .bind(stored.ms.passes[i].name)
        .bind(stored.ms.passes[i].median_ms)
        .run();
  }
  for (const auto& [role, hash] : stored.images) {
    Statement(writer_, "INSERT INTO images (result, role, blob) VALUES (?, ?, ?)").bind(id).bind(role).bind(hash).run();
  }
  Statement(writer_, "UPDATE runs SET starts_without_result = 0 WHERE id = ?").bind(run).run();
  transaction.commit();
  return true;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> Store::stored_pairs(std::int64_t run) const {
  const ReadLease reader = read();
  Statement select(
      reader.connection(),
      "SELECT frame, technique_ordinal FROM frame_results WHERE run = ? ORDER BY frame, technique_ordinal");
  select.bind(run);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  while (select.step()) {
    const auto frame = static_cast<std::uint32_t>(select.integer());
    pairs.emplace_back(frame, static_cast<std::uint32_t>(select.integer()));
  }
  return pairs;
}

std::vector<StoredResult> Store::results_after(std::int64_t run, std::int64_t after, std::uint32_t limit) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   "SELECT sequence, technique_ordinal, document FROM frame_results WHERE run = ? AND sequence > ? "
                   "ORDER BY sequence "
                   "LIMIT ?");
  select.bind(run).bind(after).bind(std::int64_t{limit});
  return read_results(select);
}

std::vector<StoredResult> Store::results(std::int64_t run) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   "SELECT sequence, technique_ordinal, document FROM frame_results WHERE run = ? ORDER BY frame, "
                   "technique_ordinal");
  select.bind(run);
  return read_results(select);
}

std::string Store::results_text(std::int64_t run) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   "SELECT document FROM frame_results WHERE run = ? ORDER BY frame, technique_ordinal");
  select.bind(run);
  std::string array = "[";
  while (select.step()) array.append(array.size() > 1 ? "," : "").append(select.text());
  return array + "]";
}

}  // namespace subpixel::server
