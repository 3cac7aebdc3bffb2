// The folder one service owns: its store, captures, uploads in progress, jobs in progress and cached references.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace subpixel::server {

class DataFolder {
 public:
  // Creates what is missing, takes the folder's lock and removes what an ended service left unfinished.
  // Throws InputError when it can't be created or another service holds it.
  explicit DataFolder(const std::filesystem::path& root);
  ~DataFolder();
  DataFolder(const DataFolder&) = delete;
  DataFolder& operator=(const DataFolder&) = delete;

  std::filesystem::path store() const { return root_ / "subpixel.sqlite"; }
  std::filesystem::path captures() const { return root_ / "captures"; }
  std::filesystem::path capture(std::string_view hash) const;
  std::filesystem::path uploads() const { return root_ / "uploads"; }
  std::filesystem::path job(std::int64_t run) const;
  std::filesystem::path cache() const { return root_ / "cache"; }
  // Bytes an ordinary user can still write.
  std::uint64_t free_bytes() const;

 private:
  std::filesystem::path root_;
  int lock_ = -1;
};

}  // namespace subpixel::server
