#include "server/nightly/bisect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "server/nightly/config.hpp"

namespace subpixel::server {
namespace {

constexpr std::string_view kPlace = "{commit}";
constexpr auto kBuildTime = std::chrono::hours(4);
constexpr std::size_t kMaxSteps = 64;  // of 2^64 commits

struct Output {
  bool succeeded = false;
  std::string last_line, all, reason;
};

Output run(const std::vector<std::string>& arguments) {
  Output output;
  ChildLimits limits;
  limits.silence = limits.duration = kBuildTime;
  const ChildOutcome outcome = run_child(arguments, limits, {}, [&](std::string_view line) {
    if (!line.empty()) output.last_line = line;
    output.all += std::string(line) + "\n";
    return output.all.size() < (std::size_t{64} << 20);
  });
  output.succeeded = outcome.kind == ChildOutcome::Kind::exited && outcome.code == 0;
  output.reason = outcome.reason.empty() ? "" : printable(outcome.reason + ": " + outcome.error_tail, 600);
  return output;
}

class Repository {
 public:
  explicit Repository(std::filesystem::path folder) : folder_(std::move(folder)) {}
  const std::filesystem::path& folder() const { return folder_; }

  Output git(const std::vector<std::string>& words) const {
    std::vector<std::string> arguments{"/usr/bin/env", "git",           "-c", "advice.detachedHead=false",
                                       "-C",           folder_.string()};
    arguments.insert(arguments.end(), words.begin(), words.end());
    return run(arguments);
  }
  std::string must(const std::vector<std::string>& words) const {
    const Output output = git(words);
    if (!output.succeeded) throw InputError("git " + words.front(), output.reason, folder_.string());
    return output.last_line;
  }
  // 40 digits; what they name is a commit.
  std::string commit(std::string name) const {
    if (const std::size_t changed = name.find("-changed"); changed != std::string::npos) name.resize(changed);
    const Output output = git({"rev-parse", "--verify", "--quiet", "--end-of-options", name + "^{commit}"});
    if (!output.succeeded) throw InputError("bisect", "the repository has no such commit", printable(name, 100));
    return output.last_line;
  }

 private:
  std::filesystem::path folder_;
};

// The night's configuration with nothing in it but the cell and, for times, what it is compared with.
NightlyConfig config_of_cell(const BisectRequest& request) {
  NightlyConfig config = parse_nightly_config(request.night.config.dump(), request.night.facts.value("folder", ""));
  const NightCapture& capture = request.night.captures.front();
  const bool is_time = request.number.starts_with("time.");
  std::vector<CaptureSource> kept;
  for (CaptureSource& source : config.captures) {
    if (source.kind == SourceKind::tag ? capture.source != "tag " + source.tag : source.name != capture.name) continue;
    if (source.kind == SourceKind::tag) {
      source.kind = SourceKind::path;
      source.name = capture.name;
      source.path = request.data / "captures" / (capture.hash + ".spcap");
    }
    std::erase_if(source.options.techniques, [&](const replay::TechniqueRequest& technique) {
      const bool reference = is_time && (technique.technique == "msaa" || technique.technique == "noaa");
      return !reference && technique_key(technique.technique, technique.parameters) != request.technique;
    });
    kept.push_back(std::move(source));
    break;
  }
  if (kept.empty() || kept.front().options.techniques.empty())
    throw InputError("bisect", "the night's configuration does not have the cell any more", capture.name);
  config.captures = std::move(kept);
  config.gates.time = is_time;
  config.baseline = "bisect";
  config.keep = 0;
  return config;
}

class Bisection {
 public:
  Bisection(const BisectRequest& request, const std::filesystem::path& folder, const NightOptions& options)
      : request_(request),
        options_(options),
        config_(config_of_cell(request)),
        clone_(folder / "clone"),
        data_(folder / "data", DataFolder::Claim::night),
        store_(data_.store()) {}

  BisectResult run_all();

 private:
  std::optional<double> measure(const std::string& commit, std::string& why);

  const BisectRequest& request_;
  const NightOptions& options_;
  const NightlyConfig config_;
  Repository clone_;
  DataFolder data_;
  Store store_;
};

std::optional<double> Bisection::measure(const std::string& commit, std::string& why) {
  std::string command = request_.command;
  for (std::size_t at = 0; (at = command.find(kPlace, at)) != std::string::npos; at += commit.size())
    command.replace(at, kPlace.size(), commit);
  const Output built = run({"/bin/sh", "-c", "cd -- \"$0\" && " + command, clone_.folder().string()});
  if (!built.succeeded) {
    why = "the command failed: " + built.reason;
    return std::nullopt;
  }
  std::filesystem::path made = clone_.folder() / built.last_line;
  NightOptions options = options_;
  options.commit = commit;
  // NOLINTBEGIN(concurrency-mt-unsafe): nothing else runs in this process
  if (std::filesystem::is_directory(made)) {
    ::setenv("SUBPIXEL_SHADERS", std::filesystem::canonical(made).c_str(), 1);
  } else if (std::filesystem::is_regular_file(made)) {
    ::unsetenv("SUBPIXEL_SHADERS");
    options.worker = std::filesystem::canonical(made);
  } else {
    why = "the command's last line names neither a program nor a folder: " + printable(built.last_line, 200);
    return std::nullopt;
  }
  // NOLINTEND(concurrency-mt-unsafe)
  const NightRecord night = run_night(config_, data_, store_, options);
  for (const NightCell& cell : night.cells) {
    if (cell.technique != request_.technique) continue;
    const std::map<std::string, double> numbers = cell_numbers(cell);
    if (const auto found = numbers.find(request_.number); found != numbers.end()) return found->second;
  }
  why = night.captures.front().problem.empty() ? "the number was not measured" : night.captures.front().problem;
  return std::nullopt;
}

BisectResult Bisection::run_all() {
  const Repository original(request_.repository);
  const std::string good = original.commit(request_.good), bad = original.commit(request_.bad);
  std::filesystem::create_directories(clone_.folder().parent_path());
  const Output cloned = run({"/usr/bin/env", "git", "clone", "--quiet", "--shared", "--no-checkout",
                             std::filesystem::absolute(request_.repository).string(), clone_.folder().string()});
  if (!cloned.succeeded) throw InputError("git clone", cloned.reason, request_.repository.string());
  clone_.must({"checkout", "--quiet", "--detach", bad});
  BisectResult result;
  std::string said = clone_.git({"bisect", "start", bad, good}).all;
  while (result.steps.size() < kMaxSteps) {
    if (said.find("is the first bad commit") != std::string::npos) {
      result.first_bad = clone_.must({"rev-parse", "refs/bisect/bad"});
      result.subject = clone_.must({"log", "-1", "--format=%s", result.first_bad});
      break;
    }
    if (said.find("We cannot bisect more") != std::string::npos) break;
    BisectStep step{clone_.must({"rev-parse", "HEAD"}), std::nullopt, ""};
    std::string why;
    step.value = measure(step.commit, why);
    step.verdict = "skip";
    if (step.value) {
      step.verdict = std::abs(*step.value - request_.from) <= std::abs(*step.value - request_.to) ? "good" : "bad";
    }
    const std::string number = step.value ? fmt::format("{:.6g}", *step.value) : why;
    if (options_.progress)
      options_.progress(fmt::format("{}: {}, {}", step.commit.substr(0, 12), step.verdict, number));
    // The command may have changed files that are under version control.
    clone_.git({"checkout", "--quiet", "--force", "HEAD"});
    said = clone_.git({"bisect", step.verdict}).all;
    if (!step.value) step.verdict = "skip: " + why;
    result.steps.push_back(std::move(step));
  }
  return result;
}

}  // namespace

BisectResult bisect(const BisectRequest& request, const std::filesystem::path& folder, const NightOptions& options) {
  if (request.command.find(kPlace) == std::string::npos)
    throw UsageError("--run", "the command does not have {commit} in it", printable(request.command, 200));
  return Bisection(request, folder, options).run_all();
}

}  // namespace subpixel::server
