// Files that are either complete or not there: what stands under the name after success and after every failure.
#include "base/atomic_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <functional>
#include <sstream>

#include "base/error.hpp"

namespace {

// Called at every fsync of this program; a number other than 0 is the error it ends with.
std::function<int(int descriptor)> on_sync;

}  // namespace

// In place of the C library's: what a test can see of a power failure is which syncs came before it.
extern "C" int fsync(int descriptor) {
  const int error = on_sync ? on_sync(descriptor) : 0;
  if (error == 0) return static_cast<int>(::syscall(SYS_fsync, descriptor));
  errno = error;
  return -1;
}

namespace subpixel {
namespace {

namespace fs = std::filesystem;

class AtomicFiles : public testing::Test {
 protected:
  AtomicFiles() : folder_(fs::path(testing::TempDir()) / ("atomic_file_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~AtomicFiles() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& path) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  // The message of the refusal; empty when the file was written.
  static std::string refusal(const fs::path& path, std::string_view text) {
    try {
      write_file_atomically(path, text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  fs::path folder_;
};

TEST_F(AtomicFiles, FoldersAreMadeAndFilesReplaced) {
  const fs::path path = folder_ / "a" / "b" / "file.json";
  write_file_atomically(path, "one");
  write_file_atomically(path, "two");
  EXPECT_EQ(content(path), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), {}), 1);
  write_file_atomically(path, "");
  EXPECT_EQ(content(path), "");
}

TEST_F(AtomicFiles, FolderThatIsMissingCanBeRefused) {
  EXPECT_THROW(write_file_atomically(folder_ / "none" / "x", std::span<const std::byte>(), MissingFolder::refuse),
               InputError);
  EXPECT_EQ(files(), 0);
}

TEST_F(AtomicFiles, NameInTheWorkingFolderDoes) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  write_file_atomically("plain", "x");
  fs::current_path(before);
  EXPECT_EQ(content(folder_ / "plain"), "x");
}

TEST_F(AtomicFiles, LongestNameDoes) {
  const fs::path path = folder_ / std::string(255, 'n');
  EXPECT_EQ(refusal(path, "x"), "");
  EXPECT_EQ(content(path), "x");
  EXPECT_NE(refusal(folder_ / std::string(256, 'n'), "x"), "");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFiles, PermissionsAreWhatTheUmaskLeaves) {
  for (const mode_t mask : {mode_t{022}, mode_t{077}, mode_t{002}}) {
    const mode_t before = ::umask(mask);
    write_file_atomically(folder_ / "file", "x");
    ::umask(before);
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / "file").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777u, 0666u & ~mask) << mask;
  }
}

TEST_F(AtomicFiles, NothingStandsUnderTheNameBeforeTheCommit) {
  const fs::path path = folder_ / "file";
  write_file_atomically(path, "before");
  {
    AtomicFile file(path);
    file.write(std::as_bytes(std::span(std::string_view("half"))));
    EXPECT_EQ(content(path), "before");
    EXPECT_EQ(files(), 2);
  }
  EXPECT_EQ(content(path), "before");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFiles, RefusalsSayWhyAndWhere) {
  write_file_atomically(folder_ / "file", "x");
  const fs::path below = folder_ / "file" / "below";
  EXPECT_EQ(refusal(below, "y"), "can't write the file: Not a directory: " + below.string());
  EXPECT_EQ(refusal(folder_, "y"), "can't write the file: Is a directory: " + folder_.string());
  EXPECT_EQ(files(), 1);
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_EQ(refusal("/dev/full", "y"), "can't write the file: No space left on device: /dev/full");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(AtomicFiles, DeviceOrPipeStaysWhatItIs) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  write_file_atomically(pipe, "through");
  char text[16] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 7);
  ::close(reader);
  EXPECT_STREQ(text, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFiles, SymbolicLinkIsFollowed) {
  fs::create_directory(folder_ / "elsewhere");
  write_file_atomically(folder_ / "elsewhere" / "file", "before");
  fs::create_symlink("elsewhere/file", folder_ / "link");
  write_file_atomically(folder_ / "link", "after");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(content(folder_ / "elsewhere" / "file"), "after");
}

// A limit on the file's size fails writes in the middle of a file, as a disk does that fills up meanwhile.
TEST_F(AtomicFiles, WriteThatBreaksOffLeavesTheFileBefore) {
  const fs::path path = folder_ / "file";
  write_file_atomically(path, "before");
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = refusal(path, std::string(5000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(message, "can't write the file: File too large: " + path.string());
  EXPECT_EQ(content(path), "before");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFiles, FullDiskLeavesTheFileBefore) {
  if (::mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "mounting is not allowed here";
  const fs::path path = folder_ / "file";
  write_file_atomically(path, "before");
  const std::string message = refusal(path, std::string(200'000, 'x'));
  EXPECT_EQ(message, "can't write the file: No space left on device: " + path.string());
  EXPECT_EQ(content(path), "before");
  EXPECT_EQ(files(), 1);
  EXPECT_EQ(refusal(path, std::string(40'000, 'y')), "") << "what failed gave its room back";
  ::umount2(folder_.c_str(), MNT_DETACH);
}

bool is_folder(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode);
}

TEST_F(AtomicFiles, BytesReachTheDiskBeforeTheNameAndTheNameBeforeTheEnd) {
  const fs::path path = folder_ / "file";
  write_file_atomically(path, "before");
  std::vector<std::string> syncs;
  on_sync = [&](int descriptor) {
    syncs.push_back((is_folder(descriptor) ? "folder, " : "file, ") + content(path));
    return 0;
  };
  write_file_atomically(path, "after");
  on_sync = nullptr;
  EXPECT_EQ(syncs, (std::vector<std::string>{"file, before", "folder, after"}));
}

TEST_F(AtomicFiles, SyncThatFailsIsAFailure) {
  const fs::path path = folder_ / "file";
  write_file_atomically(path, "before");
  on_sync = [](int) { return EIO; };
  const std::string message = refusal(path, "after");
  // File systems that have no sync of folders say so.
  on_sync = [](int descriptor) { return is_folder(descriptor) ? EINVAL : 0; };
  const std::string without_folders = refusal(folder_ / "other", "x");
  on_sync = nullptr;
  EXPECT_EQ(message, "can't write the file: Input/output error: " + path.string());
  EXPECT_EQ(content(path), "before");
  EXPECT_EQ(without_folders, "");
  EXPECT_EQ(files(), 2);
}

}  // namespace
}  // namespace subpixel
