#include "process/child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "base/work_counter.hpp"

namespace subpixel {
namespace {

using Clock = std::chrono::steady_clock;
using Kind = ChildOutcome::Kind;

constexpr std::size_t kErrorTailBytes = 4096;
constexpr int kPollMs = 100;       // how late a stop request or a limit is noticed
constexpr int kNotExecuted = 127;  // what a shell says when it can't execute a program
constexpr int kNotConfined = 126;
constexpr rlim_t kDescriptors = 1024;

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    fd_ = std::exchange(other.fd_, -1);
    return *this;
  }
  ~Descriptor() { close(); }
  int get() const { return fd_; }
  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }

 private:
  int fd_;
};

struct Pipe {
  Descriptor read_end, write_end;
};

std::optional<Pipe> make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  return Pipe{Descriptor(ends[0]), Descriptor(ends[1])};
}

// Lowers a limit of this process; 0 leaves it. `more`: of the hard limit.
void lower_limit(int resource, rlim_t most, rlim_t more = 0) {
  rlimit limit{};
  if (most == 0 || ::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most + more);
  limit.rlim_cur = std::min(limit.rlim_cur, most);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

// What the child needs, made before the fork.
struct Program {
  char* const* arguments;
  char* const* environment;
  int output, errors;
  pid_t parent;
  const ChildLimits& limits;
  const PreparedConfinement* confinement;
};

// Runs in the child between fork and exec, where only async-signal-safe calls are allowed (POSIX fork).
[[noreturn]] void become(const Program& program) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != program.parent) ::_exit(kNotExecuted);  // the parent died before the line above
  lower_limit(RLIMIT_AS, program.limits.address_space_bytes);
  lower_limit(RLIMIT_FSIZE, program.limits.file_bytes);
  lower_limit(RLIMIT_CPU, program.limits.processor_s, 1);  // SIGXCPU says why, SIGKILL a second later does not
  // A core file of a crashed replay is gigabytes that nobody asked for.
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::signal(SIGPIPE, SIG_DFL);
  const int input = ::open("/dev/null", O_RDONLY);
  if (input < 0 || ::dup2(input, 0) < 0 || ::dup2(program.output, 1) < 0 || ::dup2(program.errors, 2) < 0) {
    ::_exit(kNotExecuted);
  }
  // Connections and the store are closed on exec by whoever opened them; one that forgot must not matter. They end
  // here, for there may be thousands, and what comes now has to open files under a lower limit.
  ::syscall(SYS_close_range, 3u, ~0u, 0u);
  // Before the filter, which forbids it. What can't be counted is an empty file.
  if (program.limits.counts_instructions) {
    int counter = open_instruction_counter();
    if (counter < 0) counter = ::open("/dev/null", O_RDONLY);
    if (counter >= 0 && counter != kInstructionsDescriptor) {
      ::dup2(counter, kInstructionsDescriptor);
      ::close(counter);
    }
  }
  lower_limit(RLIMIT_NOFILE, kDescriptors);
  if (program.confinement != nullptr && !program.confinement->enter()) ::_exit(kNotConfined);
  ::execve(program.arguments[0], program.arguments, program.environment);
  ::_exit(kNotExecuted);
}

// Pointers to `texts`, and a last null.
std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> list;
  list.reserve(texts.size() + 1);
  for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
  list.push_back(nullptr);
  return list;
}

// This process's environment with `added`, whose names come first and hold.
std::vector<std::string> environment_with(const std::vector<std::string>& added) {
  std::vector<std::string> all = added;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const bool is_replaced = std::any_of(added.begin(), added.end(), [&](const std::string& mine) {
      return text.substr(0, text.find('=') + 1) == std::string_view(mine).substr(0, mine.find('=') + 1);
    });
    if (!is_replaced) all.emplace_back(text);
  }
  return all;
}

// Splits what comes from a pipe into lines of bounded length.
class LineSplitter {
 public:
  LineSplitter(std::size_t limit, const LineHandler& handler) : limit_(limit), handler_(handler) {}

  // What ends the child, if anything does.
  std::optional<Kind> take(std::string_view bytes) {
    while (!bytes.empty()) {
      const std::size_t newline = bytes.find('\n');
      pending_.append(bytes.substr(0, newline));
      if (pending_.size() > limit_) return Kind::line_too_long;
      if (newline == std::string_view::npos) return std::nullopt;
      if (!deliver()) return Kind::refused;
      bytes.remove_prefix(newline + 1);
    }
    return std::nullopt;
  }

  // A last line without a newline counts when the child ended by itself.
  bool finish() { return pending_.empty() || deliver(); }

 private:
  bool deliver() {
    const std::string line = std::exchange(pending_, std::string());
    return handler_(line);
  }

  std::size_t limit_;
  const LineHandler& handler_;
  std::string pending_;
};

std::string duration_text(std::chrono::milliseconds duration) {
  return duration.count() % 1000 == 0 ? fmt::format("{} s", duration.count() / 1000)
                                      : fmt::format("{} ms", duration.count());
}

std::string reason_for(const ChildOutcome& outcome, const ChildLimits& limits) {
  switch (outcome.kind) {
    case Kind::exited:
      if (outcome.code == 0) return "";
      if (outcome.code == kNotExecuted) return "the worker program can't be executed";
      if (outcome.code == kNotConfined) return "the worker process can't be confined, so it was not started";
      return fmt::format("the worker process ended with exit code {}", outcome.code);
    case Kind::signalled:
      if (outcome.code == SIGXCPU) {
        return fmt::format("the worker process used more than {} s of processor time and was ended",
                           limits.processor_s);
      }
      return fmt::format("the worker process was ended by signal {} ({}){}", outcome.code, ::strsignal(outcome.code),
                         outcome.code == SIGKILL ? ", most likely because memory ran out" : "");
    case Kind::silent:
      return fmt::format("the worker process said nothing for {} and was ended", duration_text(limits.silence));
    case Kind::too_long:
      return fmt::format("the worker process ran longer than {} and was ended", duration_text(limits.duration));
    case Kind::line_too_long:
      return fmt::format("the worker process wrote a line of more than {} bytes and was ended", limits.line_bytes);
    case Kind::refused:
      return "the worker process was ended because its output was refused";
    case Kind::not_started:
      return fmt::format("the worker process could not be started: {}", ::strerror(outcome.code));
    case Kind::stopped:
      return "";
  }
  return "";
}

// Reads both pipes until the child ends or must be ended.
class Watch {
 public:
  Watch(const ChildLimits& limits, std::stop_token stop, const LineHandler& on_line, Descriptor output,
        Descriptor errors)
      : limits_(limits),
        stop_(std::move(stop)),
        lines_(limits.line_bytes, on_line),
        output_(std::move(output)),
        errors_(std::move(errors)) {}

  // Nothing when both pipes came to their end, else why the child has to be ended.
  std::optional<Kind> run(pid_t child) {
    const Clock::time_point start = Clock::now();
    last_line_ = start;
    while (output_.get() >= 0 || errors_.get() >= 0) {
      if (stop_.stop_requested()) return Kind::stopped;
      const Clock::time_point now = Clock::now();
      if (now - start > limits_.duration) return Kind::too_long;
      if (now - last_line_ > limits_.silence) return Kind::silent;
      // A grandchild can hold the pipes open for ever; the child's own end is what counts.
      if (child_ended(child) && !pipes_have_data()) break;
      if (const std::optional<Kind> verdict = poll_once(kPollMs)) return verdict;
    }
    // The pipes can close long before the process ends.
    while (!child_ended(child)) {
      if (stop_.stop_requested()) return Kind::stopped;
      if (Clock::now() - last_line_ > limits_.silence) return Kind::silent;
      ::poll(nullptr, 0, 10);
    }
    if (!lines_.finish()) return Kind::refused;
    return std::nullopt;
  }

  std::string error_tail() const { return error_tail_; }

 private:
  // The exit status stays to be collected (WNOWAIT), so that the process group can't be someone else's yet.
  static bool child_ended(pid_t child) {
    siginfo_t info{};
    return ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == child;
  }

  bool pipes_have_data() const {
    std::array<pollfd, 2> waits{pollfd{output_.get(), POLLIN, 0}, pollfd{errors_.get(), POLLIN, 0}};
    return ::poll(waits.data(), waits.size(), 0) > 0;
  }

  std::optional<Kind> poll_once(int timeout_ms) {
    std::array<pollfd, 2> waits{pollfd{output_.get(), POLLIN, 0}, pollfd{errors_.get(), POLLIN, 0}};
    if (::poll(waits.data(), waits.size(), timeout_ms) <= 0) return std::nullopt;
    if (waits[1].revents != 0) {
      const std::string_view bytes = read_some(errors_);
      error_tail_.append(bytes);
      if (error_tail_.size() > kErrorTailBytes) error_tail_.erase(0, error_tail_.size() - kErrorTailBytes);
    }
    if (waits[0].revents != 0) {
      const std::string_view bytes = read_some(output_);
      if (bytes.find('\n') != std::string_view::npos) last_line_ = Clock::now();
      return lines_.take(bytes);
    }
    return std::nullopt;
  }

  std::string_view read_some(Descriptor& pipe) {
    const ssize_t got = ::read(pipe.get(), block_.data(), block_.size());
    if (got > 0) return {block_.data(), static_cast<std::size_t>(got)};
    if (got == 0 || errno != EINTR) pipe.close();
    return {};
  }

  const ChildLimits& limits_;
  std::stop_token stop_;
  LineSplitter lines_;
  Descriptor output_, errors_;
  std::string error_tail_;
  Clock::time_point last_line_;
  std::array<char, 65536> block_{};
};

}  // namespace

ChildOutcome run_child(const std::vector<std::string>& arguments, const ChildLimits& limits, std::stop_token stop,
                       const LineHandler& on_line) {
  ChildOutcome outcome;
  const std::vector<char*> argv = pointers(arguments);
  std::vector<std::string> added = limits.environment;
  if (limits.counts_instructions) added.push_back(std::string(kInstructionsVariable) + "=1");
  const std::vector<std::string> variables = environment_with(added);
  const std::vector<char*> environment = pointers(variables);
  std::optional<PreparedConfinement> confinement;
  if (limits.confinement) confinement.emplace(*limits.confinement, arguments[0]);

  std::optional<Pipe> output = make_pipe(), errors = make_pipe();
  const pid_t parent = ::getpid();
  // fork, not posix_spawn: the parent-death signal has to be set by the child itself.
  const pid_t child = output && errors ? ::fork() : -1;
  if (child < 0) {
    outcome.kind = Kind::not_started;
    outcome.code = errno;
    outcome.reason = reason_for(outcome, limits);
    return outcome;
  }
  if (child == 0) {
    become({argv.data(), environment.data(), output->write_end.get(), errors->write_end.get(), parent, limits,
            confinement ? &*confinement : nullptr});
  }
  ::setpgid(child, child);  // also done by the child: whichever comes first
  output->write_end.close();
  errors->write_end.close();

  // However this scope is left (a line handler may throw), the group is killed and the child collected.
  struct Collect {
    pid_t pid;
    int status = 0;
    bool done = false;
    void kill_and_wait() {
      if (std::exchange(done, true)) return;
      ::kill(-pid, SIGKILL);
      while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
      }
    }
    ~Collect() { kill_and_wait(); }
  } collect{child};

  Watch watch(limits, std::move(stop), on_line, std::move(output->read_end), std::move(errors->read_end));
  const std::optional<Kind> verdict = watch.run(child);
  collect.kill_and_wait();  // after a natural end: what the child left behind in its group
  outcome.error_tail = watch.error_tail();
  if (verdict) {
    outcome.kind = *verdict;
  } else if (WIFSIGNALED(collect.status)) {
    outcome.kind = Kind::signalled;
    outcome.code = WTERMSIG(collect.status);
  } else {
    outcome.code = WEXITSTATUS(collect.status);
  }
  outcome.reason = reason_for(outcome, limits);
  return outcome;
}

}  // namespace subpixel
