// `subpixel store backup` and `migrate`.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "server/store/upkeep.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

// False when there is no such file (any more).
bool copy_file(const fs::path& from, const fs::path& to, std::uint64_t& bytes) {
  std::ifstream source(from, std::ios::binary);
  if (!source) return false;
  AtomicFile target(to);
  std::vector<char> block(std::size_t{1} << 20);
  while (source.read(block.data(), static_cast<std::streamsize>(block.size())), source.gcount() > 0) {
    target.write(std::as_bytes(std::span(block.data(), static_cast<std::size_t>(source.gcount()))));
    bytes += static_cast<std::uint64_t>(source.gcount());
  }
  if (source.bad()) throw InputError("can't back up", "a capture can't be read", from.string());
  target.commit();
  return true;
}

// The folder of a backup in the making; gone again unless keep() is called.
class PartFolder {
 public:
  explicit PartFolder(const fs::path& target) : target_(target), part_(target.string() + ".part") {
    fs::remove_all(part_);  // of one that was broken off
    fs::create_directories(part_);
  }
  ~PartFolder() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(part_, ignored);
  }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  const fs::path& path() const { return part_; }
  void keep() {
    for (const fs::path& folder : {part_, part_ / "captures"}) sync(folder);  // blobs are synced as they come
    fs::rename(part_, target_);
    kept_ = true;
    sync(fs::absolute(target_).parent_path());
  }

 private:
  static void sync(const fs::path& folder) {
    const int error = sync_folder(folder);
    if (error != 0) throw InputError("can't back up", std::strerror(error), folder.string());
  }
  fs::path target_, part_;
  bool kept_ = false;
};

std::vector<std::string> capture_hashes(const Connection& connection) {
  std::vector<std::string> hashes;
  Statement select(connection, "SELECT hash FROM captures ORDER BY hash");
  while (select.step()) hashes.push_back(select.text());
  return hashes;
}

bool is_stored(const Connection& connection, const std::string& hash) {
  Statement row(connection, "SELECT 1 FROM captures WHERE hash = ?");
  return row.bind(hash).step();
}

void copy_blobs(const Connection& copied, const LargeBlobs& from, LargeBlobs& to, BackupReport& report) {
  if (large_blob_bytes(copied)) to.prepare();
  Statement rows(copied, "SELECT hash, outside FROM blobs WHERE outside IS NOT NULL ORDER BY hash");
  while (rows.step()) {
    const std::string hash = rows.text();
    const auto size = static_cast<std::uint64_t>(rows.integer());
    std::string bytes;
    const bool whole = from.read(hash, 0, size, [&](std::string_view part) {
      bytes.append(part);
      return true;
    });
    if (!whole) throw InputError("can't back up", "a blob's file is missing or short; see subpixel store check", hash);
    to.put(hash, bytes);
    ++report.outside;
    report.bytes += size;
  }
}

BackupReport copy_data(const DataFolder& folder, const fs::path& target) {
  const Connection store(folder.store());
  BackupReport report;
  const fs::path captures = target / "captures";
  fs::create_directories(captures);
  const auto copy = [&](const std::string& hash) {
    const fs::path copied = captures / (hash + ".spcap");
    return fs::exists(copied) || copy_file(folder.capture(hash), copied, report.bytes);
  };
  // Before the store, so that one which is deleted meanwhile is there for a store that still names it; and after it,
  // for those that came meanwhile.
  for (const std::string& hash : capture_hashes(store)) copy(hash);
  const std::unique_ptr<LargeBlobs> large = large_blobs_of(folder.store());
  const std::shared_ptr<void> held = large->hold();  // what the copy names stays until it is copied
  if (!held) throw InputError("can't back up", "the blobs' folder can't be locked", folder.root().string());
  copy_database(store, target / "subpixel.sqlite");
  const Connection copied(target / "subpixel.sqlite");
  std::set<std::string> kept;
  for (const std::string& hash : capture_hashes(copied)) {
    if (copy(hash)) {
      kept.insert(hash + ".spcap");
    } else if (is_stored(store, hash)) {
      throw InputError("can't back up", "a capture's file is missing; see subpixel store check",
                       folder.capture(hash).string());
    } else {  // came and went meanwhile
      Statement(copied, "DELETE FROM captures WHERE hash = ?").bind(hash).run();
    }
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(captures)) {
    if (!kept.contains(entry.path().filename().string())) fs::remove(entry.path());
  }
  copy_blobs(copied, *large, *large_blobs_of(target / "subpixel.sqlite"), report);
  report.captures = kept.size();
  report.bytes += fs::file_size(target / "subpixel.sqlite");
  return report;
}

}  // namespace

BackupReport back_up(const DataFolder& folder, const fs::path& target) {
  try {
    if (fs::exists(target)) throw InputError("can't back up", "there is something already", target.string());
    PartFolder part(target);
    const BackupReport report = copy_data(folder, part.path());
    part.keep();
    return report;
  } catch (const fs::filesystem_error& error) {
    throw InputError("can't back up", error.code().message(), target.string());
  }
}

MigrationReport migrate_data(const DataFolder& folder) {
  MigrationReport report;
  {
    const Connection connection(folder.store());
    report.from = report.to = schema_version(connection);
    if (report.from < newest_schema_version()) {
      report.kept = folder.root() / fmt::format("subpixel.version{}.sqlite", report.from);
      std::error_code ignored;
      fs::remove(report.kept, ignored);  // of an attempt that was broken off
      copy_database(connection, report.kept);
    }
  }
  if (const int error = sync_folder(folder.root()); error != 0) {
    throw InputError("can't migrate the store", std::strerror(error), folder.root().string());
  }
  const Store store(folder.store());
  report.to = newest_schema_version();
  return report;
}

}  // namespace subpixel::server
