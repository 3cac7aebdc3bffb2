// Upkeep of a data folder: whether all of it is there and whole, a copy of it, what of it may go. Beside a running
// service, unless it says otherwise. Throws SqliteError as the store does, and InputError.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// Says whether a file of the cache is what it was when it was written. Whose form that is, is not the store's business.
using CacheCheck = std::function<bool(const std::filesystem::path& file)>;

struct CheckReport {
  std::vector<std::string> damage;    // "what: why: where"
  std::vector<std::string> leftover;  // takes room, does no harm; collect_garbage() takes it
  std::uint64_t captures = 0, runs = 0, nights = 0, blobs = 0, cached = 0;  // looked at
  std::uint64_t outside = 0;                                                // of the blobs: in files of their own
};

// Reads everything: the store's pages, keys and documents, each blob and each capture against its hash, each file of
// the cache. The store must be of this program's version.
CheckReport check_data(const DataFolder& folder, const CacheCheck& cache_is_whole);

struct BackupReport {
  std::uint64_t captures = 0, bytes = 0, outside = 0;  // outside: blobs' files
};

// Copies store and captures, as they are at one moment, to the new folder `target`, a data folder then; complete and on
// the disk, or not there.
BackupReport back_up(const DataFolder& folder, const std::filesystem::path& target);

// What stays. Of runs (of one capture) and nights (of one name) one is kept when any of the two says so; with neither
// all are. Whatever is said, queued and running ones stay, and nights that a baseline names or that a night that stays
// was compared with.
struct Retention {
  std::optional<std::uint32_t> days, count;
  // Also captures that are older than `days`, have no tag, no run that stays, and are in no night that stays.
  bool captures = false;
  std::optional<std::uint32_t> cache_days;  // of the cache, what was written in them; without it all that is whole
};

struct Freed {
  std::uint64_t runs = 0, nights = 0, captures = 0, blobs = 0, files = 0;
  std::uint64_t store_bytes = 0;  // of blobs: free within the store's file, which does not get shorter
  std::uint64_t file_bytes = 0;   // given back to the disk
};

// Deletes what need not stay, blobs and files that nothing names, and damaged files of the cache; with `dry` it only
// says what that would be. In steps short enough for a service to store results in between.
Freed collect_garbage(const DataFolder& folder, Store& store, const Retention& retention, bool dry,
                      const CacheCheck& cache_is_whole);

// Rewrites the store's file without what is free in it; returns by how many bytes it got shorter. Nobody else may have
// the folder (Claim::upkeep), and the disk must have room for another one.
std::uint64_t compact(const DataFolder& folder);

struct MigrationReport {
  std::int64_t from = 0, to = 0;
  std::filesystem::path kept;  // the store as it was; empty when there was nothing to do
};

// Takes the store to this program's version. As it was it is kept beside it. Nobody else may have the folder. Throws
// InputError for a store that is newer than this program.
MigrationReport migrate_data(const DataFolder& folder);

struct Moved {
  std::uint64_t out = 0, in = 0, bytes = 0;  // blobs, and how much they are together
};

// From now on blobs of `large_bytes` and more (none: no blob) have their bytes in files of their own; those that are
// stored already are moved. Nobody else may have the folder. May be broken off at any moment and done again. Throws
// InputError for a blob that is damaged.
Moved place_blobs(const DataFolder& folder, std::optional<std::uint64_t> large_bytes);

}  // namespace subpixel::server
