#include "cli/nightly_trend_verbs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "server/nightly/bisect.hpp"
#include "server/nightly/trends.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::cli {
namespace {

using server::CellTrend;
using server::ChangePoint;
using server::DataFolder;

struct TrendArguments {
  std::string data = "subpixel-data", name, capture, technique, number, csv, worker;
  std::uint32_t limit = 200;
  bool as_json = false;
  // Of bisect.
  std::string repository = ".", command, good, bad, folder;
};

// Why there is no trend: a cell that was asked for is named as nights name it, or not at all.
std::string nothing_measured(const server::NightStore& nights, const TrendArguments& arguments) {
  std::string techniques;
  for (const auto& [capture, technique] : trend_cells(nights, arguments.name))
    if (capture == arguments.capture) techniques += (techniques.empty() ? "" : ", ") + printable(technique);
  if (techniques.empty()) return "no finished night of this name measured it";
  return fmt::format("no finished night measured {} by {}; it was measured by {}", printable(arguments.capture),
                     printable(arguments.technique), techniques);
}

std::vector<CellTrend> trends_of(const server::NightStore& nights, const TrendArguments& arguments) {
  if (arguments.capture.empty() != arguments.technique.empty())
    throw UsageError("trend", "a cell has a capture and a technique",
                     arguments.capture.empty() ? "--capture" : "--technique");
  std::vector<std::pair<std::string, std::string>> cells{{arguments.capture, arguments.technique}};
  if (arguments.capture.empty()) cells = trend_cells(nights, arguments.name);
  std::vector<CellTrend> trends;
  for (const auto& [capture, technique] : cells) {
    CellTrend trend = cell_trend(nights, arguments.name, capture, technique, arguments.limit);
    if (!arguments.number.empty()) {
      for (server::TrendNight& night : trend.nights) {
        std::erase_if(night.values, [&](const auto& value) { return value.first != arguments.number; });
        std::erase_if(night.bands, [&](const auto& band) { return band.first != arguments.number; });
      }
    }
    if (!trend.nights.empty()) trends.push_back(std::move(trend));
  }
  if (trends.empty()) throw InputError("trend", nothing_measured(nights, arguments), printable(arguments.name));
  return trends;
}

int trend(const TrendArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  const server::NightStore nights(store);
  const std::vector<CellTrend> trends = trends_of(nights, arguments);
  if (!arguments.csv.empty()) {
    std::string text;
    for (const CellTrend& one : trends) text += to_csv(one, text.empty());
    if (arguments.csv == "-") {
      std::cout << text;
    } else {
      write_file_atomically(arguments.csv, std::string_view(text));
    }
    return 0;
  }
  if (arguments.as_json) {
    nlohmann::json list = nlohmann::json::array();
    for (const CellTrend& one : trends) list.push_back(to_json(one));
    fmt::print("{}\n", json_text({{"trends", list}}, 1));
    return 0;
  }
  std::size_t count = 0;
  for (const CellTrend& one : trends) {
    for (const ChangePoint& change : change_points(one)) {
      fmt::print("{}\n", printable(change_text(one, change)));
      ++count;
    }
  }
  fmt::print("{} cells, {} changes\n", trends.size(), count);
  return 0;
}

// The change that is asked about: the newest of the number, or of the cell's first number that has one.
ChangePoint change_of(const CellTrend& trend) {
  const std::vector<ChangePoint> changes = change_points(trend);
  if (changes.empty())
    throw InputError("bisect", "no number of the cell moved between its nights",
                     printable(trend.capture + " " + trend.technique));
  return *std::ranges::max_element(changes, {}, [](const ChangePoint& change) { return change.after; });
}

int bisect(const TrendArguments& arguments) {
  if (arguments.capture.empty() || arguments.technique.empty())
    throw UsageError("bisect", "a cell is missing", "--capture, --technique");
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  const server::NightStore nights(store);
  const CellTrend trend = trends_of(nights, arguments).front();
  const ChangePoint change = change_of(trend);
  const server::TrendNight &before = trend.nights[change.after - 1], &after = trend.nights[change.after];
  nlohmann::json document = {{"number", change.number}, {"from", change.from},
                             {"to", change.to},         {"before", before.id},
                             {"after", after.id},       {"good", before.commit},
                             {"bad", after.commit},     {"first_bad", nullptr},
                             {"subject", ""},           {"steps", nlohmann::json::array()}};
  if (!arguments.as_json) fmt::print("{}\n", printable(change_text(trend, change)));
  if (!arguments.command.empty()) {
    server::BisectRequest request;
    request.night = nights.nights_of_cell(arguments.name, arguments.capture, arguments.technique, arguments.limit)
                        .at(trend.nights.size() - 1 - change.after);
    request.capture = arguments.capture;
    request.technique = arguments.technique;
    request.number = change.number;
    request.from = change.from;
    request.to = change.to;
    request.good = arguments.good.empty() ? before.commit : arguments.good;
    request.bad = arguments.bad.empty() ? after.commit : arguments.bad;
    request.repository = arguments.repository;
    request.data = arguments.data;
    request.command = arguments.command;
    server::NightOptions options;
    options.worker = arguments.worker.empty() ? std::filesystem::read_symlink("/proc/self/exe")
                                              : std::filesystem::absolute(arguments.worker);
    options.progress = [](const std::string& line) { fmt::print(stderr, "{}\n", printable(line)); };
    if (std::filesystem::exists(arguments.folder) && !std::filesystem::is_empty(arguments.folder))
      throw InputError("bisect", "the folder is not empty", arguments.folder);
    const server::BisectResult result = server::bisect(request, arguments.folder, options);
    for (const server::BisectStep& step : result.steps) {
      document["steps"].push_back({{"commit", step.commit},
                                   {"value", step.value ? nlohmann::json(*step.value) : nlohmann::json(nullptr)},
                                   {"verdict", step.verdict}});
    }
    if (!result.first_bad.empty()) document["first_bad"] = result.first_bad;
    document["subject"] = result.subject;
    if (!arguments.as_json) {
      fmt::print("{}\n", result.first_bad.empty()
                             ? "commits that could not be replayed hide which one it was"
                             : printable(fmt::format("{} {}, {} commits replayed", result.first_bad, result.subject,
                                                     result.steps.size())));
    }
  }
  if (arguments.as_json) fmt::print("{}\n", json_text(document, 1));
  return arguments.command.empty() || !document["first_bad"].is_null() ? 0 : 1;
}

CLI::App* add_verb(CLI::App& nightly, const char* name, const char* meaning,
                   const std::shared_ptr<TrendArguments>& arguments) {
  CLI::App* const verb = nightly.add_subcommand(name, meaning);
  verb->add_option("--data", arguments->data, "Data folder")->capture_default_str();
  verb->add_option("--name", arguments->name, "Name of the nights")->required();
  verb->add_option("--capture", arguments->capture, "Name of the capture");
  verb->add_option("--technique", arguments->technique, "The technique, as nights name it: streaming:surfaces=3");
  verb->add_option("--number", arguments->number, "Only this one: error.mse, executions, time.msaa:samples=8, ...");
  verb->add_option("--limit", arguments->limit, "Newest nights that are looked at")
      ->check(CLI::Range(2, 100'000))
      ->capture_default_str();
  verb->add_flag("--json", arguments->as_json, "Print one JSON document");
  return verb;
}

}  // namespace

void add_trend_verbs(CLI::App& nightly, std::function<int()>& action) {
  const auto of_trend = std::make_shared<TrendArguments>();
  CLI::App* const trend_verb =
      add_verb(nightly, "trend", "Say where numbers moved over stored nights, or write them all as CSV", of_trend);
  trend_verb->add_option("--csv", of_trend->csv, "Write every number of every night to this file; - prints it");
  trend_verb->callback([of_trend, &action] { action = [of_trend] { return trend(*of_trend); }; });

  const auto of_bisect = std::make_shared<TrendArguments>();
  CLI::App* const bisect_verb = add_verb(
      nightly, "bisect", "Say between which nights a cell's number moved last, and find the commit", of_bisect);
  bisect_verb->add_option(
      "--run", of_bisect->command,
      "Shell command that makes the build of {commit} in a check-out of it; its last line names the "
      "program or a shader folder");
  bisect_verb->add_option("--repository", of_bisect->repository, "Git repository of the commits")
      ->capture_default_str();
  bisect_verb->add_option("--good", of_bisect->good, "Commit before the change; default: the night's");
  bisect_verb->add_option("--bad", of_bisect->bad, "Commit after the change; default: the night's");
  bisect_verb->add_option("--folder", of_bisect->folder, "Folder for check-outs and replays, which is made")
      ->default_val("subpixel-bisect")
      ->capture_default_str();
  bisect_verb->add_option("--worker-program", of_bisect->worker, "Program that replays; default: this one")
      ->check(CLI::ExistingFile);
  bisect_verb->callback([of_bisect, &action] { action = [of_bisect] { return bisect(*of_bisect); }; });
}

}  // namespace subpixel::cli
