// A stand-in for `subpixel worker` and `subpixel info`: it speaks the worker protocol without a device and goes wrong
// on request. Its "captures" are text: "FAKE " and a JSON object that says how to behave:
//   title, frames, notices   what `info` reports
//   result_ms           how long each result takes
//   fail_at, how        before result number fail_at (from 0, skipped ones counted): see misbehave()
//   times               it goes wrong so often and then no more; without it always
//   reach               the file that `reach` and `info_reach` try to open
//   log                 a file of the cache folder that gets a line "frame/technique" for each result measured
//   width, height       of the images; 0: as asked for
//   tweak               a file; while it is there, its JSON object changes what one technique measures: `technique`,
//                       `slower` (factor), `executions` (added), `mse` (factor), `pixel` (added to the first one)
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "tests/service/fake_worker/answers.hpp"
#include "tests/service/fake_worker/fake_capture.hpp"
#include "tests/service/fake_worker/made_up_result.hpp"
#include "tests/service/fake_worker/probe.hpp"

namespace subpixel::tests {
namespace {

using nlohmann::json;

void say(const json& message) {
  std::cout << message.dump() << std::endl;
}

// Whether it is time to go wrong once more: the cache folder outlives workers, and a file in it counts.
bool is_due(const json& fake, const std::filesystem::path& cache) {
  if (!fake.contains("times")) return true;
  std::error_code none_yet;
  const std::filesystem::path counter = cache / "times";
  const std::uintmax_t times = std::filesystem::file_size(counter, none_yet);
  if (!none_yet && times >= fake["times"].get<std::uintmax_t>()) return false;
  std::ofstream(counter, std::ios::app) << 'x';
  return true;
}

void misbehave(const std::string& how) {
  if (how == "segv") ::raise(SIGSEGV);
  if (how == "ill") ::raise(SIGILL);
  if (how == "kill") ::raise(SIGKILL);
  if (how == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  if (how == "chatter") {
    while (true) say({{"type", "progress"}, {"stage", "replay"}, {"done", 1}, {"total", 2}, {"detail", "on and on"}});
  }
  if (how == "exit") {
    std::cerr << "first words\nthe driver lost the device\n";
    ::_exit(4);
  }
  if (how == "error") {
    say({{"type", "error"}, {"message", "can't replay: the device lacks int64: feature shaderInt64"}, {"exit", 4}});
    ::_exit(4);
  }
  if (how == "internal") {
    say({{"type", "error"}, {"message", "internal error: no such shader: please report it"}, {"exit", 70}});
    ::_exit(70);
  }
  if (how == "garbage") std::cout << "\x01\xff not json at all" << std::endl;
  if (how == "long_line") std::cout << std::string(std::size_t{64} << 20, 'x') << std::endl;
  if (how == "quit") ::_exit(0);
  if (how == "memory") {
    // Untouched pages cost nothing but count as address space.
    if (::mmap(nullptr, std::size_t{64} << 30, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0) ==
        MAP_FAILED) {
      std::cerr << "out of memory\n";
      ::abort();
    }
  }
}

// What a replay of times reports: results without images, `rounds` times.
int time_rounds(const replay::ReplayJob& job, const json& fake, std::uint32_t width, std::uint32_t height) {
  const auto [first, last] = job.options.frames.value_or(std::pair{0u, fake.value("frames", 2u) - 1});
  for (std::uint32_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t round = 0; round < job.options.rounds; ++round) {
      for (std::uint32_t index = 0; index < job.options.techniques.size(); ++index) {
        const json tweak = tweak_of(fake, job.options.techniques[index].technique);
        json result = replay::to_json(make_result(job, frame, index, width, height, tweak));
        result["images"] = json::object();
        say({{"type", "result"}, {"ordinal", index}, {"result", result}});
      }
    }
  }
  say({{"type", "done"}});
  return 0;
}

int work(const std::string& job_path) {
  std::ifstream file(job_path);
  const replay::ReplayJob job = replay::replay_job_from_json(json::parse(file));
  const json fake = read_fake_capture(job.capture.string());
  const bool thumbnail = job.options.reference_samples == 0 && job.options.width == 320;
  const auto [first, last] = job.options.frames.value_or(std::pair{0u, fake.value("frames", 2u) - 1});
  const int fail_at = thumbnail ? -1 : fake.value("fail_at", -1);
  const std::string how = fake.value("how", "");
  const std::uint32_t width = job.options.width != 0 ? job.options.width : fake.value("width", 64u);
  const std::uint32_t height = job.options.height != 0 ? job.options.height : fake.value("height", 36u);

  say({{"type", "progress"}, {"stage", "device"}, {"done", 0}, {"total", 1}, {"detail", "no device at all, 1.0"}});
  say({{"type", "progress"}, {"stage", "load"}, {"done", 0}, {"total", 1}, {"detail", "<b>capture</b>"}});
  say({{"type", "head"},
       {"head", replay::to_json(make_head(job, fake.value("title", "A fake capture"), width, height))}});
  const auto techniques = static_cast<std::uint32_t>(job.options.techniques.size());
  const std::uint32_t total = (last - first + 1) * techniques;
  if (job.options.rounds > 0) return time_rounds(job, fake, width, height);
  std::uint32_t done = 0;
  if (job.options.references_only) {
    const auto all = static_cast<std::size_t>(total) - job.options.skip.size();
    if (fake.contains("log"))
      std::ofstream(fake["log"].get<std::string>(), std::ios::app) << "references " << all << "\n";
    say({{"type", "done"}});
    return 0;
  }
  for (std::uint32_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t index = 0; index < techniques; ++index, ++done) {
      const std::pair<std::uint32_t, std::uint32_t> pair{frame, index};
      if (std::ranges::find(job.options.skip, pair) != job.options.skip.end()) continue;
      if (fail_at == static_cast<int>(done) && how == "reach") {
        say({{"type", "error"}, {"message", reached(fake)}, {"exit", 3}});
        return 3;
      }
      say({{"type", "progress"},
           {"stage", "replay"},
           {"done", done},
           {"total", total},
           {"detail", "frame " + std::to_string(frame) + " " + job.options.techniques[index].technique}});
      if (fail_at == static_cast<int>(done) && is_due(fake, job.cache_dir)) misbehave(how);
      std::this_thread::sleep_for(std::chrono::milliseconds(thumbnail ? 0 : fake.value("result_ms", 0)));
      const json tweak = tweak_of(fake, job.options.techniques[index].technique);
      json result = replay::to_json(make_result(job, frame, index, width, height, tweak));
      if (fail_at == static_cast<int>(done) && how == "escape") result["images"]["image"] = "../job.json";
      if (fail_at == static_cast<int>(done) && how == "foreign") result["frame"] = 4000;
      if (fake.contains("log") && !thumbnail) {
        std::ofstream(fake["log"].get<std::string>(), std::ios::app) << frame << "/" << index << "\n";
      }
      say({{"type", "result"}, {"ordinal", index}, {"result", result}});
    }
  }
  if (how == "no_done") return 0;
  say({{"type", "head"},
       {"head", replay::to_json(make_head(job, fake.value("title", "A fake capture"), width, height))}});
  say({{"type", "done"}});
  return 0;
}

}  // namespace
}  // namespace subpixel::tests

int main(int argc, char** argv) {
  using namespace subpixel::tests;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 3 && arguments[0] == "info" && arguments[2] == "--json") return info(arguments[1]);
  if (arguments.size() > 3 && arguments[0] == "info" && arguments[2] == "--json") return view(arguments);
  if (arguments.size() == 3 && arguments[0] == "worker" && arguments[1] == "--job") return work(arguments[2]);
  if (arguments.size() == 3 && arguments[0] == "probe") return probe(arguments[1], arguments[2]);
  if (arguments.size() > 3 && arguments[0] == "pixel" && arguments[2] == "--json") return tell(arguments);
  if (arguments.size() == 4 && arguments[0] == "diff" && arguments[3] == "--json") return differ(arguments);
  std::cerr << "usage: info FILE --json [OPTIONS] | worker --job FILE | pixel FILE --json OPTIONS | probe WHAT PATH\n";
  return 2;
}
