// Opening, versions, captures and blobs. Runs are in store_runs.cpp, nights in server/nightly/night_store.cpp.
#include "server/store/store.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "server/store/schema.hpp"
#include "server/store/store_access.hpp"

namespace subpixel::server {
namespace {

constexpr std::string_view kCaptureColumns =
    "SELECT hash, name, size_bytes, uploaded_utc, title, frame_count, width, height, triangles, summary, thumbnail, "
    "(SELECT json_group_array(tag) FROM (SELECT tag FROM capture_tags WHERE capture = captures.hash ORDER BY tag)) "
    "FROM captures ";

CaptureRecord read_capture(Statement& row) {
  CaptureRecord capture;
  capture.hash = row.text();
  capture.name = row.text();
  capture.size_bytes = static_cast<std::uint64_t>(row.integer());
  capture.uploaded_utc = row.text();
  capture.title = row.text();
  capture.frame_count = static_cast<std::uint32_t>(row.integer());
  capture.width = static_cast<std::uint32_t>(row.integer());
  capture.height = static_cast<std::uint32_t>(row.integer());
  capture.triangles = static_cast<std::uint64_t>(row.integer());
  capture.summary = nlohmann::json::parse(row.text());
  capture.thumbnail = row.optional_text();
  capture.tags = nlohmann::json::parse(row.text()).get<std::vector<std::string>>();
  return capture;
}

}  // namespace

std::vector<std::string> delete_unnamed_blobs(const Connection& connection, const std::vector<std::string>& hashes) {
  std::vector<std::string> outside;
  for (const std::string& hash : hashes) {
    Statement gone(connection,
                   fmt::format("DELETE FROM blobs WHERE hash = ? AND {} RETURNING outside", kBlobIsUnnamed));
    gone.bind(hash);
    if (gone.step() && gone.optional_text()) outside.push_back(hash);
  }
  return outside;
}

std::vector<std::string> texts(Statement& select) {
  std::vector<std::string> all;
  while (select.step()) all.push_back(select.text());
  return all;
}

std::optional<std::uint64_t> large_blob_bytes(const Connection& connection) {
  Statement setting(connection, "SELECT value FROM settings WHERE name = 'large_blob_bytes'");
  if (!setting.step()) return std::nullopt;
  return static_cast<std::uint64_t>(setting.integer());
}

std::string utc_now() {
  const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto second = std::chrono::floor<std::chrono::seconds>(now);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(second)),
                     (now - second).count());
}

std::int64_t schema_version(const Connection& connection) {
  Statement version(connection, "PRAGMA user_version");
  version.step();
  return version.integer();
}

std::int64_t newest_schema_version() {
  return static_cast<std::int64_t>(schema_steps().size());
}

void migrate(const Connection& connection, const std::vector<std::string_view>& steps,
             const std::filesystem::path& file) {
  const auto version_of = [&] { return schema_version(connection); };
  const auto newest = static_cast<std::int64_t>(steps.size());
  while (version_of() < newest) {
    Transaction transaction(connection);
    const std::int64_t version = version_of();  // another process may have got here first
    if (version >= newest) break;
    connection.execute(std::string(steps[static_cast<std::size_t>(version)]));
    connection.execute(fmt::format("PRAGMA user_version = {}", version + 1));
    transaction.commit();
  }
  if (version_of() > newest) {
    throw InputError("can't open the store",
                     fmt::format("its version is {}, this program knows up to {}", version_of(), newest),
                     file.string());
  }
}

Store::Store(const std::filesystem::path& file) : file_(file), large_(large_blobs_of(file)), writer_(file) {
  std::vector<std::string_view> steps;
  for (const EmbeddedFile& step : schema_steps()) steps.push_back(step.content);
  migrate(writer_, steps, file);
  large_bytes_ = large_blob_bytes(writer_);
}

Store::~Store() = default;

Store::ReadLease Store::read() const {
  {
    const std::lock_guard lock(readers_mutex_);
    if (!idle_readers_.empty()) {
      std::unique_ptr<Connection> connection = std::move(idle_readers_.back());
      idle_readers_.pop_back();
      return ReadLease(*this, std::move(connection));
    }
  }
  return ReadLease(*this, std::make_unique<Connection>(file_));
}

Store::WriteLease Store::write() {
  return WriteLease(*this);
}

bool Store::add_capture(const CaptureRecord& capture) {
  const std::lock_guard lock(write_mutex_);
  const std::string summary = capture.summary.dump();
  Statement insert(writer_,
                   "INSERT INTO captures (hash, name, size_bytes, uploaded_utc, title, frame_count, width, height, "
                   "triangles, summary) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (hash) DO NOTHING");
  insert.bind(capture.hash)
      .bind(capture.name)
      .bind(static_cast<std::int64_t>(capture.size_bytes))
      .bind(capture.uploaded_utc)
      .bind(capture.title)
      .bind(std::int64_t{capture.frame_count})
      .bind(std::int64_t{capture.width})
      .bind(std::int64_t{capture.height})
      .bind(static_cast<std::int64_t>(capture.triangles))
      .bind(summary)
      .run();
  return writer_.changes() > 0;
}

std::optional<CaptureRecord> Store::capture(std::string_view hash) const {
  const ReadLease reader = read();
  Statement select(reader.connection(), std::string(kCaptureColumns) + "WHERE hash = ?");
  select.bind(hash);
  if (!select.step()) return std::nullopt;
  return read_capture(select);
}

std::vector<CaptureRecord> Store::captures_with_tag(std::string_view tag) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   std::string(kCaptureColumns) +
                       "WHERE hash IN (SELECT capture FROM capture_tags WHERE tag = ?) ORDER BY name, hash");
  select.bind(tag);
  std::vector<CaptureRecord> captures;
  while (select.step()) captures.push_back(read_capture(select));
  return captures;
}

bool Store::set_tags(std::string_view capture, const std::vector<std::string>& tags) {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  {
    Statement known(writer_, "SELECT 1 FROM captures WHERE hash = ?");
    known.bind(capture);
    if (!known.step()) return false;
  }
  Statement(writer_, "DELETE FROM capture_tags WHERE capture = ?").bind(capture).run();
  for (const std::string& tag : tags) {
    Statement(writer_, "INSERT INTO capture_tags (capture, tag) VALUES (?, ?) ON CONFLICT DO NOTHING")
        .bind(capture)
        .bind(tag)
        .run();
  }
  transaction.commit();
  return true;
}

std::vector<CaptureRecord> Store::captures(std::uint32_t limit, std::uint64_t offset) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   std::string(kCaptureColumns) + "ORDER BY uploaded_utc DESC, hash LIMIT ? OFFSET ?");
  select.bind(std::int64_t{limit}).bind(static_cast<std::int64_t>(offset));
  std::vector<CaptureRecord> captures;
  while (select.step()) captures.push_back(read_capture(select));
  return captures;
}

void Store::set_thumbnail(std::string_view capture, std::string_view blob) {
  const std::lock_guard lock(write_mutex_);
  Statement(writer_, "UPDATE captures SET thumbnail = ? WHERE hash = ?").bind(blob).bind(capture).run();
}

Store::Deletion Store::delete_capture(std::string_view hash) {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  {
    // A thumbnail is the service's own wish and no reason to refuse; add_result() copes with its run being gone.
    Statement active(
        writer_, "SELECT 1 FROM runs WHERE capture = ? AND kind = 'run' AND status IN ('queued', 'running') LIMIT 1");
    active.bind(hash);
    if (active.step()) return Deletion::in_use;
  }
  Statement named(
      writer_,
      "SELECT DISTINCT i.blob FROM runs r JOIN frame_results f ON f.run = r.id JOIN images i ON i.result = f.id "
      "WHERE r.capture = ?1 UNION SELECT thumbnail FROM captures WHERE hash = ?1 AND thumbnail IS NOT NULL");
  const std::vector<std::string> blobs = texts(named.bind(hash));
  Statement(writer_, "DELETE FROM captures WHERE hash = ?").bind(hash).run();
  if (writer_.changes() == 0) return Deletion::missing;
  const std::vector<std::string> outside = delete_unnamed_blobs(writer_, blobs);
  transaction.commit();
  remove_outside_locked(outside);
  return Deletion::deleted;
}

Store::Deletion Store::delete_run(std::int64_t id) {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  {
    Statement active(writer_, "SELECT status IN ('queued', 'running') FROM runs WHERE id = ?");
    active.bind(id);
    if (!active.step()) return Deletion::missing;
    if (active.integer() != 0) return Deletion::in_use;
  }
  Statement named(writer_,
                  "SELECT DISTINCT i.blob FROM frame_results f JOIN images i ON i.result = f.id WHERE f.run = ?");
  const std::vector<std::string> blobs = texts(named.bind(id));
  Statement(writer_, "DELETE FROM runs WHERE id = ?").bind(id).run();
  const std::vector<std::string> outside = delete_unnamed_blobs(writer_, blobs);
  transaction.commit();
  remove_outside_locked(outside);
  return Deletion::deleted;
}

// XXH3 is no cryptographic hash: equal hashes of different bytes are refused, not mixed up.
std::string Store::store_blob(const Connection& writer, const Blob& blob) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(blob.bytes));
  std::string hash = content_hash_hex(bytes);
  Statement same(writer,
                 "SELECT outside, CASE WHEN outside IS NULL THEN bytes = ? ELSE 0 END FROM blobs WHERE hash = ?");
  same.bind(bytes).bind(hash);
  if (same.step()) {
    std::string_view left = blob.bytes;
    const auto is_next = [&](std::string_view part) {
      if (left.substr(0, part.size()) != part) return false;
      left.remove_prefix(part.size());
      return true;
    };
    const bool outside = same.optional_text().has_value(), inside_equal = same.integer() == 1;
    const bool equal =
        outside ? large_->size(hash) == blob.bytes.size() && large_->read(hash, 0, left.size(), is_next) : inside_equal;
    if (!equal) throw InputError("can't store an image", "another one has its content hash", hash);
    return hash;
  }
  Statement insert(writer, "INSERT INTO blobs (hash, media_type, bytes, outside) VALUES (?, ?, ?, ?)");
  insert.bind(hash).bind(blob.media_type);
  if (large_bytes_ && blob.bytes.size() >= *large_bytes_) {
    large_->put(hash, blob.bytes);
    insert.bind(std::span<const std::byte>()).bind(static_cast<std::int64_t>(blob.bytes.size()));
  } else {
    insert.bind(bytes).bind(nullptr);
  }
  insert.run();
  return hash;
}

void Store::remove_outside(const std::vector<std::string>& hashes) {
  const std::lock_guard lock(write_mutex_);
  remove_outside_locked(hashes);
}

// Under the write lock nobody stores one of them in between. What can't be deleted is garbage for `store gc`: it is no
// failure of what its row was deleted for.
void Store::remove_outside_locked(const std::vector<std::string>& hashes) {
  if (hashes.empty()) return;
  try {
    const Transaction transaction(writer_);
    for (const std::string& hash : hashes) {
      Statement named(writer_, "SELECT 1 FROM blobs WHERE hash = ? AND outside IS NOT NULL");
      if (!named.bind(hash).step()) large_->remove(hash);
    }
  } catch (const SqliteError&) {  // NOLINT(bugprone-empty-catch)
  }
}

std::optional<Blob> Store::blob(std::string_view hash) const {
  const ReadLease reader = read();
  Statement select(reader.connection(), "SELECT media_type, bytes, outside FROM blobs WHERE hash = ?");
  select.bind(hash);
  if (!select.step()) return std::nullopt;
  Blob blob;
  blob.media_type = select.text();
  blob.bytes = select.blob();
  const std::optional<std::string> outside = select.optional_text();
  if (!outside) return blob;
  const bool is_there = large_->read(std::string(hash), 0, std::stoull(*outside), [&](std::string_view part) {
    blob.bytes.append(part);
    return true;
  });
  return is_there ? std::optional(std::move(blob)) : std::nullopt;
}

std::optional<BlobInfo> Store::blob_info(std::string_view hash) const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   "SELECT media_type, coalesce(outside, length(bytes)) FROM blobs WHERE hash = ?");
  select.bind(hash);
  if (!select.step()) return std::nullopt;
  BlobInfo info;
  info.media_type = select.text();
  info.size_bytes = static_cast<std::uint64_t>(select.integer());
  return info;
}

bool Store::read_blob(std::string_view hash, std::uint64_t first, std::uint64_t length,
                      const std::function<bool(std::string_view)>& take) const {
  const ReadLease reader = read();
  Statement select(reader.connection(), "SELECT rowid, outside FROM blobs WHERE hash = ?");
  select.bind(hash);
  if (!select.step()) return false;
  const std::int64_t row = select.integer();
  if (select.optional_text()) return large_->read(std::string(hash), first, length, take);
  const BlobReader blob(reader.connection(), "blobs", "bytes", row);
  std::string block(std::min<std::uint64_t>(length, std::uint64_t{1} << 18), '\0');
  for (std::uint64_t done = 0; done < length;) {
    const std::size_t step = std::min<std::uint64_t>(block.size(), length - done);
    blob.read({block.data(), step}, first + done);
    if (!take(std::string_view(block).substr(0, step))) return false;
    done += step;
  }
  return true;
}

StoreCounts Store::counts() const {
  const ReadLease reader = read();
  Statement select(reader.connection(),
                   "SELECT (SELECT count(*) FROM captures), (SELECT count(*) FROM runs WHERE kind = 'run'), "
                   "(SELECT count(*) FROM runs WHERE status = 'queued'), "
                   "(SELECT count(*) FROM runs WHERE status = 'running')");
  select.step();
  StoreCounts counts;
  counts.captures = static_cast<std::uint64_t>(select.integer());
  counts.runs = static_cast<std::uint64_t>(select.integer());
  counts.queued = static_cast<std::uint64_t>(select.integer());
  counts.running = static_cast<std::uint64_t>(select.integer());
  return counts;
}

StoreGauges Store::gauges() const {
  const ReadLease reader = read();
  StoreGauges gauges;
  Statement runs(reader.connection(),
                 "SELECT kind, status, CASE status WHEN 'failed' THEN reason ELSE '' END AS why, count(*) FROM runs "
                 "GROUP BY kind, status, why");
  while (runs.step()) {
    StoreGauges::Runs each;
    each.kind = runs.text();
    each.status = runs.text();
    each.reason = runs.text();
    each.count = static_cast<std::uint64_t>(runs.integer());
    gauges.runs.push_back(std::move(each));
  }
  Statement stages(reader.connection(),
                   "SELECT 'all', sum(head ->> '$.wall_s') FROM runs WHERE head IS NOT NULL HAVING count(*) > 0 UNION "
                   "ALL SELECT key, sum(value) FROM runs, json_each(runs.head, '$.outside_parts_s') GROUP BY key");
  while (stages.step()) {
    const std::string stage = stages.text();
    gauges.stage_seconds[stage] = stages.real();
  }
  Statement sizes(reader.connection(),
                  "SELECT (SELECT count(*) FROM frame_results), (SELECT count(*) FROM captures), (SELECT "
                  "coalesce(sum(size_bytes), 0) FROM captures), page_count * page_size, freelist_count * page_size "
                  "FROM pragma_page_count, pragma_page_size, pragma_freelist_count");
  sizes.step();
  for (std::uint64_t* const value :
       {&gauges.results, &gauges.captures, &gauges.capture_bytes, &gauges.store_bytes, &gauges.store_free_bytes}) {
    *value = static_cast<std::uint64_t>(sizes.integer());
  }
  return gauges;
}

void Store::probe() {
  const std::lock_guard lock(write_mutex_);
  Transaction transaction(writer_);
  // Says the same again, so that something is written.
  writer_.execute(fmt::format("PRAGMA user_version = {}", schema_version(writer_)));
  transaction.commit();
}

}  // namespace subpixel::server
