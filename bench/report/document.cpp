#include "bench/report/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "base/atomic_file.hpp"
#include "bench/report/winners.hpp"
#include "replay/results/plots.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;
using replay::Summary;

constexpr const char* kImageFolder = "images/results";

std::string joined(const std::set<std::string>& words) {
  return fmt::format("{}", fmt::join(words, "; "));
}

std::string head(const Measured& measured, const std::string& command, const std::vector<std::string>& missing) {
  std::set<std::string> drivers, processors;
  std::string first, last;
  double minutes = 0;
  for (const Run& run : measured.runs) {
    const replay::ResultsHead& of = run.results.head;
    drivers.insert(fmt::format("{}, {}", of.driver_version, of.device));
    processors.insert(of.cpu_model);
    if (first.empty() || of.date_utc < first) first = of.date_utc;
    last = std::max(last, of.date_utc);
    minutes += of.wall_s / 60;
  }
  std::string text = fmt::format(
      "# Results\n\n"
      "Written by `bench/report` from what it measured; nothing on this page is typed in but the publications' own "
      "numbers and the\n"
      "reasons, and a reason shows only where the numbers do not come out. One command makes all of it again:\n\n"
      "```\nninja -C build/release subpixel_bench_report\n{}\n```\n\n"
      "It stores every run when it is done (`build/report/`) and goes on after an interruption where it was; `--fresh` "
      "starts over,\n"
      "`--only-write` writes the page from what is stored, `--quick` is a small form of minutes. The runs that this "
      "page was written from are\n"
      "[beside it]({}/), as `subpixel replay --json` writes them: `--only-write --folder docs/{}` makes the page from "
      "those.\n\n"
      "Driver: {}. Processor: {}. Measured {} to {}, {:.0f} minutes of replay.\n\n",
      command, kMeasuredFolder, kMeasuredFolder, joined(drivers), joined(processors), first, last, minutes);
  if (!missing.empty())
    text += fmt::format(
        "**Not there yet**: of {} runs that the command makes, {} are stored. A claim that needs one of the others "
        "says "
        "\"not measured\", or by which size it was judged. Missing: {}.\n\n",
        measured.runs.size() + missing.size(), measured.runs.size(), fmt::join(missing, ", "));
  const bool several = processors.size() > 1;
  text += fmt::format(
      "| run | triangles | point lights | settings | reference | repeats | measured |{}\n"
      "| --- | --- | --- | --- | --- | --- | --- |{}\n",
      several ? " processor |" : "", several ? " --- |" : "");
  for (const Run& run : measured.runs) {
    const replay::ResultsHead& of = run.results.head;
    text += fmt::format("| [{} {}x{}{}]({}/{}.json) | {} | {} | {} | {} | {} | {} |", run.plan.scene, of.width,
                        of.height, run.plan.frames > 1 ? fmt::format(", {} frames", run.plan.frames) : "",
                        kMeasuredFolder, run.plan.name(), of.triangles_first_frame,
                        fmt::format("{}{}", of.point_lights, run.plan.every_light ? ", every one" : ""),
                        run.plan.techniques.size(),
                        of.reference_samples == 0 ? "none" : fmt::format("{} samples", of.reference_samples), of.repeat,
                        of.date_utc.substr(0, 16));
    text += several ? fmt::format(" {} |\n", of.cpu_model) : "\n";
  }
  return text +
         "\nOne frame of each scene, but for flicker. Times are warm medians of a software rasteriser: read them as "
         "ratios to `msaa` 8x "
         "of the same run.\n"
         "Where it says \"every one\", shading points evaluate all lights (`--every-light`), as the publications timed "
         "there do or may do; elsewhere\n"
         "those of their cell of the view, for every technique alike, which leaves the same bits.\n"
         "A ratio has a spread, by half of that of the repeats of either; where a claim's limit lies within it, the "
         "claim is left\n"
         "undecided there. MSE and FLIP are of display values against the reference. `S` are surfaces, `c` aggregates, "
         "`8x` samples;\n"
         "what a setting's name does not say is the default (8 samples, `dcaa` and `hybrid` 64). Published bytes are "
         "those of "
         "the format in\n"
         "the paper; kept is what our passes of that form hold over the frame, lists and triangle numbers included; "
         "allocated is the peak\n"
         "with the images that come out and the maps. Frames of games have [a page of their own](games.md): [do the "
         "publications' claims hold\n"
         "there, too?](games.md#do-the-publications-claims-hold-on-frames-of-a-real-game)\n\n";
}

// "3. streaming: three surfaces look like 8x MSAA", and the anchor that Markdown readers make of a heading.
std::string heading_of(const Claim& claim, std::size_t number) {
  std::string text = fmt::format("{}. {}: {}", number, claim.technique, claim.title);
  std::erase(text, '`');
  return text;
}
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ') {
      anchor += '-';
    } else if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return anchor;
}

// The runs of the scenes that some comparison failed on; all runs when those say no scene.
Measured failed_runs(const Measured& measured, const std::vector<Comparison>& comparisons) {
  std::set<std::string> scenes;
  for (const Comparison& comparison : comparisons)
    if (comparison.outcome == Outcome::not_held && !comparison.scene.empty()) scenes.insert(comparison.scene);
  if (scenes.empty()) return measured;
  Measured failed;
  std::ranges::copy_if(measured.runs, std::back_inserter(failed.runs), [&](const Run& run) {
    return scenes.contains(run.plan.scene.substr(0, run.plan.scene.find('@')));
  });
  return failed;
}

// A claim's comparisons: those that decide, the same at 640x360, and scenes that are none of the publication's.
struct Judged {
  std::vector<Comparison> comparisons, small, others;
};

Judged judge(const Claim& claim, const Measured& measured) {
  constexpr std::uint32_t kSmall = 640;
  Judged judged;
  if (claim.width == 0) {
    judged.comparisons = claim.compare(measured);
    return judged;
  }
  const auto stands_in = [&](const Comparison& comparison) {
    return claim.scenes.empty() || comparison.scene.empty() ||
           std::ranges::find(claim.scenes, comparison.scene) != claim.scenes.end();
  };
  judged.comparisons = claim.compare(measured.at_width(claim.width));
  std::erase_if(judged.comparisons, [&](const Comparison& comparison) { return !stands_in(comparison); });
  // Where a scene was not measured at that size, its sweep decides, which its row says.
  const std::vector<const Run*> stills = measured.stills();
  for (Comparison& comparison : judged.comparisons) {
    const auto at_size = [&](const Run* run) {
      return run->plan.scene == comparison.scene && run->plan.width == claim.width;
    };
    if (!comparison.scene.empty() && claim.width != kSmall && std::ranges::none_of(stills, at_size))
      comparison.where += ", not at this size";
  }
  for (const Comparison& comparison : claim.compare(measured.at_width(kSmall, true)))
    (stands_in(comparison) ? judged.small : judged.others).push_back(comparison);
  return judged;
}

std::string claims_markdown(const Measured& measured, const std::vector<Claim>& claims) {
  std::string table = "| | claim | published | here | held |\n| --- | --- | --- | --- | --- |\n";
  std::string details;
  std::map<Verdict, int> counts;
  for (std::size_t i = 0; i < claims.size(); ++i) {
    const Claim& claim = claims[i];
    const Judged judged = judge(claim, measured);
    const std::vector<Comparison>& comparisons = judged.comparisons;
    const std::string result = words(comparisons), heading = heading_of(claim, i + 1);
    ++counts[verdict(comparisons)];
    std::vector<double> values;
    values.reserve(comparisons.size());
    for (const Comparison& comparison : comparisons) values.push_back(comparison.value);
    table +=
        fmt::format("| [{}](#{}) | `{}`: {} | {} | {} | {} |\n", i + 1, anchor_of(heading), claim.technique,
                    claim.title, claim.published,
                    values.empty() ? "" : fmt::format(fmt::runtime(claim.overview), range_text(values, claim.number)),
                    verdict(comparisons) == Verdict::all ? result : fmt::format("**{}**", result));
    details += fmt::format("### {}\n\n{}, {}: {}. {}\n\n", heading, claim.publication, claim.where, claim.published,
                           claim.criterion);
    if (comparisons.empty()) {
      details += "Not measured.\n\n";
      continue;
    }
    const bool beside = !judged.small.empty();
    const char* const size = claim.width == 1280 ? "here, 1280x720" : claim.width == 1920 ? "here, 1920x1080" : "here";
    details += fmt::format("| {} | published | {} | held |{}\n| --- | --- | --- | --- |{}\n", claim.column, size,
                           beside ? " at 640x360 |" : "", beside ? " --- |" : "");
    bool failed = false;
    for (const Comparison& comparison : comparisons) {
      failed = failed || comparison.outcome == Outcome::not_held;
      details += fmt::format("| {} | {} | {} | {} |", comparison.where, comparison.published, comparison.ours,
                             words(comparison.outcome));
      if (beside) {
        const auto small = std::ranges::find(judged.small, comparison.where, &Comparison::where);
        details += small == judged.small.end() ? " |" : fmt::format(" {}, {} |", small->ours, words(small->outcome));
      }
      details += "\n";
    }
    details += fmt::format("\n{}{}.", static_cast<char>(std::toupper(result.front())), result.substr(1));
    if (!judged.others.empty()) {
      std::vector<double> numbers;
      for (const Comparison& other : judged.others) numbers.push_back(other.value);
      details +=
          fmt::format(" On scenes that the publication has nothing like, at 640x360: {} ({}).", words(judged.others),
                      fmt::format(fmt::runtime(claim.overview), range_text(numbers, claim.number)));
    }
    if (failed && claim.reason)
      details += fmt::format(
          " {}", claim.reason(failed_runs(claim.width == 0 ? measured : measured.at_width(claim.width), comparisons)));
    details += "\n\n";
  }
  return fmt::format(
             "## What the publications claim\n\nOf {} claims {} hold wherever they were measured, {} on some scenes or "
             "settings, {} on none. Undecided or not measured: {}.\n\n",
             claims.size(), counts[Verdict::all], counts[Verdict::some], counts[Verdict::none],
             counts[Verdict::unknown]) +
         table + "\n" + details;
}

std::string spread_text(const Interval& ratio) {
  return fmt::format("{:.2f} | {:.2f} to {:.2f}", ratio.value, ratio.low, ratio.high);
}

// Of the two plots' points, in the order of the summaries that both have.
std::string fronts(const replay::Plot& time, const replay::Plot& memory, const std::string& label) {
  const auto on = [&](const replay::Plot& plot) {
    const auto found = std::ranges::find(plot.points, label, &replay::PlotPoint::label);
    return found != plot.points.end() && found->on_front;
  };
  return on(time) && on(memory) ? "both" : on(time) ? "time" : on(memory) ? "memory" : "";
}

replay::Plot plot_of(const Run& run, const std::vector<Summary>& summaries, replay::PlotCost cost) {
  replay::Plot plot = replay::make_plot(summaries, cost, replay::PlotError::mse);
  plot.title = fmt::format("{}, {}x{}", run.plan.scene, run.plan.width, run.plan.height);
  // The library's labels name every parameter that differs within a technique; in a sweep that is too long to place.
  for (replay::PlotPoint& point : plot.points) {
    const auto found = std::ranges::find_if(
        summaries, [&](const Summary& summary) { return replay::setting_label(summary, summaries) == point.label; });
    if (found != summaries.end()) point.label = setting_name(*found);
  }
  return plot;
}

std::string scene_markdown(const Run& run, Document& document) {
  const std::vector<Summary> summaries = summarise(run.results);
  const replay::Plot time = plot_of(run, summaries, replay::PlotCost::ratio);
  const replay::Plot memory = plot_of(run, summaries, replay::PlotCost::memory);
  std::string text = fmt::format("### {}\n\n", run.plan.scene);
  for (const auto& [name, plot] : {std::pair("time", &time), std::pair("memory", &memory)}) {
    if (plot->points.empty()) continue;
    const std::string file = fmt::format("{}/{}_{}.svg", kImageFolder, run.plan.scene, name);
    document.images.emplace_back(file, to_svg(*plot));
    text += fmt::format("![{}: {} against error]({})\n", run.plan.scene, name, file);
  }
  text +=
      "\n| setting | bytes/pixel, published | kept | allocated | executions/pixel | time over `msaa` 8x | spread | ms "
      "| MSE, "
      "1e-4 | FLIP | "
      "on the front |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  const FrameResult* msaa = find(run, "msaa");
  for (const FrameResult& result : run.results.results) {
    const std::string name = setting_name(result.technique, result.parameters);
    text += fmt::format("| `{}` | {:.1f} | {:.1f} | {:.1f} | {:.3f} | {} | {:.1f} | {:.2f} | {:.4f} | {} |\n", name,
                        result.memory.paper_bytes_per_pixel, result.memory.fitted_bytes_per_pixel,
                        static_cast<double>(result.memory.allocated_bytes) / (double(result.width) * result.height),
                        result.shading.per_pixel_mean,
                        msaa == nullptr   ? "|"
                        : msaa == &result ? "1.00 |"
                                          : spread_text(time_ratio(result, *msaa)),
                        result.ms.total_ms, result.error.mse * 1e4, result.error.flip_mean, fronts(time, memory, name));
  }
  return text + "\n";
}

// The same settings at several sizes, of scenes that have more than one.
std::string sizes_markdown(const Measured& measured) {
  std::string text;
  for (const Run* sweep : measured.of_kind(RunKind::sweep)) {
    std::vector<const Run*> runs;
    for (const Run& run : measured.runs)
      if (run.plan.scene == sweep->plan.scene && !run.plan.point_lights && run.plan.kind != RunKind::frames)
        runs.push_back(&run);
    if (runs.size() < 2) continue;
    std::ranges::sort(runs, {}, [](const Run* run) { return run->plan.width; });
    std::string title = fmt::format("| {} |", sweep->plan.scene), rule = "| --- |";
    for (const Run* run : runs) {
      title += fmt::format(" {}x{}: time | MSE | over `msaa` 8x | ms |", run->plan.width, run->plan.height);
      rule += " --- | --- | --- | --- |";
    }
    text.append(title).append("\n").append(rule).append("\n");
    for (const FrameResult& setting : runs.back()->results.results) {
      std::string row = fmt::format("| `{}` |", setting_name(setting.technique, setting.parameters));
      for (const Run* run : runs) {
        const FrameResult* result = find(*run, setting.technique, setting.parameters);
        const FrameResult* msaa = find(*run, "msaa");
        row += result == nullptr || msaa == nullptr
                   ? " | | | |"
                   : fmt::format(" {:.2f} | {:.2f} | {:.2f} | {:.0f} |", result->ms.total_ms / msaa->ms.total_ms,
                                 result->error.mse * 1e4, result->error.mse / msaa->error.mse, result->ms.total_ms);
      }
      text += row + "\n";
    }
    text += "\n";
  }
  if (text.empty()) return text;
  return "## Sizes\n\nTime over `msaa` 8x of the same run, MSE in 1e-4 and over that of `msaa` 8x, ms.\n\n" + text;
}

}  // namespace

Document make_document(const Measured& measured, const std::vector<Claim>& claims, const std::string& command,
                       const std::vector<std::string>& missing) {
  Document document;
  document.markdown = head(measured, command, missing) + which_for_which_markdown(measured) +
                      claims_markdown(measured, claims) + "## Who wins where\n\n" + winners_markdown(measured) + "\n" +
                      sizes_markdown(measured) +
                      "## Speed and memory against error\n\n"
                      "The dashed line is the Pareto front: what lies on it has no setting beside it that is better in "
                      "one and as good in "
                      "the other.\n\n";
  for (const Run* run : measured.of_kind(RunKind::sweep)) document.markdown += scene_markdown(*run, document);
  while (document.markdown.ends_with("\n\n")) document.markdown.pop_back();
  return document;
}

void write_document(const Document& document, const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  std::filesystem::remove_all(folder / kImageFolder);
  for (const auto& [path, svg] : document.images) write_file_atomically(folder / path, std::string_view(svg));
  write_file_atomically(file, std::string_view(document.markdown));
}

}  // namespace subpixel::report
