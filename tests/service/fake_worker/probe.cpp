#include "tests/service/fake_worker/probe.hpp"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <iostream>
#include <map>
#include <thread>
#include <vector>

#include "process/confinement.hpp"

namespace subpixel::tests {
namespace {

int opened(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags | O_CLOEXEC, 0644);
  if (file >= 0) ::close(file);
  return file;
}

int forked(const std::function<void()>& in_child) {
  const pid_t child = ::fork();
  if (child == 0) {
    in_child();
    ::_exit(errno);
  }
  if (child < 0) return -1;
  int status = 0;
  ::waitpid(child, &status, 0);
  errno = WEXITSTATUS(status);
  return errno == 0 ? 0 : -1;
}

void become(const char* program) {
  char* arguments[] = {const_cast<char*>(program), nullptr};
  ::execv(program, arguments);
}

int written_beyond(const std::string& path, std::size_t bytes) {
  ::signal(SIGXFSZ, SIG_IGN);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  const std::vector<char> block(1 << 16);
  ssize_t step = file < 0 ? -1 : 0;
  for (std::size_t at = 0; step >= 0 && at < bytes; at += block.size())
    step = ::write(file, block.data(), block.size());
  if (file >= 0) ::close(file);
  return step < 0 ? -1 : 0;
}

int mapped(std::size_t bytes, int protection) {
  void* const at = ::mmap(nullptr, bytes, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return at == MAP_FAILED ? -1 : 0;
}

const std::map<std::string, std::function<long(const std::string&)>>& tries() {
  static const std::map<std::string, std::function<long(const std::string&)>> all{
      {"read", [](const std::string& path) { return opened(path, O_RDONLY); }},
      {"list", [](const std::string& path) { return opened(path, O_RDONLY | O_DIRECTORY); }},
      {"write", [](const std::string& path) { return opened(path, O_WRONLY); }},
      {"create", [](const std::string& path) { return opened(path, O_WRONLY | O_CREAT | O_EXCL); }},
      {"make_folder", [](const std::string& path) { return ::mkdir(path.c_str(), 0755); }},
      {"make_link", [](const std::string& path) { return ::symlink("/etc/passwd", path.c_str()); }},
      {"make_pipe", [](const std::string& path) { return ::mkfifo(path.c_str(), 0644); }},
      {"remove", [](const std::string& path) { return ::unlink(path.c_str()); }},
      {"rename", [](const std::string& path) { return ::rename(path.c_str(), (path + ".moved").c_str()); }},
      {"shorten", [](const std::string& path) { return ::truncate(path.c_str(), 0); }},
      {"change_mode", [](const std::string& path) { return ::chmod(path.c_str(), 0600); }},
      {"change_owner", [](const std::string& path) { return ::chown(path.c_str(), ::getuid(), ::getgid()); }},
      {"change_times", [](const std::string& path) { return ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0); }},
      {"large_file", [](const std::string& path) { return written_beyond(path, std::size_t{4} << 20); }},
      {"memory", [](const std::string&) { return mapped(std::size_t{64} << 30, PROT_READ); }},
      {"code", [](const std::string&) { return mapped(4096, PROT_READ | PROT_WRITE | PROT_EXEC); }},
      {"thread", [](const std::string&) { return std::thread([] {}).join(), 0; }},
      {"internet_socket", [](const std::string&) { return ::socket(AF_INET, SOCK_STREAM, 0); }},
      {"internet6_socket", [](const std::string&) { return ::socket(AF_INET6, SOCK_DGRAM, 0); }},
      {"local_socket", [](const std::string&) { return ::socket(AF_UNIX, SOCK_STREAM, 0); }},
      {"netlink_socket", [](const std::string&) { return ::socket(AF_NETLINK, SOCK_RAW, 0); }},
      {"socket_pair",
       [](const std::string&) {
         int ends[2];
         return ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends);
       }},
      {"fork", [](const std::string&) { return forked([] { errno = 0; }); }},
      {"run_in_child",
       [](const std::string& program) {
         return forked([&] { become(program.empty() ? "/bin/true" : program.c_str()); });
       }},
      {"run", [](const std::string&) { return become("/bin/true"), -1; }},
      {"run_itself", [](const std::string& path) { return become(path.c_str()), -1; }},
      {"run_itself_forbidden",
       [](const std::string& path) {
         forbid_programs();
         return become(path.c_str()), -1;
       }},
      {"trace", [](const std::string&) { return ::ptrace(PTRACE_ATTACH, ::getppid(), nullptr, nullptr); }},
      {"signal", [](const std::string&) { return ::kill(::getppid(), 0); }},
      {"signal_thread", [](const std::string&) { return ::syscall(SYS_tgkill, ::getppid(), ::getppid(), 0); }},
      {"signal_itself", [](const std::string&) { return ::syscall(SYS_tgkill, ::getpid(), ::getpid(), 0); }},
      {"mount", [](const std::string& path) { return ::mount("none", path.c_str(), "tmpfs", 0, nullptr); }},
      {"namespace", [](const std::string&) { return ::unshare(CLONE_NEWUSER); }},
      {"namespace_by_clone",
       [](const std::string&) { return ::syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, nullptr, nullptr, nullptr, 0); }},
      {"change_root", [](const std::string& path) { return ::chroot(path.c_str()); }},
      {"io_uring",
       [](const std::string&) {
         std::vector<char> parameters(512);
         return ::syscall(SYS_io_uring_setup, 8, parameters.data());
       }},
      {"priority", [](const std::string&) { return ::setpriority(PRIO_PROCESS, 0, 19); }},
      // The number that the test's process has open.
      {"inherited", [](const std::string& path) { return ::fcntl(std::stoi(path), F_GETFD); }},
  };
  return all;
}

}  // namespace

int probe(const std::string& what, const std::string& path) {
  if (what == "burn") {
    volatile std::uint64_t turns = 0;
    while (true) turns = turns + 1;
  }
  const long result = tries().at(what)(path);
  const int error = errno;
  std::cout << (result >= 0 ? std::string("done") : std::string("refused: ") + ::strerror(error)) << std::endl;
  return 0;
}

}  // namespace subpixel::tests
