#include "cli/nightly_verbs.hpp"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "cli/engine_options.hpp"
#include "cli/nightly_trend_verbs.hpp"
#include "server/nightly/config.hpp"
#include "server/nightly/night_store.hpp"
#include "server/nightly/run_night.hpp"
#include "server/nightly/summaries.hpp"
#include "server/notices.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"
#include "server/watch_folder.hpp"

namespace subpixel::cli {
namespace {

using server::DataFolder;
using server::NightRecord;

constexpr const char* kDefaultData = "subpixel-data";

struct NightlyArguments {
  std::string config, data, baseline, junit, markdown, json_file, worker, commit, comment, address, sarif;
  std::uint32_t silence_s = 600;
  std::shared_ptr<EngineFlags> engine;
};

void write_text(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text;
  } else if (!path.empty()) {
    write_file_atomically(path, std::string_view(text));
  }
}

std::filesystem::path worker_program(const std::string& given) {
  return given.empty() ? std::filesystem::read_symlink("/proc/self/exe") : std::filesystem::absolute(given);
}

// What watched folders have, and what tags may hold.
void take_watched(const server::NightlyConfig& config, const DataFolder& folder, server::Store& store,
                  const server::NightOptions& options) {
  const server::WorkerOptions worker{options.worker, 1, options.limits, {}};
  const auto say = [](const std::vector<std::string>& lines) {
    for (const std::string& line : lines) fmt::print(stderr, "{}\n", printable(line));
  };
  for (const server::WatchedFolder& watched : config.watched) say(take_captures(watched, folder, store, worker));
  for (const server::TagLimit& limit : config.tag_limits) say(keep_tag_limits(limit, folder, store));
}

void tell(const server::NightlyConfig& config, server::Notice notice) {
  if (notice.night.name.empty()) notice.night.name = config.name;
  for (const server::Delivery& delivery : send_notices(config.notices, notice))
    fmt::print(stderr, "{}\n", printable(delivery.text));
}

int nightly(const NightlyArguments& arguments) {
  if (arguments.config.empty()) throw UsageError("nightly", "--config FILE is missing", "");
  server::NightlyConfig config = server::read_nightly_config(arguments.config);
  if (!arguments.baseline.empty()) config.baseline = arguments.baseline;
  const std::filesystem::path data =
      arguments.data.empty() ? config.data.value_or(kDefaultData) : std::filesystem::path(arguments.data);
  const DataFolder folder(data, DataFolder::Claim::night);
  server::Store store(folder.store());
  server::NightOptions options;
  options.worker = worker_program(arguments.worker);
  options.commit = arguments.commit;
  if (options.commit.size() > 100 || printable(options.commit, 100) != options.commit)
    throw UsageError("--commit", "expected at most 100 printable bytes", printable(options.commit, 100));
  options.limits.silence = std::chrono::seconds(arguments.silence_s);
  options.progress = [](const std::string& line) { fmt::print(stderr, "{}\n", printable(line)); };
  const std::unique_ptr<server::ReplayEngine> engine =
      make_engine(*arguments.engine, {options.worker, options.limits}, folder.root(), folder.cache());
  options.engine = engine.get();
  take_watched(config, folder, store, options);
  NightRecord night;
  try {
    night = server::run_night(config, folder, store, options);
  } catch (...) {
    const std::string why = failure_of(std::current_exception()).message;
    tell(config,
         {"night.broken", fmt::format("the night {} broke off: {}", config.name, why), why, {}, arguments.address});
    throw;
  }

  write_text(arguments.junit, to_junit(night));
  write_text(arguments.markdown, to_markdown(night));
  write_text(arguments.sarif, json_text(to_sarif(night, arguments.config), 1) + "\n");
  write_text(arguments.comment, to_comment(night, arguments.address));
  write_text(arguments.json_file, json_text(to_json(night), 1) + "\n");
  // One document on standard output: the one asked for with "-", else the summary for people.
  const bool taken = arguments.junit == "-" || arguments.comment == "-" || arguments.sarif == "-" ||
                     arguments.markdown == "-" || arguments.json_file == "-";
  if (!taken) std::cout << to_markdown(night);
  fmt::print(stderr, "{}\n", printable(headline(night)));
  tell(config, {"night.ended", headline(night), to_comment(night, arguments.address), night, arguments.address});
  return night.status == server::NightStatus::passed ? 0 : 1;
}

struct BaselineArguments {
  std::string data = kDefaultData, name, why;
  std::optional<std::int64_t> night;
  bool as_json = false;
};

int baseline_set(const BaselineArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  server::NightStore nights(store);
  std::optional<std::int64_t> id = arguments.night;
  if (!id) {
    for (const NightRecord& night : nights.nights(100, 0, "")) {
      if (night.finished_utc.empty() || night.status == server::NightStatus::interrupted) continue;
      id = night.id;
      break;
    }
  }
  if (!id) throw InputError("baseline", "there is no finished night", folder.store().string());
  const passwd* const user = ::getpwuid(::getuid());
  if (!nights.set_baseline(arguments.name, *id, user != nullptr ? user->pw_name : "", arguments.why)) {
    throw InputError("baseline", "there is no finished night of this number", std::to_string(*id));
  }
  fmt::print("{} is night {}\n", printable(arguments.name), *id);
  return 0;
}

int baseline_list(const BaselineArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  const server::NightStore nights(store);
  nlohmann::json list = nlohmann::json::array();
  for (const server::BaselineRecord& baseline : nights.baselines()) {
    list.push_back({{"name", baseline.name},
                    {"night", baseline.night},
                    {"set_utc", baseline.set_utc},
                    {"who", baseline.who},
                    {"why", baseline.why}});
    if (!arguments.as_json) {
      fmt::print("{:<16} night {:<6} set {}{}{}\n", printable(baseline.name), baseline.night, baseline.set_utc,
                 baseline.who.empty() ? "" : " by " + printable(baseline.who),
                 baseline.why.empty() ? "" : ": " + printable(baseline.why));
    }
  }
  if (arguments.as_json) fmt::print("{}\n", json_text(list, 1));
  return 0;
}

int baseline_show(const BaselineArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  const server::NightStore nights(store);
  for (const server::BaselineRecord& baseline : nights.baselines()) {
    if (baseline.name != arguments.name) continue;
    const NightRecord night = nights.night(baseline.night, false).value();
    std::cout << (arguments.as_json ? json_text(to_json(night), 1) + "\n" : to_markdown(night));
    return 0;
  }
  throw InputError("baseline", "nothing is approved under this name", arguments.name);
}

void add_nightly(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<NightlyArguments>();
  CLI::App* const verb = app.add_subcommand(
      "nightly", "Replay captures, compare the results with a baseline; exit code 1 when a gate failed");
  verb->add_option("--config", arguments->config, "What to replay and how to judge it, JSON (docs/nightly.md)");
  verb->add_option("--data", arguments->data,
                   "Data folder, also of a running service; default: the configuration's, else subpixel-data");
  verb->add_option("--baseline", arguments->baseline, "Baseline to compare with; default: the configuration's");
  verb->add_option("--junit", arguments->junit, "Write JUnit XML to this file; - prints it");
  verb->add_option("--markdown", arguments->markdown, "Write Markdown to this file; - prints it, as without options");
  verb->add_option("--sarif", arguments->sarif, "Write what failed as SARIF to this file; - prints it");
  verb->add_option("--comment", arguments->comment,
                   "Write what failed and what two captures differ in as Markdown, for a pull request; - prints it");
  verb->add_option("--address", arguments->address,
                   "Of the service that shows the nights, for links: https://subpixel.example");
  verb->add_option("--json", arguments->json_file, "Write JSON to this file; - prints it");
  verb->add_option("--commit", arguments->commit,
                   "What is measured, kept with the night; default: the commit that this program was built from");
  verb->add_option("--worker-silence", arguments->silence_s, "Seconds without a word after which a worker is ended")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  verb->add_option("--worker-program", arguments->worker,
                   "Program run as `PROGRAM worker --job FILE`; default: this one")
      ->check(CLI::ExistingFile);
  arguments->engine = add_engine_options(*verb);
  add_trend_verbs(*verb, action);
  verb->callback([arguments, verb, &action] {
    if (verb->get_subcommands().empty()) action = [arguments] { return nightly(*arguments); };
  });
}

void add_baseline(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<BaselineArguments>();
  CLI::App* const verb = app.add_subcommand("baseline", "Approve a night, or look at what is approved");
  verb->require_subcommand(1);
  const auto add = [&](const char* name, const char* description, bool named, int (*run)(const BaselineArguments&)) {
    CLI::App* const part = verb->add_subcommand(name, description);
    if (named) part->add_option("name", arguments->name, "Name of the baseline")->required();
    part->add_option("--data", arguments->data, "Data folder")->capture_default_str();
    part->callback([arguments, run, &action] { action = [arguments, run] { return run(*arguments); }; });
    return part;
  };
  CLI::App* const set = add("set", "Approve a night: later ones are compared with it", true, &baseline_set);
  set->add_option("--night", arguments->night, "Number of the night; default: the newest finished one");
  set->add_option("--why", arguments->why, "Why it may be the baseline, kept with who and when");
  add("list", "List the baselines", false, &baseline_list)
      ->add_flag("--json", arguments->as_json, "Print one JSON document");
  add("show", "Show the night that a baseline names", true, &baseline_show)
      ->add_flag("--json", arguments->as_json, "Print one JSON document");
}

}  // namespace

void add_nightly_verbs(CLI::App& app, std::function<int()>& action) {
  add_nightly(app, action);
  add_baseline(app, action);
}

}  // namespace subpixel::cli
