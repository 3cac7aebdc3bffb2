// `subpixel store gc`: what need not stay.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "base/error.hpp"
#include "server/store/store_access.hpp"
#include "server/store/upkeep.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

// Blobs deleted in one transaction: a service waits for the store for no longer.
constexpr std::size_t kAtATime = 32;
// A file without a row may be an upload that gets its row in a moment.
constexpr std::chrono::hours kFreshTime{1};

std::string utc_days_ago(std::uint32_t days) {
  const auto then = std::chrono::system_clock::now() - std::chrono::days(days);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(then)));
}

class Collection {
 public:
  Collection(const DataFolder& folder, Store& store, const Retention& retention, bool dry,
             const CacheCheck& cache_is_whole)
      : folder_(folder), store_(store), retention_(retention), dry_(dry), cache_is_whole_(cache_is_whole) {}

  Freed run() {
    choose();
    if (!dry_) {
      delete_rows("DELETE FROM runs WHERE id = ? AND status NOT IN ('queued', 'running')", runs_);
      delete_rows("DELETE FROM nights WHERE id = ? AND id NOT IN (SELECT night FROM baselines)", nights_);
      delete_rows(
          "DELETE FROM captures WHERE hash = ?1 AND NOT EXISTS (SELECT 1 FROM runs WHERE capture = ?1 AND kind = "
          "'run') AND NOT EXISTS (SELECT 1 FROM capture_tags WHERE capture = ?1)",
          captures_);
      delete_blobs();
    }
    remove_outside();
    remove_captures();
    remove_cached();
    return freed_;
  }

 private:
  // What goes, and the blobs that then nothing names, in tables of the connection's own.
  void choose() {
    const Connection c(folder_.store());
    c.execute(
        "CREATE TEMP TABLE gone_runs (id INTEGER PRIMARY KEY); CREATE TEMP TABLE gone_nights (id INTEGER PRIMARY KEY); "
        "CREATE TEMP TABLE gone_captures (hash TEXT PRIMARY KEY); BEGIN");
    choose_rows(c);
    choose_captures(c);
    Statement blobs(c,
                    "SELECT hash, length(bytes), outside FROM blobs WHERE "
                    "NOT EXISTS (SELECT 1 FROM images i JOIN frame_results f ON f.id = i.result JOIN runs r ON r.id = "
                    "f.run WHERE i.blob = blobs.hash AND f.run NOT IN gone_runs AND r.capture NOT IN gone_captures) "
                    "AND NOT EXISTS (SELECT 1 FROM night_images i JOIN night_frames f ON f.id = i.frame JOIN "
                    "night_cells n ON n.id = f.cell WHERE i.blob = blobs.hash AND n.night NOT IN gone_nights) "
                    "AND NOT EXISTS (SELECT 1 FROM captures WHERE thumbnail = blobs.hash AND hash NOT IN "
                    "gone_captures)");
    while (blobs.step()) {
      blobs_.push_back(blobs.text());
      freed_.store_bytes += static_cast<std::uint64_t>(blobs.integer());
      if (const std::optional<std::string> outside = blobs.optional_text()) {
        ++freed_.files;
        freed_.file_bytes += std::stoull(*outside);
      }
    }
    freed_.blobs = blobs_.size();
    runs_ = keys_of(c, "SELECT id FROM gone_runs");
    nights_ = keys_of(c, "SELECT id FROM gone_nights");
    captures_ = keys_of(c, "SELECT hash FROM gone_captures");
    freed_.runs = runs_.size();
    freed_.nights = nights_.size();
    freed_.captures = captures_.size();
  }

  void choose_rows(const Connection& c) const {
    if (!retention_.days && !retention_.count) return;
    // One of the rules alone says nothing of those the other would keep.
    const std::string before = retention_.days ? utc_days_ago(*retention_.days) : "9999";
    const std::int64_t count = retention_.count.value_or(0);
    Statement(c,
              "INSERT INTO gone_runs SELECT id FROM (SELECT id, status, coalesce(finished_utc, created_utc) AS ended, "
              "row_number() OVER (PARTITION BY capture, kind ORDER BY id DESC) AS place FROM runs) "
              "WHERE status NOT IN ('queued', 'running') AND place > ? AND ended < ?")
        .bind(count)
        .bind(before)
        .run();
    Statement(
        c,
        "INSERT INTO gone_nights SELECT id FROM (SELECT id, status, coalesce(finished_utc, started_utc) AS ended, "
        "row_number() OVER (PARTITION BY name ORDER BY id DESC) AS place FROM nights) "
        "WHERE status <> 'running' AND place > ? AND ended < ? AND id NOT IN (SELECT night FROM baselines)")
        .bind(count)
        .bind(before)
        .run();
    // What a night that stays was compared with stays, and so on.
    do {
      c.execute(
          "DELETE FROM gone_nights WHERE id IN (SELECT baseline_night FROM nights WHERE id NOT IN gone_nights AND "
          "baseline_night IS NOT NULL)");
    } while (c.changes() > 0);
  }

  void choose_captures(const Connection& c) const {
    if (!retention_.captures) return;
    if (!retention_.days) throw UsageError("can't delete captures", "how old they must be is not said", "--keep-days");
    const std::string before = utc_days_ago(*retention_.days);
    Statement(c,
              "INSERT INTO gone_captures SELECT hash FROM captures c WHERE uploaded_utc < ? "
              "AND NOT EXISTS (SELECT 1 FROM capture_tags WHERE capture = c.hash) "
              "AND NOT EXISTS (SELECT 1 FROM runs WHERE capture = c.hash AND kind = 'run' AND id NOT IN gone_runs) "
              "AND hash NOT IN (SELECT hash FROM night_captures WHERE night NOT IN gone_nights)")
        .bind(before)
        .run();
  }

  static std::vector<std::string> keys_of(const Connection& c, const char* sql) {
    Statement select(c, sql);
    return texts(select);
  }

  // One at a time: a night of ten thousand results takes seconds.
  void delete_rows(const char* sql, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
      const Store::WriteLease writer = store_.write();
      Statement(writer.connection(), sql).bind(key).run();
    }
  }

  // Those chosen that nothing names now; what came to be unnamed since waits for the next time.
  void delete_blobs() {
    for (std::size_t first = 0; first < blobs_.size(); first += kAtATime) {
      const auto begin = blobs_.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = begin + static_cast<std::ptrdiff_t>(std::min(kAtATime, blobs_.size() - first));
      std::vector<std::string> outside;
      {
        const Store::WriteLease writer = store_.write();
        Transaction transaction(writer.connection());
        outside = delete_unnamed_blobs(writer.connection(), {begin, end});
        transaction.commit();
      }
      store_.remove_outside(outside);
    }
  }

  // Of blobs that have no row: of a writer that died before its commit, or a deletion that did before its end.
  void remove_outside() {
    std::vector<std::string> left;
    const auto take = [&](const std::string& hash, std::uint64_t bytes) {
      const Store::ReadLease reader = store_.read();
      Statement row(reader.connection(), "SELECT 1 FROM blobs WHERE hash = ? AND outside IS NOT NULL");
      if (row.bind(hash).step()) return;
      ++freed_.files;
      freed_.file_bytes += bytes;
      left.push_back(hash);
    };
    store_.large_blobs().each(take);
    if (dry_) return;
    for (std::size_t first = 0; first < left.size(); first += kAtATime) {
      const auto begin = left.begin() + static_cast<std::ptrdiff_t>(first);
      store_.remove_outside({begin, begin + static_cast<std::ptrdiff_t>(std::min(kAtATime, left.size() - first))});
    }
    freed_.files += store_.large_blobs().remove_unfinished();
  }

  void remove(const fs::directory_entry& entry) {
    const std::uint64_t size = entry.is_regular_file() ? entry.file_size() : 0;
    if (!dry_) fs::remove(entry.path());
    ++freed_.files;
    freed_.file_bytes += size;
  }

  static bool older_than(const fs::directory_entry& entry, std::chrono::seconds age) {
    return entry.last_write_time() + age < fs::file_time_type::clock::now();
  }

  void remove_captures() {
    const std::set<std::string> gone(captures_.begin(), captures_.end());
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.captures())) {
      const std::string hash = entry.path().stem().string();
      const bool chosen = gone.contains(hash);
      if (!chosen && !older_than(entry, kFreshTime)) continue;
      // Under the write lock no upload can get its row in between; one that had only its file then looks again.
      const Store::WriteLease writer = store_.write();
      const Transaction transaction(writer.connection());
      Statement row(writer.connection(), "SELECT 1 FROM captures WHERE hash = ?");
      const bool named = row.bind(hash).step();
      if (!named || (dry_ && chosen)) remove(entry);
    }
  }

  void remove_cached() {
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.cache(), none)) {
      if (entry.is_directory()) continue;  // the driver's own, which it keeps small itself
      const bool old = retention_.cache_days && older_than(entry, std::chrono::days(*retention_.cache_days));
      // One that is being written has another name until it is whole.
      if (old || (older_than(entry, kFreshTime) && !cache_is_whole_(entry.path()))) remove(entry);
    }
  }

  const DataFolder& folder_;
  Store& store_;
  const Retention& retention_;
  const bool dry_;
  const CacheCheck& cache_is_whole_;
  Freed freed_;
  std::vector<std::string> runs_, nights_, captures_, blobs_;
};

}  // namespace

Freed collect_garbage(const DataFolder& folder, Store& store, const Retention& retention, bool dry,
                      const CacheCheck& cache_is_whole) {
  try {
    return Collection(folder, store, retention, dry, cache_is_whole).run();
  } catch (const fs::filesystem_error& error) {
    throw InputError("can't delete all that may go", error.code().message(), error.path1().string());
  }
}

std::uint64_t compact(const DataFolder& folder) {
  const std::uint64_t before = fs::file_size(folder.store());
  {
    const Connection connection(folder.store());
    connection.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)");
  }
  const std::uint64_t after = fs::file_size(folder.store());
  return after < before ? before - after : 0;
}

}  // namespace subpixel::server
