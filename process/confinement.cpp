#include "process/confinement.hpp"

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string_view>

namespace subpixel {
namespace {

// Sanitizers look for leaks by ptrace from a process of their own, and start their program again with other settings.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

// Debian 12's header ends with version 2 of Landlock; these are of the kernel's documentation of later ones.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14, kIoctlDevice = std::uint64_t{1} << 15;
constexpr std::uint64_t kBindTcp = 1, kConnectTcp = 2;
constexpr std::uint64_t kScopeAbstractSockets = 1, kScopeSignals = 2;
constexpr int kVersionOfTruncate = 3, kVersionOfTcp = 4, kVersionOfIoctl = 5, kVersionOfScopes = 6;
struct RulesetAttributes {
  std::uint64_t file_system, network, scoped;
};

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
// No devices, sockets, pipes or links among what a worker makes: all of it is read by the service.
constexpr std::uint64_t kWrite = kRead | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                                 LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR |
                                 LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REFER | kTruncate;
constexpr std::uint64_t kOfFiles = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                                   LANDLOCK_ACCESS_FS_READ_FILE | kTruncate | kIoctlDevice;

// What programs read to start, the Vulkan loader to find drivers, and Mesa and LLVM to know the machine.
constexpr const char* kSystemFiles[] = {
    "/usr",          "/lib",          "/lib32",     "/lib64",         "/etc/ld.so.cache", "/etc/ld.so.preload",
    "/etc/vulkan",   "/etc/drirc",    "/etc/glvnd", "/etc/localtime", "/proc/self",       "/proc/thread-self",
    "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/sys/devices",   "/sys/fs/cgroup",   "/dev/zero",
    "/dev/random",   "/dev/urandom"};
// Folders and files of these, in lists, are an administrator's choice of drivers and libraries.
constexpr const char* kVariables[] = {"LD_LIBRARY_PATH", "VK_DRIVER_FILES",   "VK_ADD_DRIVER_FILES", "VK_ICD_FILENAMES",
                                      "VK_LAYER_PATH",   "VK_ADD_LAYER_PATH", "SUBPIXEL_SHADERS",    "SUBPIXEL_ASSETS"};

constexpr const char* kForbidden[] = {
    // Other processes' memory, descriptors and lives.
    "process_vm_readv", "process_vm_writev", "process_madvise", "kcmp", "pidfd_open", "pidfd_getfd",
    "pidfd_send_signal", "migrate_pages", "move_pages", "setpriority", "ioprio_set", "sched_setscheduler",
    // Attributes of files, which Landlock does not hold.
    "chown", "fchown", "lchown", "fchownat", "setxattr", "lsetxattr", "fsetxattr", "setxattrat", "removexattr",
    "lremovexattr", "fremovexattr", "removexattrat", "truncate", "mknod", "mknodat", "name_to_handle_at",
    "open_by_handle_at", "fanotify_init", "file_setattr",
    // Mounts and namespaces.
    "mount", "umount", "umount2", "pivot_root", "chroot", "move_mount", "open_tree", "open_tree_attr", "fsopen",
    "fsconfig", "fsmount", "fspick", "mount_setattr", "setns", "unshare", "quotactl", "quotactl_fd",
    // Ways round a filter, and parts of the kernel that nothing here needs.
    "io_uring_setup", "io_uring_enter", "io_uring_register", "bpf", "perf_event_open", "userfaultfd", "keyctl",
    "add_key", "request_key", "kexec_load", "kexec_file_load", "init_module", "finit_module", "delete_module", "reboot",
    "swapon", "swapoff", "acct", "settimeofday", "clock_settime", "clock_adjtime", "adjtimex", "stime", "sethostname",
    "setdomainname", "iopl", "ioperm", "modify_ldt", "syslog", "vhangup", "lookup_dcookie", "uselib",
    // Signals to others, modes and times of files, ways to other processes.
    "kill", "tkill", "rt_sigqueueinfo", "rt_tgsigqueueinfo", "chmod", "fchmod", "fchmodat", "fchmodat2", "utime",
    "utimes", "utimensat", "futimesat", "socket", "socketpair", "socketcall", "connect", "bind", "listen", "accept",
    "accept4", "shmget", "shmat", "msgget", "semget", "mq_open", "execveat"};

int landlock_version() {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version > 0 ? static_cast<int>(version) : 0;
}

bool has_seccomp_filters() {
  // EFAULT: it would have read the filter that is not there.
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, nullptr, 0, 0) != 0 && errno == EFAULT;
}

std::uint64_t handled_file_access(int version) {
  std::uint64_t access = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
  if (version >= 2) access |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= kVersionOfTruncate) access |= kTruncate;
  if (version >= kVersionOfIoctl) access |= kIoctlDevice;
  return access;
}

// The dynamic loader that this program was started by, empty when there is none.
std::string dynamic_loader() {
  std::string path;
  const auto look = [](dl_phdr_info* info, std::size_t, void* found) {
    for (int i = 0; i < info->dlpi_phnum; ++i) {
      if (info->dlpi_phdr[i].p_type != PT_INTERP) continue;
      // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader says it as a number
      *static_cast<std::string*>(found) = reinterpret_cast<const char*>(info->dlpi_addr + info->dlpi_phdr[i].p_vaddr);
    }
    return 1;  // the first is the program itself
  };
  ::dl_iterate_phdr(look, &path);
  return path;
}

using Filter = std::unique_ptr<void, void (*)(scmp_filter_ctx)>;

Filter make_filter() {
  Filter filter(::seccomp_init(SCMP_ACT_ALLOW), &::seccomp_release);
  if (!filter) throw std::runtime_error("no seccomp filter can be made");
  return filter;
}

void refuse(const Filter& filter, const char* name, int error = EPERM, const std::vector<scmp_arg_cmp>& when = {}) {
  const int number = ::seccomp_syscall_resolve_name(name);
  if (number == __NR_SCMP_ERROR) return;  // newer than libseccomp, or of another processor
  const int failure = ::seccomp_rule_add_array(filter.get(), SCMP_ACT_ERRNO(static_cast<std::uint32_t>(error)), number,
                                               static_cast<unsigned>(when.size()), when.data());
  // -EDOM, -EINVAL: a call that this processor does not have, or with other arguments.
  if (failure != 0 && failure != -EDOM && failure != -EINVAL) {
    throw std::runtime_error(std::string("no seccomp rule can be made for ") + name);
  }
}

std::vector<sock_filter> compiled(const Filter& filter) {
  const int file = ::memfd_create("filter", MFD_CLOEXEC);
  if (file < 0) throw std::runtime_error("the seccomp filter can't be compiled");
  std::vector<sock_filter> program;
  if (::seccomp_export_bpf(filter.get(), file) == 0) {
    const off_t bytes = ::lseek(file, 0, SEEK_END);
    program.resize(static_cast<std::size_t>(bytes) / sizeof(sock_filter));
    if (::pread(file, program.data(), static_cast<std::size_t>(bytes), 0) != bytes) program.clear();
  }
  ::close(file);
  if (program.empty()) throw std::runtime_error("the seccomp filter can't be compiled");
  return program;
}

std::vector<sock_filter> filter_for(bool runs_programs) {
  const Filter filter = make_filter();
  for (const char* const name : kForbidden) refuse(filter, name);
  if (!kSanitized) {
    refuse(filter, "ptrace");
    refuse(filter, "personality");
  }
  constexpr std::uint64_t kNamespaces =
      CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;
  for (std::uint64_t flag = 1; flag <= kNamespaces; flag <<= 1) {
    if ((kNamespaces & flag) != 0) refuse(filter, "clone", EPERM, {SCMP_A0_64(SCMP_CMP_MASKED_EQ, flag, flag)});
  }
  // Its flags are in memory, where no filter looks; the C library takes clone then.
  refuse(filter, "clone3", ENOSYS);
  if (!runs_programs && !kSanitized) {
    refuse(filter, "clone", EPERM, {SCMP_A0_64(SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0)});
    refuse(filter, "fork");
    refuse(filter, "vfork");
  }
  return compiled(filter);
}

}  // namespace

PreparedConfinement::PreparedConfinement(const Confinement& confinement, const std::string& program)
    : landlock_version_(landlock_version()) {
  const auto add = [&](const std::string& path, std::uint64_t access) {
    if (!path.empty()) rules_.push_back({path, access & handled_file_access(landlock_version_)});
  };
  for (const char* const path : kSystemFiles) add(path, kRead);
  add("/dev/null", LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE);
  for (const char* const variable : kVariables) {
    const char* const value = std::getenv(variable);
    for (std::string_view rest = value != nullptr ? value : ""; !rest.empty();) {
      const std::string_view one = rest.substr(0, rest.find(':'));
      add(std::string(one), kRead);
      rest.remove_prefix(std::min(one.size() + 1, rest.size()));
    }
  }
  // Only itself and what loads it: another program would be as confined, but there is no use for one.
  add(program, LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE);
  add(dynamic_loader(), LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE);
  const bool runs_programs = !confinement.interpreter.empty();
  if (runs_programs) {
    for (const char* const folder : {"/usr", "/bin", "/lib", "/lib64"}) add(folder, kRead | LANDLOCK_ACCESS_FS_EXECUTE);
    add(confinement.interpreter, kRead | LANDLOCK_ACCESS_FS_EXECUTE);
  }
  for (const std::string& path : confinement.readable) add(path, kRead);
  for (const std::string& path : confinement.writable) add(path, kWrite);
  if (has_seccomp_filters()) filter_ = filter_for(runs_programs);
}

bool PreparedConfinement::enter() const noexcept {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return false;
  if (landlock_version_ > 0 && !enter_landlock()) return false;
  if (filter_.empty()) return true;
  const sock_fprog program{static_cast<unsigned short>(filter_.size()), const_cast<sock_filter*>(filter_.data())};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
}

bool PreparedConfinement::enter_landlock() const noexcept {
  RulesetAttributes attributes{handled_file_access(landlock_version_), 0, 0};
  if (landlock_version_ >= kVersionOfTcp) attributes.network = kBindTcp | kConnectTcp;
  if (landlock_version_ >= kVersionOfScopes) attributes.scoped = kScopeAbstractSockets | kScopeSignals;
  const auto ruleset = static_cast<int>(::syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes), 0));
  if (ruleset < 0) return false;
  bool complete = true;
  for (const Rule& rule : rules_) {
    // Here and not before the fork: /proc/self is another one there.
    const int file = ::open(rule.path.c_str(), O_PATH | O_CLOEXEC);
    if (file < 0) continue;  // not there, so nothing to allow
    struct stat status {};
    const bool is_folder = ::fstat(file, &status) == 0 && S_ISDIR(status.st_mode);
    const landlock_path_beneath_attr beneath{is_folder ? rule.access : rule.access & kOfFiles, file};
    complete = complete && ::syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) == 0;
    ::close(file);
  }
  complete = complete && ::syscall(SYS_landlock_restrict_self, ruleset, 0) == 0;
  ::close(ruleset);
  return complete;
}

void forbid_programs() {
  if (kSanitized || !has_seccomp_filters()) return;
  const Filter filter = make_filter();
  refuse(filter, "execve");
  refuse(filter, "execveat");
  if (::seccomp_load(filter.get()) != 0) throw std::runtime_error("the seccomp filter is refused");
}

std::vector<std::string> confinement_gaps() {
  std::vector<std::string> gaps;
  const int version = landlock_version();
  if (version == 0) {
    gaps.emplace_back("the kernel has no Landlock: a worker reads and writes whatever the service's user can");
  }
  if (version < kVersionOfScopes) {
    gaps.emplace_back("the kernel's Landlock does not hold signals: a worker can end processes of the service's user");
  }
  if (!has_seccomp_filters()) {
    gaps.emplace_back("the kernel has no seccomp filters: a worker can open sockets and start processes");
  }
  return gaps;
}

}  // namespace subpixel
