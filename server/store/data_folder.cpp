#include "server/store/data_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace subpixel::server {

namespace fs = std::filesystem;

DataFolder::DataFolder(const fs::path& root, Claim claim) {
  try {
    if (claim == Claim::reader || claim == Claim::upkeep) {
      if (!fs::is_regular_file(root / "subpixel.sqlite")) {
        throw InputError("can't use the data folder", "there is no store in it", root.string());
      }
      root_ = fs::canonical(root);
      if (claim == Claim::reader) return;
      take_lock("lock", "a service");
      take_lock("night.lock", "a night");
      return;
    }
    fs::create_directories(root);
    root_ = fs::canonical(root);
    if (claim == Claim::service) {
      take_lock("lock", "another service");
      fs::remove_all(uploads());
      fs::remove_all(root_ / "jobs");
      for (const fs::path& folder : {captures(), uploads(), root_ / "jobs", cache()}) fs::create_directories(folder);
    } else {
      take_lock("night.lock", "another night");
      fs::remove_all(night());
      for (const fs::path& folder : {captures(), night(), cache()}) fs::create_directories(folder);
    }
    // What is stored in it later is as lasting as its own name.
    for (const fs::path& folder : {root_, root_.parent_path()}) {
      const int error = sync_folder(folder);
      if (error != 0) throw InputError("can't use the data folder", std::strerror(error), folder.string());
    }
  } catch (const fs::filesystem_error& error) {
    release_locks();
    throw InputError("can't use the data folder", error.code().message(), root.string());
  } catch (...) {
    release_locks();
    throw;
  }
}

void DataFolder::take_lock(const std::string& name, const std::string& holder) {
  const int lock = ::open((root_ / name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock < 0) throw InputError("can't use the data folder", std::strerror(errno), (root_ / name).string());
  locks_.push_back(lock);
  if (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
    throw InputError("can't use the data folder", holder + " holds it", root_.string());
  }
}

DataFolder::~DataFolder() {
  release_locks();
}

void DataFolder::release_locks() const {
  for (const int lock : locks_) ::close(lock);
}

fs::path DataFolder::capture(std::string_view hash) const {
  return captures() / (std::string(hash) + ".spcap");
}

fs::path DataFolder::job(std::int64_t run) const {
  return root_ / "jobs" / std::to_string(run);
}

std::uint64_t DataFolder::free_bytes() const {
  std::error_code error;
  const fs::space_info space = fs::space(root_, error);
  return error ? 0 : space.available;
}

}  // namespace subpixel::server
