// `subpixel store check`: rows, blobs, captures and the cache against each other.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/printable.hpp"
#include "server/store/upkeep.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

// A question whose every answer, one text, is something wrong.
struct Question {
  const char* what;
  const char* sql;
};

// Documents name images by blob, and so do rows, for deletion to follow: both say the same.
constexpr Question kQuestions[] = {
    {"a result's document is no JSON",
     "SELECT 'run ' || run || ' frame ' || frame FROM frame_results WHERE NOT json_valid(document)"},
    {"a result names an image that is not stored with it",
     "SELECT 'run ' || f.run || ' frame ' || f.frame || ' ' || j.key FROM frame_results f, "
     "json_each(CASE WHEN json_valid(f.document) THEN f.document ELSE '{}' END, '$.images') j "
     "WHERE NOT EXISTS (SELECT 1 FROM images i WHERE i.result = f.id AND i.role = j.key AND i.blob = j.value)"},
    {"an image is stored with a result that does not name it",
     "SELECT 'run ' || f.run || ' frame ' || f.frame || ' ' || i.role FROM images i JOIN frame_results f "
     "ON f.id = i.result WHERE NOT EXISTS (SELECT 1 FROM json_each(CASE WHEN json_valid(f.document) THEN f.document "
     "ELSE '{}' END, '$.images') j WHERE j.key = i.role AND j.value = i.blob)"},
    {"a run's results are not as many as its status says",
     "SELECT 'run ' || id FROM runs r WHERE (SELECT count(*) FROM frame_results WHERE run = r.id) > "
     "expected_results OR (status = 'done' AND (SELECT count(*) FROM frame_results WHERE run = r.id) < "
     "expected_results)"},
    {"a night's document is no JSON",
     "SELECT 'cell ' || cell || ' frame ' || frame FROM night_frames WHERE NOT json_valid(document)"},
    {"a night names an image that is not stored with it",
     "SELECT 'cell ' || f.cell || ' frame ' || f.frame || ' ' || j.key FROM night_frames f, "
     "json_each(CASE WHEN json_valid(f.document) THEN f.document ELSE '{}' END, '$.images') j "
     "WHERE NOT EXISTS (SELECT 1 FROM night_images i WHERE i.frame = f.id AND i.role = j.key AND i.blob = j.value)"},
};

class Check {
 public:
  Check(const DataFolder& folder, const CacheCheck& cache_is_whole)
      : folder_(folder), connection_(folder.store()), cache_is_whole_(cache_is_whole) {}

  CheckReport run() {
    if (const std::int64_t version = schema_version(connection_); version < newest_schema_version()) {
      throw InputError("can't check the store",
                       fmt::format("its version is {}, this program's {}; see subpixel store migrate", version,
                                   newest_schema_version()),
                       folder_.store().string());
    } else if (version > newest_schema_version()) {
      throw InputError("can't check the store",
                       fmt::format("its version is {}, this program knows up to {}", version, newest_schema_version()),
                       folder_.store().string());
    }
    // One after the other, so that a damaged page does not hide what is wrong elsewhere.
    guarded("the store's pages", [this] { check_pages(); });
    guarded("the store's rows", [this] { check_rows(); });
    guarded("the store's blobs", [this] { check_blobs(); });
    guarded("the store's captures", [this] { check_captures(); });
    check_cache();
    return std::move(report_);
  }

 private:
  void damaged(const std::string& what, const std::string& why, const std::string& where) {
    report_.damage.push_back(fmt::format("{}: {}: {}", what, why, printable(where)));
  }

  template <typename Part>
  void guarded(const char* what, const Part& part) {
    try {
      connection_.execute("BEGIN");  // all of a part is read as it is at one moment
      part();
    } catch (const SqliteError& error) {
      if (error.cause() == SqliteError::Cause::busy) throw;
      damaged(what, error.what(), folder_.store().string());
    }
    sqlite3_exec(connection_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }

  void check_pages() {
    Statement pages(connection_, "PRAGMA integrity_check(20)");
    while (pages.step()) {
      if (const std::string line = pages.text(); line != "ok") {
        damaged("the store's pages", printable(line), folder_.store().string());
      }
    }
    Statement keys(connection_,
                   "SELECT \"table\" || ' row ' || coalesce(rowid, '?'), parent FROM pragma_foreign_key_check");
    while (keys.step()) {
      const std::string row = keys.text();
      damaged("the store's rows", "one names a row that is not there", row + " in " + keys.text());
    }
  }

  void check_rows() {
    for (const Question& question : kQuestions) {
      Statement answers(connection_, question.sql);
      while (answers.step()) damaged("the store's rows", question.what, answers.text());
    }
    Statement count(connection_, "SELECT (SELECT count(*) FROM runs), (SELECT count(*) FROM nights)");
    count.step();
    report_.runs = static_cast<std::uint64_t>(count.integer());
    report_.nights = static_cast<std::uint64_t>(count.integer());
  }

  void check_blobs() {
    std::string block(std::size_t{1} << 20, '\0');
    const std::unique_ptr<LargeBlobs> large = large_blobs_of(folder_.store());
    Statement blobs(connection_, "SELECT rowid, hash, length(bytes), outside FROM blobs");
    while (blobs.step()) {
      const std::int64_t row = blobs.integer();
      const std::string hash = blobs.text();
      const auto size = static_cast<std::uint64_t>(blobs.integer());
      const std::optional<std::string> outside = blobs.optional_text();
      ++report_.blobs;
      if (outside) {
        check_outside(*large, hash, std::stoull(*outside), size);
        continue;
      }
      const BlobReader reader(connection_, "blobs", "bytes", row);
      ContentHasher hasher;
      for (std::uint64_t done = 0; done < size;) {
        const std::span<char> part(block.data(), std::min<std::uint64_t>(block.size(), size - done));
        reader.read(part, done);
        hasher.add(std::as_bytes(part));
        done += part.size();
      }
      if (hasher.hash().hex() != hash) damaged("a blob", "its bytes have another hash", hash);
    }
    large->each([&](const std::string& hash, std::uint64_t) {
      if (!is_outside(connection_, hash) && !is_outside(Connection(folder_.store()), hash))
        report_.leftover.push_back("a file of a blob that is not stored: " + hash);
    });
    Statement unnamed(connection_, "SELECT hash FROM blobs WHERE " + std::string(kBlobIsUnnamed));
    while (unnamed.step()) report_.leftover.push_back("a blob that nothing names: " + unnamed.text());
  }

  void check_outside(const LargeBlobs& large, const std::string& hash, std::uint64_t size, std::uint64_t inside) {
    ++report_.outside;
    if (inside != 0) damaged("a blob", "it is inside and outside of the store's file", hash);
    std::string problem;
    ContentHasher hasher;
    const auto take = [&](std::string_view part) {
      hasher.add(std::as_bytes(std::span(part)));
      return true;
    };
    if (large.size(hash).value_or(0) != size) {
      problem = large.size(hash) ? "its file has another size" : "its file is not there";
    } else if (!large.read(hash, 0, size, take)) {
      problem = "its file can't be read";
    } else if (hasher.hash().hex() != hash) {
      problem = "its file's bytes have another hash";
    }
    // A service may have deleted it meanwhile.
    if (!problem.empty() && is_outside(Connection(folder_.store()), hash)) damaged("a blob", problem, hash);
  }

  static bool is_outside(const Connection& connection, const std::string& hash) {
    Statement row(connection, "SELECT 1 FROM blobs WHERE hash = ? AND outside IS NOT NULL");
    return row.bind(hash).step();
  }

  void check_captures() {
    std::set<std::string> known;
    Statement captures(connection_, "SELECT hash, size_bytes FROM captures");
    while (captures.step()) {
      const std::string hash = captures.text();
      const auto size = static_cast<std::uint64_t>(captures.integer());
      known.insert(hash);
      ++report_.captures;
      check_capture(hash, size);
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.captures())) {
      if (entry.path().extension() == ".spcap" && known.contains(entry.path().stem().string())) continue;
      if (entry.path().extension() == ".spcap" && is_stored(entry.path().stem().string())) continue;
      report_.leftover.push_back("a file that no capture names: " + printable(entry.path().string()));
    }
  }

  void check_capture(const std::string& hash, std::uint64_t size) {
    const fs::path file = folder_.capture(hash);
    std::string problem;
    try {
      if (fs::file_size(file) != size) {
        problem = "its file has another size";
      } else if (content_hash_hex(file) != hash) {
        problem = "its file's bytes have another hash";
      }
    } catch (const fs::filesystem_error& error) {
      problem = "its file can't be read: " + error.code().message();
    } catch (const InputError&) {
      problem = "its file can't be read";
    }
    // A service may have deleted it meanwhile.
    if (!problem.empty() && is_stored(hash)) damaged("a capture", problem, file.string());
  }

  // As the store is now, which is not what this check's transaction sees.
  bool is_stored(const std::string& hash) const {
    const Connection now(folder_.store());
    Statement row(now, "SELECT 1 FROM captures WHERE hash = ?");
    return row.bind(hash).step();
  }

  void check_cache() {
    std::error_code none;  // a backup has no cache
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.cache(), none)) {
      if (entry.is_directory()) continue;  // the driver's own
      ++report_.cached;
      if (cache_is_whole_(entry.path())) continue;
      report_.leftover.push_back("a damaged file of the cache, which is computed again: " +
                                 printable(entry.path().string()));
    }
  }

  const DataFolder& folder_;
  const Connection connection_;
  const CacheCheck& cache_is_whole_;
  CheckReport report_;
};

}  // namespace

CheckReport check_data(const DataFolder& folder, const CacheCheck& cache_is_whole) {
  return Check(folder, cache_is_whole).run();
}

}  // namespace subpixel::server
