// Measures all techniques on all scenes and writes docs/results.md with its plots.
//   subpixel_bench_report                everything, more than an hour on two quiet cores; goes on where it was
//   interrupted subpixel_bench_report --only-counts  what may run on a busy machine; then --only-times on a quiet one
//   subpixel_bench_report --quick        two scenes at 320x180, minutes; writes build/report/quick/results.md
//   subpixel_bench_report --only-write   the page from what is stored
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <tuple>
#include <vector>

#include "base/error.hpp"
#include "base/failure.hpp"
#include "bench/report/document.hpp"
#include "bench/report/store.hpp"
#include "replay/results/limits.hpp"

namespace subpixel::report {
namespace {

struct Arguments {
  PlanOptions plan;
  std::string size;
  std::filesystem::path folder, out;
  std::vector<RunKind> kinds;  // only these are measured; empty: all
  bool only_write = false, fresh = false, only_counts = false, only_times = false;
};

// What was typed, without the folders, which say nothing about the numbers.
std::string command_of(const Arguments& arguments) {
  std::string command = "build/release/bench/subpixel_bench_report";
  if (arguments.plan.quick) command += " --quick";
  if (!arguments.plan.scenes.empty()) command += fmt::format(" --scenes {}", fmt::join(arguments.plan.scenes, ","));
  if (!arguments.size.empty()) command += " --size " + arguments.size;
  if (!arguments.plan.techniques.empty()) command += fmt::format(" --techniques \"{}\"", arguments.plan.techniques);
  return command;
}

void run(Arguments arguments) {
  PlanOptions& wanted = arguments.plan;
  if (!arguments.size.empty()) std::tie(wanted.width, wanted.height) = replay::parse_size(arguments.size, "--size");
  const std::filesystem::path root = SUBPIXEL_SOURCE_DIR;
  const std::filesystem::path quick = arguments.plan.quick ? "quick" : "";
  if (arguments.folder.empty()) arguments.folder = root / "build/report" / quick;
  if (arguments.out.empty())
    arguments.out = arguments.plan.quick ? arguments.folder / "results.md" : root / "docs/results.md";
  const std::vector<RunPlan> plan = make_plan(arguments.plan);
  if (!arguments.only_write) {
    MeasureOptions options{arguments.folder, root, arguments.fresh, std::nullopt,
                           [](const std::string& line) { fmt::print(stderr, "{}\n", line); }};
    if (arguments.only_counts || arguments.only_times) options.timed = arguments.only_times;
    std::vector<RunPlan> chosen;
    std::ranges::copy_if(plan, std::back_inserter(chosen), [&](const RunPlan& of) {
      return arguments.kinds.empty() || std::ranges::find(arguments.kinds, of.kind) != arguments.kinds.end();
    });
    measure(chosen, options);
  }
  const Measured measured = read_measured(plan, arguments.folder);
  if (measured.runs.empty()) throw InputError("report", "nothing is stored", arguments.folder.string());
  std::vector<std::string> missing;
  for (const RunPlan& of : plan)
    if (std::ranges::find(measured.runs, of.name(), [](const Run& run) { return run.plan.name(); }) ==
        measured.runs.end())
      missing.push_back(of.name());
  write_document(make_document(measured, all_claims(), command_of(arguments), missing), arguments.out);
  publish(plan, arguments.folder, arguments.out.parent_path() / kMeasuredFolder);
  fmt::print("{} of {} runs: {}\n", measured.runs.size(), plan.size(), arguments.out.string());
}

}  // namespace
}  // namespace subpixel::report

int main(int argc, char** argv) {
  using namespace subpixel;
  report::Arguments arguments;
  CLI::App app("Measures all techniques on all scenes and writes docs/results.md");
  app.add_flag("--quick", arguments.plan.quick, "Two scenes at 320x180; the page goes beside the results");
  app.add_flag("--only-write", arguments.only_write, "Write the page from stored results without a replay");
  CLI::Option* const counts = app.add_flag("--only-counts", arguments.only_counts,
                                           "Only the runs whose times nobody reads: the machine may be busy");
  app.add_flag("--only-times", arguments.only_times, "Only the others")->excludes(counts);
  const std::map<std::string, report::RunKind> kinds{{"sweep", report::RunKind::sweep},
                                                     {"paper", report::RunKind::paper},
                                                     {"lights", report::RunKind::lights},
                                                     {"frames", report::RunKind::frames}};
  app.add_option("--kinds", arguments.kinds, "Only these runs are measured: sweep,paper,lights,frames")
      ->delimiter(',')
      ->transform(CLI::CheckedTransformer(kinds));
  app.add_flag("--fresh", arguments.fresh, "Measure stored runs again");
  app.add_option("--scenes", arguments.plan.scenes, "Only these: a,b")->delimiter(',');
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT of the sweeps");
  app.add_option("--techniques", arguments.plan.techniques, "These sweeps and no others, as of `subpixel replay`");
  app.add_option("--folder", arguments.folder, "Where results are stored; default build/report");
  app.add_option("--out", arguments.out, "The page; default docs/results.md");
  CLI11_PARSE(app, argc, argv);
  try {
    report::run(arguments);
  } catch (...) {
    const Failure end = failure_of(std::current_exception());
    fmt::print(stderr, "subpixel_bench_report: {}\n", end.message);
    return end.exit_code;
  }
  return 0;
}
