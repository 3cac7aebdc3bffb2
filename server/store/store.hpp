// The store: everything the service lists or queries, in one SQLite file. All SQL of the service is in store*.cpp and,
// of nights, in server/nightly/night_store.cpp. Every function is safe to call from any thread. They throw SqliteError,
// whose disk_full() tells a full disk apart.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "replay/results/results.hpp"
#include "replay/results/worker_protocol.hpp"
#include "server/store/large_blobs.hpp"
#include "server/store/sqlite.hpp"

namespace subpixel::server {

// NOLINTNEXTLINE(bugprone-exception-escape): moving JSON is declared noexcept
struct CaptureRecord {
  std::string hash;
  std::string name;  // as uploaded
  std::uint64_t size_bytes = 0;
  std::string uploaded_utc;
  std::string title;
  std::uint32_t frame_count = 0, width = 0, height = 0;
  std::uint64_t triangles = 0;           // of the frame that has most
  nlohmann::json summary;                // of `subpixel info --json`
  std::optional<std::string> thumbnail;  // blob hash
  std::vector<std::string> tags;         // in their order
};

enum class RunKind { run, thumbnail };
enum class RunStatus { queued, running, done, failed, cancelled };
std::string_view to_text(RunKind kind);
std::string_view to_text(RunStatus status);
constexpr bool is_final(RunStatus status) {
  return status != RunStatus::queued && status != RunStatus::running;
}

// How a run shares the workers with others.
struct QueuePlace {
  std::uint32_t priority = 5;  // the highest first
  std::uint32_t retries = 2;   // starts in a row without a new result, after the first
  std::string submitter;       // those with runs of the same priority take turns
};

struct RunRecord {
  std::int64_t id = 0;
  RunKind kind = RunKind::run;
  std::string capture;
  std::string capture_name, capture_title;  // of the capture's record
  RunStatus status = RunStatus::queued;
  std::string reason;
  std::string created_utc, started_utc, finished_utc;  // empty until it happens
  replay::ReplayOptions options;                       // techniques with every parameter filled in, `skip` empty
  std::optional<nlohmann::json> head;
  std::uint64_t expected_results = 0, stored_results = 0;
  std::uint32_t starts_without_result = 0;
  QueuePlace place;
};

// A result as it is read back: its event number, the place of its technique in the run's list, and its FrameResult in
// JSON form, images named by blob hash.
struct StoredResult {
  std::int64_t sequence = 0;
  std::uint32_t technique_ordinal = 0;
  nlohmann::json document;
};

struct Blob {
  std::string media_type;
  std::string bytes;
};

struct BlobInfo {
  std::string media_type;
  std::uint64_t size_bytes = 0;
};

struct StoreCounts {
  std::uint64_t captures = 0, runs = 0, queued = 0, running = 0;
};

// What there is, for whoever watches the service.
struct StoreGauges {
  struct Runs {
    std::string kind, status, reason;
    std::uint64_t count = 0;
  };
  std::vector<Runs> runs;
  std::map<std::string, double> stage_seconds;  // of all stored runs' heads
  std::uint64_t results = 0, captures = 0, capture_bytes = 0, store_bytes = 0, store_free_bytes = 0;
};

class Store {
 public:
  // Opens or creates the file and brings it to this program's version. Throws InputError for a newer or foreign one.
  explicit Store(const std::filesystem::path& file);
  ~Store();

  // False when the hash is stored already; then nothing changes.
  bool add_capture(const CaptureRecord& capture);
  std::optional<CaptureRecord> capture(std::string_view hash) const;
  // Newest first, at most `limit` after the first `offset`.
  std::vector<CaptureRecord> captures(std::uint32_t limit, std::uint64_t offset) const;
  void set_thumbnail(std::string_view capture, std::string_view blob);

  enum class Deletion { deleted, missing, in_use };
  // Deletes the capture with its runs and the blobs nothing else names; in_use while one of its runs is queued or runs.
  Deletion delete_capture(std::string_view hash);
  Deletion delete_run(std::int64_t id);

  // Queues a run and returns its id; nothing when the capture is gone.
  std::optional<std::int64_t> add_run(RunKind kind, std::string_view capture, const replay::ReplayOptions& options,
                                      std::uint64_t expected_results, const QueuePlace& place = {});
  std::optional<RunRecord> run(std::int64_t id) const;
  // Runs of kind `run`, newest first, ids below `before` (0: from the newest), of one capture or of all (empty).
  std::vector<RunRecord> runs(std::uint32_t limit, std::int64_t before, std::string_view capture) const;

  // Takes the next queued run and marks it as running: thumbnails first, then by priority; of those the submitter's
  // who was served longest ago, of that one's the oldest.
  std::optional<RunRecord> start_next_run();
  // Puts a running run back; `reason` stays with it until it ends.
  void requeue(std::int64_t id, std::string_view reason);
  // Puts back what was running when the last process ended. `graceful`: this process is about to end on request, which
  // is not the run's fault, so the count of its starts is forgotten.
  void requeue_running(bool graceful);
  // Ends a queued or running run. False when it had ended before.
  bool finish_run(std::int64_t id, RunStatus status, std::string_view reason);
  // Ends a run as cancelled if no worker has it yet.
  bool cancel_queued(std::int64_t id);
  void set_head(std::int64_t id, const nlohmann::json& head);

  // One commit: the result, its pass times, its images as blobs. `images`: bytes and media type by role; the stored
  // document names them by hash. Returns false, storing nothing, when this frame and technique are stored already
  // or the run was deleted.
  bool add_result(std::int64_t run, std::uint32_t technique_ordinal, const replay::FrameResult& result,
                  const std::map<std::string, Blob>& images);
  // (frame, technique ordinal) of every stored result, the form of ReplayOptions::skip.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stored_pairs(std::int64_t run) const;
  // Results with a sequence above `after`, in that order; at most `limit`.
  std::vector<StoredResult> results_after(std::int64_t run, std::int64_t after, std::uint32_t limit) const;
  // All results by frame, then in the request's order.
  std::vector<StoredResult> results(std::int64_t run) const;
  // Their documents alone, as one JSON array.
  std::string results_text(std::int64_t run) const;

  // Replaces the tags of a capture; false when there is no such capture.
  bool set_tags(std::string_view capture, const std::vector<std::string>& tags);
  // By name, then by hash.
  std::vector<CaptureRecord> captures_with_tag(std::string_view tag) const;

  std::optional<Blob> blob(std::string_view hash) const;
  std::optional<BlobInfo> blob_info(std::string_view hash) const;
  // Hands `length` bytes of a blob from `first` on to `take`, in pieces. False when that says so.
  bool read_blob(std::string_view hash, std::uint64_t first, std::uint64_t length,
                 const std::function<bool(std::string_view)>& take) const;
  // Stores the bytes once, in a row or outside of it by their size, and returns their hash. Within a transaction of the
  // store's writer: what is outside is lasting before the row is. Throws InputError for other bytes with the hash of
  // stored ones.
  std::string store_blob(const Connection& writer, const Blob& blob);
  // Deletes blobs' bytes outside of rows, of those that no row names any more. Not within a transaction.
  void remove_outside(const std::vector<std::string>& hashes);
  LargeBlobs& large_blobs() { return *large_; }
  StoreCounts counts() const;
  StoreGauges gauges() const;
  // Whether it takes writes now: throws SqliteError as a write would.
  void probe();

  // For parts of the store with SQL of their own (store_access.hpp): a connection to read with, and the one that
  // writes, which nobody else has for as long as the lease is held.
  class ReadLease;
  class WriteLease;
  ReadLease read() const;
  WriteLease write();

 private:
  void remove_outside_locked(const std::vector<std::string>& hashes);

  std::filesystem::path file_;
  std::unique_ptr<LargeBlobs> large_;
  std::optional<std::uint64_t> large_bytes_;  // blobs from this size on are stored outside
  mutable std::mutex write_mutex_;            // guards writer_
  mutable Connection writer_;
  // Readers see a snapshot each (WAL), so that lists stay quick while a result with its images is committed.
  mutable std::mutex readers_mutex_;
  mutable std::vector<std::unique_ptr<Connection>> idle_readers_;
};

// The version of the store that `connection` has open, and the newest that this program knows.
std::int64_t schema_version(const Connection& connection);
std::int64_t newest_schema_version();

// The schema's steps in order; step i takes version i to version i + 1. Applies those `connection` lacks, each in one
// transaction with its version number. Throws InputError when the store is newer than the steps.
void migrate(const Connection& connection, const std::vector<std::string_view>& steps,
             const std::filesystem::path& file);

// Blobs have no owner. This is true of those that nothing names.
constexpr std::string_view kBlobIsUnnamed =
    "NOT EXISTS (SELECT 1 FROM images WHERE blob = blobs.hash) "
    "AND NOT EXISTS (SELECT 1 FROM night_images WHERE blob = blobs.hash) "
    "AND NOT EXISTS (SELECT 1 FROM captures WHERE thumbnail = blobs.hash)";
// Deletes the rows of those of these blobs that nothing names: of what was deleted, for looking through all blobs takes
// too long. Returns the hashes of those whose bytes are outside, for Store::remove_outside() after the commit.
std::vector<std::string> delete_unnamed_blobs(const Connection& connection, const std::vector<std::string>& hashes);
// The first column of all rows.
std::vector<std::string> texts(Statement& select);

// From which size on blobs are stored outside; none: no blob is.
std::optional<std::uint64_t> large_blob_bytes(const Connection& connection);

// Now, as "2025-01-31T12:00:00.123Z".
std::string utc_now();

}  // namespace subpixel::server
