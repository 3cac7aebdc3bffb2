// Where the bytes of large blobs are. The store's rows say which there are; this only keeps bytes by their hash, so
// that another place for them (a bucket of objects, docs/scaling.md) is another class of this form.
//
// The order that makes it safe: bytes are lasting before the row that names them is committed, and go only while the
// store's write lock is held and no row names them. So what a row names is always there; what no row names is garbage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace subpixel::server {

class LargeBlobs {
 public:
  virtual ~LargeBlobs() = default;
  // Before the first of them: makes the place, lasting. Throws SqliteError.
  virtual void prepare() = 0;
  // The bytes are lasting when this returns; equal ones that are there stay. Throws SqliteError.
  virtual void put(const std::string& hash, std::string_view bytes) = 0;
  // Hands `length` bytes from `first` on to `take`, in pieces. False when that says so, or they are not there.
  virtual bool read(const std::string& hash, std::uint64_t first, std::uint64_t length,
                    const std::function<bool(std::string_view)>& take) const = 0;
  // Bytes; none when there is no such blob.
  virtual std::optional<std::uint64_t> size(const std::string& hash) const = 0;
  virtual void remove(const std::string& hash) = 0;
  // Every blob there is, and what else lies between them, which is older than an hour: left by a writer that died.
  virtual void each(const std::function<void(const std::string& hash, std::uint64_t bytes)>& take) const = 0;
  virtual std::uint64_t remove_unfinished() = 0;  // how many
  // While it lives, remove() leaves everything, in all processes. Null when a removal is under way.
  virtual std::shared_ptr<void> hold() const = 0;
};

// Files HH/HASH of a folder, which is made with the first of them; HH are the hash's first two digits.
class FolderBlobs : public LargeBlobs {
 public:
  explicit FolderBlobs(std::filesystem::path folder) : folder_(std::move(folder)) {}
  void prepare() override;
  void put(const std::string& hash, std::string_view bytes) override;
  bool read(const std::string& hash, std::uint64_t first, std::uint64_t length,
            const std::function<bool(std::string_view)>& take) const override;
  std::optional<std::uint64_t> size(const std::string& hash) const override;
  void remove(const std::string& hash) override;
  void each(const std::function<void(const std::string& hash, std::uint64_t bytes)>& take) const override;
  std::uint64_t remove_unfinished() override;
  std::shared_ptr<void> hold() const override;

 private:
  std::filesystem::path path_of(const std::string& hash) const { return folder_ / hash.substr(0, 2) / hash; }
  std::filesystem::path folder_;
};

// Those of the store in `file`: the folder `blobs` beside it.
std::unique_ptr<LargeBlobs> large_blobs_of(const std::filesystem::path& file);

}  // namespace subpixel::server
