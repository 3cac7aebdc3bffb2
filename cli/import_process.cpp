#include "cli/import_process.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <system_error>
#include <thread>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "base/python_interpreter.hpp"
#include "capture_format/writer.hpp"
#include "cli/written_summary.hpp"
#include "process/child_process.hpp"
#include "process/confinement.hpp"

namespace subpixel::cli {
namespace {

using nlohmann::json;

// A folder beside the file to be: what is written there becomes that file by a rename, and all else goes with it. In
// place of one a name among temporary files: a folder for what is not the capture.
class FolderBeside {
 public:
  explicit FolderBeside(const std::filesystem::path& target) : target_(target) {
    std::string name = target.string() + ".XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) fail(errno);
    folder_ = name;
  }
  FolderBeside(const FolderBeside&) = delete;
  FolderBeside& operator=(const FolderBeside&) = delete;
  ~FolderBeside() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path file() const { return folder_ / "capture"; }
  void rename_to_target() const {
    if (::rename(file().c_str(), target_.c_str()) != 0) fail(errno);
    const int error = sync_folder(target_.has_parent_path() ? target_.parent_path() : std::filesystem::path("."));
    if (error != 0) fail(error);
  }

 private:
  [[noreturn]] void fail(int error) const {
    throw InputError("can't write the capture", std::generic_category().message(error), target_.string());
  }

  std::filesystem::path target_, folder_;
};

// While this lives, signals that end a program are held back and ask for a stop instead; afterwards they do what they
// do, unless something is thrown.
class EndingSignals {
 public:
  EndingSignals() : watcher_([this](const std::stop_token& ended) { watch(ended); }) {}
  EndingSignals(const EndingSignals&) = delete;
  EndingSignals& operator=(const EndingSignals&) = delete;
  ~EndingSignals() = default;

  std::stop_token stop_token() const { return stop_.get_token(); }

  // Ends this process by the signal that came, if one did.
  void obey() {
    watcher_.request_stop();
    watcher_.join();
    blocked_.restore();
    if (signal_ != 0) ::raise(signal_);
  }

 private:
  struct Blocked {
    sigset_t set, before;
    Blocked() {
      ::sigemptyset(&set);
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction current {};
        const bool is_known = ::sigaction(signal, nullptr, &current) == 0;
        if (is_known && current.sa_handler != SIG_IGN) ::sigaddset(&set, signal);  // nohup ignores one
      }
      ::pthread_sigmask(SIG_BLOCK, &set, &before);
    }
    ~Blocked() { restore(); }
    void restore() const { ::pthread_sigmask(SIG_SETMASK, &before, nullptr); }
  };

  void watch(const std::stop_token& ended) {
    constexpr timespec kTick{0, 20'000'000};
    while (!ended.stop_requested()) {
      const int signal = ::sigtimedwait(&blocked_.set, nullptr, &kTick);
      if (signal <= 0) continue;
      signal_ = signal;
      stop_.request_stop();
    }
  }

  Blocked blocked_;  // before the thread starts, which inherits it
  std::atomic<int> signal_{0};
  std::stop_source stop_;
  std::jthread watcher_;
};

// What the child said, and how it ended if it could not say so.
class Conversation {
 public:
  bool take(std::string_view line) {
    const std::optional<json> message = parse_json_line(line);
    if (!message) return true;  // some library's own word
    const std::string type = text_or_empty(*message, "type");
    if (type == "progress") fmt::print(stderr, "{}\n", printable(text_or_empty(*message, "text")));
    if (type == "done") summary_ = text_or_empty(*message, "summary");
    if (type == "error") error_ = text_or_empty(*message, "text");
    return true;
  }

  const std::optional<std::string>& summary() const { return summary_; }
  const std::optional<std::string>& error() const { return error_; }

 private:
  std::optional<std::string> summary_, error_;
};

// An error whose text is complete.
template <typename Kind>
class Reported : public Kind {
 public:
  explicit Reported(std::string text) : Kind("", "", ""), text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

std::string why_it_ended(const ChildOutcome& outcome, const ImportLimits& limits) {
  switch (outcome.kind) {
    case ChildOutcome::Kind::signalled:
      return fmt::format("the reader crashed (signal {}){}", outcome.code,
                         outcome.code == SIGKILL ? ", most likely because memory ran out" : "");
    case ChildOutcome::Kind::silent:
    case ChildOutcome::Kind::too_long:
      return fmt::format("the reader took longer than {} s (--limit-seconds)", limits.duration.count());
    case ChildOutcome::Kind::exited:
      return fmt::format("the reader ended with exit code {} and no reason", outcome.code);
    default:
      return outcome.reason;
  }
}

[[noreturn]] void throw_reported(int code, const std::string& text) {
  if (code == kUsageExit) throw Reported<UsageError>(text);
  if (code == kDeviceExit) throw Reported<DeviceError>(text);
  if (code == kInternalExit) throw Reported<InternalError>(text);
  throw Reported<InputError>(text);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

void say(const json& message) {
  // Text in other people's files is of any encoding.
  fmt::print("{}\n", message.dump(-1, ' ', false, json::error_handler_t::replace));
  std::fflush(stdout);
}

capture::Capture import_model(const std::string& in, const capture::ImportOptions& options) {
  forbid_programs();
  return capture::import_file(in, options);
}

}  // namespace

std::uint64_t default_import_address_space() {
#if defined(__SANITIZE_ADDRESS__)
  return 0;
#else
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return 0;
  constexpr std::uint64_t kMost = std::uint64_t{8} << 30;
  return std::min(static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) / 4 * 3, kMost);
#endif
}

void import_in_child(const std::string& in, const std::filesystem::path& out, const std::vector<std::string>& options,
                     const ImportLimits& limits) {
  std::error_code ignored;
  const auto status = std::filesystem::status(out, ignored);
  // A device or a pipe is written in place: renaming would put a file where it was.
  const bool in_place = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  std::optional<EndingSignals> signals(std::in_place);
  Conversation conversation;
  ChildOutcome outcome;
  {
    const FolderBeside folder(in_place ? std::filesystem::temp_directory_path() / "subpixel-import" : out);
    const std::string own_folder = std::filesystem::absolute(folder.file()).parent_path().string();
    const std::string file = in_place ? out.string() : folder.file().string();
    std::vector<std::string> arguments{std::filesystem::read_symlink("/proc/self/exe").string(), "import-worker"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    arguments.insert(arguments.end(), {"--", in, file});
    ChildLimits child_limits;
    child_limits.duration = limits.duration.count() > 0 ? limits.duration : std::chrono::hours(24 * 365);
    child_limits.silence = child_limits.duration;
    child_limits.address_space_bytes = limits.address_space_bytes;
    child_limits.environment.push_back("TMPDIR=" + own_folder);
    // Who imports on the command line may read what they may; the reader of someone else's file writes nothing but the
    // capture, opens no connection and, but for RenderDoc's Python, starts nothing.
    if (limits.is_confined) {
      child_limits.confinement = Confinement{{"/"}, {own_folder}};
      if (is_renderdoc(in)) child_limits.confinement->interpreter = python_interpreter();
      if (in_place) child_limits.confinement->writable.push_back(file);
    }
    outcome = run_child(arguments, child_limits, signals->stop_token(),
                        [&](std::string_view line) { return conversation.take(line); });
    const bool ended_well = outcome.kind == ChildOutcome::Kind::exited && outcome.code == 0 && conversation.summary();
    if (ended_well && !in_place) folder.rename_to_target();
    if (!ended_well && outcome.kind == ChildOutcome::Kind::exited && outcome.code != 0 && conversation.error()) {
      throw_reported(outcome.code, replaced(*conversation.error(), printable(file), out.string()));
    }
    if (!ended_well && outcome.kind != ChildOutcome::Kind::stopped) {
      throw InputError("can't import the model", why_it_ended(outcome, limits), in);
    }
  }
  signals->obey();
  fmt::print("{}: {}\n", printable(out.string()), conversation.summary().value_or(""));
}

int import_worker(const std::string& in, const std::filesystem::path& out, capture::ImportOptions options,
                  const RenderDocOptions& renderdoc) {
  const auto fail = [](int code, const std::string& text) {
    say({{"type", "error"}, {"text", printable(text)}});  // bytes that are no UTF-8 would not go through JSON
    return code;
  };
  options.progress = [](const std::string& line) { say({{"type", "progress"}, {"text", printable(line)}}); };
  try {
    // What is not written in place goes to a folder of its own (import_in_child), which takes all else with it.
    const std::filesystem::path scratch = std::filesystem::exists(out) ? std::filesystem::temp_directory_path()
                                                                       : std::filesystem::absolute(out).parent_path();
    const capture::Capture made =
        is_renderdoc(in) ? import_renderdoc(in, renderdoc, scratch) : import_model(in, options);
    capture::write_capture(made, out);
    say({{"type", "done"}, {"summary", written_summary(made, out)}});
    return 0;
  } catch (const std::bad_alloc&) {
    return fail(kInputExit,
                fmt::format("can't import the model: it needs more memory than --limit-memory allows: {}", in));
  } catch (...) {
    const Failure end = failure_of(std::current_exception());
    return fail(end.exit_code, end.message);
  }
}

}  // namespace subpixel::cli
