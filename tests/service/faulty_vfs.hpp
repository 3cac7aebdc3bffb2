// A file layer for SQLite that goes wrong on request, and one that remembers what happened so that a test can ask what
// a power failure would have left. Every connection opened while one of these lives goes through it. Nothing is really
// synced: what would be lost is worked out, not tried.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace subpixel::tests {

class FaultyVfs {
 public:
  enum class Call { open, remove, read, write, truncate, sync, size, lock, shm_map, shm_lock };
  enum class Lasting { once, until_healed };

  FaultyVfs();
  ~FaultyVfs();
  FaultyVfs(const FaultyVfs&) = delete;
  FaultyVfs& operator=(const FaultyVfs&) = delete;

  // The `nth` such call from now on (1: the next) ends with `code`.
  void fail(Call call, int nth, int code, Lasting lasting);
  void heal();
  bool struck() const;

  // What happened to files, in order, from record() on.
  struct Event {
    enum class Kind { create, write, truncate, sync, remove, mark } kind;
    std::string path;
    std::int64_t offset = 0;  // of a write; a truncation's size; 1: a removal whose folder was synced; a mark's number
    std::string bytes;
    bool syncs_folder = false;  // a journal's first sync takes its folder along
  };
  void record() { recording_ = true; }
  // Something the caller knows to have happened by now.
  void mark(std::int64_t number);
  const std::vector<Event>& events() const { return events_; }

  // For the calls. 0, or the code to end with.
  int fault(Call call);
  void note(Event event);
  sqlite3_vfs* real() const { return real_; }

 private:
  struct Plan {
    Call call;
    int left, code;
    Lasting lasting;
  };
  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
  mutable std::mutex mutex_;
  std::optional<Plan> plan_;
  bool struck_ = false, recording_ = false;
  std::vector<Event> events_;
};

// Disks as a power failure may leave them: what was synced is there; of what was not, each piece may be or not.
class Disk {
 public:
  void apply(const FaultyVfs::Event& event);
  // Files by path. Without a generator nothing unsynced is there.
  std::map<std::string, std::string> after_power_failure(std::mt19937* random) const;

 private:
  struct File {
    std::string durable;
    std::vector<FaultyVfs::Event> unsynced;
    bool name_is_durable = false;
    bool removed = false;  // but that may not have reached the disk
  };
  std::map<std::string, File> files_;
};

}  // namespace subpixel::tests
