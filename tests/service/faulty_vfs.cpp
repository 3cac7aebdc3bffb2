#include "tests/service/faulty_vfs.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace subpixel::tests {
namespace {

using Call = FaultyVfs::Call;
using Kind = FaultyVfs::Event::Kind;

// What SQLite allocates for a file: ours, and the real one behind it.
struct File {
  sqlite3_file base;
  FaultyVfs* vfs;
  const char* path;
  bool syncs_folder;
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File& file(sqlite3_file* handle) {
  return *reinterpret_cast<File*>(handle);
}

const sqlite3_io_methods& methods() {
  static const sqlite3_io_methods kMethods{
      .iVersion = 2,
      .xClose = [](sqlite3_file* f) { return file(f).real()->pMethods->xClose(file(f).real()); },
      .xRead =
          [](sqlite3_file* f, void* to, int size, sqlite3_int64 offset) {
            if (const int code = file(f).vfs->fault(Call::read)) return code;
            return file(f).real()->pMethods->xRead(file(f).real(), to, size, offset);
          },
      .xWrite =
          [](sqlite3_file* f, const void* from, int size, sqlite3_int64 offset) {
            if (const int code = file(f).vfs->fault(Call::write)) {
              // As a disk does that fills up: some of it is there.
              file(f).real()->pMethods->xWrite(file(f).real(), from, size / 2, offset);
              return code;
            }
            const int code = file(f).real()->pMethods->xWrite(file(f).real(), from, size, offset);
            if (code == SQLITE_OK && file(f).path != nullptr) {
              file(f).vfs->note({Kind::write, file(f).path, offset,
                                 std::string(static_cast<const char*>(from), static_cast<std::size_t>(size))});
            }
            return code;
          },
      .xTruncate =
          [](sqlite3_file* f, sqlite3_int64 size) {
            if (const int code = file(f).vfs->fault(Call::truncate)) return code;
            const int code = file(f).real()->pMethods->xTruncate(file(f).real(), size);
            if (code == SQLITE_OK && file(f).path != nullptr) {
              file(f).vfs->note({Kind::truncate, file(f).path, size, ""});
            }
            return code;
          },
      .xSync =
          [](sqlite3_file* f, int) {
            if (const int code = file(f).vfs->fault(Call::sync)) return code;
            if (file(f).path != nullptr) {
              file(f).vfs->note({Kind::sync, file(f).path, 0, "", std::exchange(file(f).syncs_folder, false)});
            }
            return SQLITE_OK;
          },
      .xFileSize =
          [](sqlite3_file* f, sqlite3_int64* size) {
            if (const int code = file(f).vfs->fault(Call::size)) return code;
            return file(f).real()->pMethods->xFileSize(file(f).real(), size);
          },
      .xLock =
          [](sqlite3_file* f, int level) {
            if (const int code = file(f).vfs->fault(Call::lock)) return code;
            return file(f).real()->pMethods->xLock(file(f).real(), level);
          },
      .xUnlock = [](sqlite3_file* f, int level) { return file(f).real()->pMethods->xUnlock(file(f).real(), level); },
      .xCheckReservedLock =
          [](sqlite3_file* f, int* held) { return file(f).real()->pMethods->xCheckReservedLock(file(f).real(), held); },
      .xFileControl = [](sqlite3_file* f, int what,
                         void* with) { return file(f).real()->pMethods->xFileControl(file(f).real(), what, with); },
      .xSectorSize = [](sqlite3_file* f) { return file(f).real()->pMethods->xSectorSize(file(f).real()); },
      .xDeviceCharacteristics =
          [](sqlite3_file* f) { return file(f).real()->pMethods->xDeviceCharacteristics(file(f).real()); },
      .xShmMap =
          [](sqlite3_file* f, int page, int size, int extend, void volatile** to) {
            if (const int code = file(f).vfs->fault(Call::shm_map)) return code;
            return file(f).real()->pMethods->xShmMap(file(f).real(), page, size, extend, to);
          },
      .xShmLock =
          [](sqlite3_file* f, int offset, int count, int flags) {
            if ((flags & SQLITE_SHM_LOCK) != 0) {
              if (const int code = file(f).vfs->fault(Call::shm_lock)) return code;
            }
            return file(f).real()->pMethods->xShmLock(file(f).real(), offset, count, flags);
          },
      .xShmBarrier = [](sqlite3_file* f) { file(f).real()->pMethods->xShmBarrier(file(f).real()); },
      .xShmUnmap = [](sqlite3_file* f,
                      int remove) { return file(f).real()->pMethods->xShmUnmap(file(f).real(), remove); },
      .xFetch = nullptr,
      .xUnfetch = nullptr,
  };
  return kMethods;
}

FaultyVfs& self(sqlite3_vfs* vfs) {
  return *static_cast<FaultyVfs*>(vfs->pAppData);
}

int open_file(sqlite3_vfs* vfs, const char* path, sqlite3_file* handle, int flags, int* got) {
  FaultyVfs& owner = self(vfs);
  handle->pMethods = nullptr;
  if (const int code = owner.fault(Call::open)) return code;
  int exists = 0;
  if (path != nullptr) owner.real()->xAccess(owner.real(), path, SQLITE_ACCESS_EXISTS, &exists);
  constexpr int kJournals = SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_SUPER_JOURNAL | SQLITE_OPEN_WAL;
  File& opened = file(handle);
  opened.vfs = &owner;
  // Temporary files mean nothing after a power failure.
  opened.path = (flags & (SQLITE_OPEN_MAIN_DB | kJournals)) != 0 ? path : nullptr;
  opened.syncs_folder = exists == 0 && (flags & kJournals) != 0;
  const int code = owner.real()->xOpen(owner.real(), path, opened.real(), flags, got);
  if (opened.real()->pMethods != nullptr) handle->pMethods = &methods();
  if (code == SQLITE_OK && opened.path != nullptr && exists == 0) owner.note({Kind::create, path, 0, ""});
  return code;
}

int delete_file(sqlite3_vfs* vfs, const char* path, int sync_folder) {
  FaultyVfs& owner = self(vfs);
  if (const int code = owner.fault(Call::remove)) return code;
  const int code = owner.real()->xDelete(owner.real(), path, 0);
  if (code == SQLITE_OK) owner.note({Kind::remove, path, sync_folder != 0 ? 1 : 0, ""});
  return code;
}

void apply_to(std::string& content, const FaultyVfs::Event& event) {
  const auto offset = static_cast<std::size_t>(event.offset);
  if (event.kind == Kind::truncate) {
    content.resize(std::min(content.size(), offset));
  } else {
    content.resize(std::max(content.size(), offset + event.bytes.size()));
    content.replace(offset, event.bytes.size(), event.bytes);
  }
}

// Each sector of a write by itself: a disk orders them as it likes.
void apply_some(std::string& content, const FaultyVfs::Event& event, std::mt19937& random) {
  constexpr std::size_t kSector = 512;
  if (event.kind == Kind::truncate) {
    if (random() % 2 == 0) apply_to(content, event);
    return;
  }
  for (std::size_t at = 0; at < event.bytes.size(); at += kSector) {
    if (random() % 2 == 0) continue;
    FaultyVfs::Event part = event;
    part.offset += static_cast<std::int64_t>(at);
    part.bytes = event.bytes.substr(at, kSector);
    apply_to(content, part);
  }
}

}  // namespace

FaultyVfs::FaultyVfs() : real_(sqlite3_vfs_find("unix")), vfs_(*real_) {
  vfs_.iVersion = 2;
  vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
  vfs_.pNext = nullptr;
  vfs_.zName = "faulty";
  vfs_.pAppData = this;
  vfs_.xOpen = &open_file;
  vfs_.xDelete = &delete_file;
  vfs_.xAccess = [](sqlite3_vfs* v, const char* path, int flags, int* answer) {
    return self(v).real()->xAccess(self(v).real(), path, flags, answer);
  };
  vfs_.xFullPathname = [](sqlite3_vfs* v, const char* path, int size, char* to) {
    return self(v).real()->xFullPathname(self(v).real(), path, size, to);
  };
  // Whoever waits for another process waits no real time.
  vfs_.xSleep = [](sqlite3_vfs*, int microseconds) { return microseconds; };
  sqlite3_vfs_register(&vfs_, 1);
}

FaultyVfs::~FaultyVfs() {
  sqlite3_vfs_unregister(&vfs_);
  sqlite3_vfs_register(real_, 1);
}

void FaultyVfs::fail(Call call, int nth, int code, Lasting lasting) {
  const std::lock_guard lock(mutex_);
  plan_ = Plan{call, nth, code, lasting};
  struck_ = false;
}

void FaultyVfs::heal() {
  const std::lock_guard lock(mutex_);
  plan_.reset();
}

bool FaultyVfs::struck() const {
  const std::lock_guard lock(mutex_);
  return struck_;
}

int FaultyVfs::fault(Call call) {
  const std::lock_guard lock(mutex_);
  if (!plan_ || plan_->call != call || --plan_->left > 0) return SQLITE_OK;
  struck_ = true;
  const int code = plan_->code;
  if (plan_->lasting == Lasting::once) plan_.reset();
  return code;
}

void FaultyVfs::note(Event event) {
  const std::lock_guard lock(mutex_);
  if (recording_) events_.push_back(std::move(event));
}

void FaultyVfs::mark(std::int64_t number) {
  note({Event::Kind::mark, "", number, ""});
}

void Disk::apply(const FaultyVfs::Event& event) {
  switch (event.kind) {
    case Kind::create:
      files_[event.path] = {};
      return;
    case Kind::write:
    case Kind::truncate:
      files_[event.path].unsynced.push_back(event);
      return;
    case Kind::sync: {
      File& synced = files_[event.path];
      for (const FaultyVfs::Event& each : synced.unsynced) apply_to(synced.durable, each);
      synced.unsynced.clear();
      if (!event.syncs_folder) return;
      for (auto& [path, each] : files_) each.name_is_durable = true;
      std::erase_if(files_, [](const auto& entry) { return entry.second.removed; });
      return;
    }
    case Kind::remove:
      files_[event.path].removed = true;
      if (event.offset != 0) files_.erase(event.path);
      return;
    case Kind::mark:
      return;
  }
}

std::map<std::string, std::string> Disk::after_power_failure(std::mt19937* random) const {
  std::map<std::string, std::string> left;
  for (const auto& [path, each] : files_) {
    const bool sure = each.name_is_durable && !each.removed;
    // A name that was taken away but not for good is there in the stricter case.
    const bool there = sure || (random != nullptr ? (*random)() % 2 == 0 : each.name_is_durable);
    if (!there) continue;
    std::string content = each.durable;
    if (random != nullptr) {
      for (const FaultyVfs::Event& event : each.unsynced) apply_some(content, event, *random);
    }
    left[path] = std::move(content);
  }
  return left;
}

}  // namespace subpixel::tests
