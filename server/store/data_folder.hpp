// The folder one service owns: its store, captures, uploads in progress, jobs in progress and cached references. Nights
// are run in it too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::server {

class DataFolder {
 public:
  // service and night exclude their own kind, but not each other: a night runs beside the service on one folder.
  // upkeep excludes both. reader claims nothing.
  enum class Claim { service, night, upkeep, reader };

  // Creates what is missing, takes the lock of `claim` and removes what its last holder left unfinished. For upkeep and
  // readers there must be a store, and nothing is removed. Throws InputError when it can't be created or another
  // process holds the lock.
  explicit DataFolder(const std::filesystem::path& root, Claim claim = Claim::service);
  ~DataFolder();
  DataFolder(const DataFolder&) = delete;
  DataFolder& operator=(const DataFolder&) = delete;

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path store() const { return root_ / "subpixel.sqlite"; }
  std::filesystem::path captures() const { return root_ / "captures"; }
  std::filesystem::path capture(std::string_view hash) const;
  std::filesystem::path uploads() const { return root_ / "uploads"; }
  std::filesystem::path job(std::int64_t run) const;
  std::filesystem::path night() const { return root_ / "night"; }  // of the night in progress
  std::filesystem::path cache() const { return root_ / "cache"; }
  // Bytes an ordinary user can still write.
  std::uint64_t free_bytes() const;

 private:
  void take_lock(const std::string& name, const std::string& holder);

  void release_locks() const;

  std::filesystem::path root_;
  std::vector<int> locks_;
};

}  // namespace subpixel::server
