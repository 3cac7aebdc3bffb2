#include "server/engine/worker_place.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <csignal>
#include <cstdlib>
#include <vector>

#include "base/printable.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxPlaceText = 200, kMaxLastWords = 500;

std::string last_line(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.remove_suffix(1);
  const std::size_t line = text.rfind('\n');
  return printable(line == std::string_view::npos ? text : text.substr(line + 1), kMaxLastWords);
}

// What is set of what makes Mesa compile shaders otherwise than it would here, and of layers that could crash instead
// of the driver.
std::vector<std::string> overrides() {
  std::vector<std::string> set;
  for (const char* const name : {"GALLIUM_OVERRIDE_CPU_CAPS", "LP_NATIVE_VECTOR_WIDTH", "LP_DEBUG", "LP_PERF",
                                 "GALLIVM_DEBUG", "GALLIVM_PERF", "NIR_DEBUG", "VK_INSTANCE_LAYERS"}) {
    const char* const value = std::getenv(name);
    if (value != nullptr && *value != '\0') set.push_back(fmt::format("{}={}", name, printable(value, 60)));
  }
  return set;
}

// Those by which a processor or the C library ends a program for what the program did. Of a replay that is nearly
// always code that the driver compiled, or the compiler itself.
bool is_a_crash(int signal) {
  return signal == SIGILL || signal == SIGBUS || signal == SIGSEGV || signal == SIGFPE || signal == SIGABRT;
}

}  // namespace

void WorkerPlace::progress(std::string_view stage, std::string_view detail) {
  if (stage == "device") {
    device_ = printable(detail, kMaxPlaceText);
  } else {
    at_ = printable(fmt::format("{}: {}", stage, detail), kMaxPlaceText);
  }
}

std::string WorkerPlace::end_in_words(const ChildOutcome& outcome) const {
  if (outcome.reason.empty()) return "";
  std::string words = outcome.reason;
  if (outcome.kind == ChildOutcome::Kind::signalled) {
    if (!at_.empty()) words += fmt::format("; it was at \"{}\"", at_);
    if (!device_.empty()) words += " on " + device_;
    if (is_a_crash(outcome.code)) {
      const std::vector<std::string> set = overrides();
      words += fmt::format("; try {}other techniques, another version of the driver, another machine",
                           set.empty() ? "" : fmt::format("without {}, ", fmt::join(set, " ")));
    }
  }
  const std::string last = last_line(outcome.error_tail);
  return last.empty() ? words : fmt::format("{}; its last words: {}", words, last);
}

}  // namespace subpixel::server
