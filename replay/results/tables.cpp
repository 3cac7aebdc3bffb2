// The two text forms of results: CSV with every column, and the terminal's table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/printable.hpp"
#include "replay/results/results.hpp"
#include "replay/results/summary.hpp"

namespace subpixel::replay {
namespace {

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

// Shortest text that reads back as the same double; empty for what was not measured.
std::string csv_number(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& field : fields) {
    if (&field != &fields.front()) line += ',';
    line += csv_field(field);
  }
  return line + "\r\n";
}

// Names in order of first appearance over all results.
template <class NamesOf>
std::vector<std::string> union_of_names(const Results& results, NamesOf names_of) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const FrameResult& result : results.results) {
    for (const std::string& name : names_of(result)) {
      if (seen.insert(name).second) names.push_back(name);
    }
  }
  return names;
}

std::string with_thousands(std::uint64_t value) {
  const std::string digits = std::to_string(value);
  std::string out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i != 0 && (digits.size() - i) % 3 == 0) out += ',';
    out += digits[i];
  }
  return out;
}

std::string or_dash(double value, const std::string& text) {
  return std::isnan(value) ? "-" : text;
}

std::string ratio(double value, const Summary* base) {
  if (base == nullptr || !(base->total_ms > 0)) return "-";
  return fmt::format("{:.2f}", value / base->total_ms);
}

std::string baseline_name(const Summary* base) {
  return base == nullptr ? "none in this run" : fmt::format("{} {}x", base->technique, base->samples);
}

// Appends `text`, or "-" for a head whose field was never filled.
std::string known(const std::string& text) {
  return text.empty() ? "-" : text;
}

// Which techniques a budget made draw in bands; empty where none.
std::string bands_text(const Results& results) {
  std::map<std::string, Memory> most;  // by technique
  for (const FrameResult& result : results.results) {
    Memory& memory = most[result.technique];
    memory.bands = std::max(memory.bands, result.memory.bands);
    memory.peak_bytes = std::max(memory.peak_bytes, result.memory.peak_bytes);
  }
  std::string out;
  for (const auto& [technique, memory] : most) {
    if (memory.bands <= 1) continue;
    out += fmt::format("{}{} in {} bands of at most {:.1f} MiB", out.empty() ? "memory     " : ", ", technique,
                       memory.bands, static_cast<double>(memory.peak_bytes) / (1 << 20));
  }
  return out.empty() ? out : out + "\n";
}

std::string head_block(const Results& results, const ParameterValues& common, const Summary* msaa,
                       const Summary* noaa) {
  const ResultsHead& head = results.head;
  const std::string hash = head.capture_hash.substr(0, 16);
  std::set<std::uint32_t> frames;
  for (const FrameResult& result : results.results) frames.insert(result.frame);
  std::string out;
  out += fmt::format("capture    {}{}\n", known(printable(head.capture_title)), hash.empty() ? "" : " (" + hash + ")");
  out += fmt::format("frames     {} of {}x{}, {} triangles in the first, {} point lights\n", frames.size(), head.width,
                     head.height, with_thousands(head.triangles_first_frame), head.point_lights);
  out += fmt::format("driver     {} {}, {}\n", known(head.driver), head.driver_version, known(head.device));
  out += fmt::format("cpu        {}\n", known(head.cpu_model));
  out += head.reference_samples == 0 ? std::string("reference  none: no error is measured\n")
                                     : fmt::format("reference  {} samples per pixel\n", head.reference_samples);
  out += fmt::format("times      warm median of {} repeats, mean over the frames; ratios to {} and {}\n", head.repeat,
                     baseline_name(msaa), baseline_name(noaa));
  if (head.wall_s > 0)
    out += fmt::format("run        {:.0f} s, of which {:.1f} % outside of device passes\n", head.wall_s,
                       100 * head.outside_gpu_s / head.wall_s);
  out += bands_text(results);
  if (!common.empty()) out += fmt::format("all with   {}\n", parameters_text(common));
  return out;
}

}  // namespace

std::string to_csv(const Results& results) {
  const std::vector<std::string> passes = union_of_names(results, [](const FrameResult& result) {
    std::vector<std::string> names;
    for (const PassTime& pass : result.ms.passes) names.push_back(pass.name);
    return names;
  });
  const std::vector<std::string> shaded = union_of_names(results, [](const FrameResult& result) {
    std::vector<std::string> names;
    for (const auto& pass : result.shading.fragments) names.push_back(pass.first);
    return names;
  });
  const std::vector<std::string> counters = union_of_names(results, [](const FrameResult& result) {
    std::vector<std::string> names;
    for (const auto& counter : result.counters) names.push_back(counter.first);
    return names;
  });
  std::vector<std::string> header = {"frame",
                                     "technique",
                                     "parameters",
                                     "samples",
                                     "width",
                                     "height",
                                     "total_ms",
                                     "spread_ms",
                                     "cold_ms",
                                     "paper_bytes_per_pixel",
                                     "fitted_bytes_per_pixel",
                                     "paper_bytes",
                                     "fitted_bytes",
                                     "allocated_bytes",
                                     "bands",
                                     "peak_bytes",
                                     "shading_executions",
                                     "shading_per_pixel",
                                     "shading_histogram",
                                     "shading_group_executions",
                                     "mse",
                                     "psnr_db",
                                     "flip_mean",
                                     "flip_p99",
                                     "flip_max",
                                     "hdr_rel_mse",
                                     "flicker"};
  for (const std::string& pass : passes) header.push_back("pass_" + pass + "_ms");
  for (const std::string& pass : shaded) header.push_back("pass_" + pass + "_fragments");
  for (const std::string& counter : counters) header.push_back("counter_" + counter);
  std::string out = csv_line(header);
  for (const FrameResult& result : results.results) {
    const ImageError& error = result.error;
    std::vector<std::string> fields = {std::to_string(result.frame),
                                       result.technique,
                                       parameters_text(result.parameters, ";"),
                                       std::to_string(result.samples),
                                       std::to_string(result.width),
                                       std::to_string(result.height)};
    for (const double value : {result.ms.total_ms, result.ms.spread_ms, result.ms.cold_ms,
                               result.memory.paper_bytes_per_pixel, result.memory.fitted_bytes_per_pixel}) {
      fields.push_back(csv_number(value));
    }
    for (const std::uint64_t value :
         {result.memory.paper_bytes, result.memory.fitted_bytes, result.memory.allocated_bytes,
          std::uint64_t{result.memory.bands}, result.memory.peak_bytes, result.shading.executions}) {
      fields.push_back(std::to_string(value));
    }
    fields.push_back(csv_number(result.shading.per_pixel_mean));
    fields.push_back(fmt::format("{}", fmt::join(result.shading.histogram, ";")));
    fields.push_back(std::to_string(result.shading.group_executions));
    for (const double value : {error.mse, error.psnr_db, error.flip_mean, error.flip_p99, error.flip_max,
                               error.hdr_rel_mse, error.flicker}) {
      fields.push_back(csv_number(value));
    }
    for (const std::string& name : passes) {
      double sum = 0;
      bool found = false;
      for (const PassTime& pass : result.ms.passes) {
        if (pass.name != name) continue;
        sum += pass.median_ms;
        found = true;
      }
      fields.push_back(found ? csv_number(sum) : "");
    }
    for (const std::string& name : shaded) {
      const auto found = result.shading.fragments.find(name);
      fields.push_back(found == result.shading.fragments.end() ? "" : std::to_string(found->second));
    }
    for (const std::string& name : counters) {
      const auto found = result.counters.find(name);
      fields.push_back(found == result.counters.end() ? "" : std::to_string(found->second));
    }
    out += csv_line(fields);
  }
  return out;
}

std::string to_table(const Results& results) {
  const std::vector<Summary> summaries = summarise(results);
  const Summary* msaa = baseline(summaries, "msaa");
  const Summary* noaa = baseline(summaries, "noaa");
  const ParameterValues common = common_parameters(summaries);
  const auto own = [&](const Summary& summary) { return parameters_text(own_parameters(summary.parameters, common)); };
  // Numbers first and the parameters, which have no fixed length, last: a narrow terminal wraps only those.
  std::vector<std::vector<std::string>> rows = {{"technique", "n", "B/px paper", "fitted", "alloc MB", "shadings/px",
                                                 "ms", "+-", "x msaa", "x noaa", "MSE", "PSNR", "FLIP", "parameters"}};
  for (const Summary& summary : summaries) {
    const ImageError& error = summary.error;
    rows.push_back(
        {summary.technique, std::to_string(summary.samples), fmt::format("{:.1f}", summary.paper_bytes_per_pixel),
         fmt::format("{:.1f}", summary.fitted_bytes_per_pixel), fmt::format("{:.1f}", summary.allocated_bytes / 1e6),
         fmt::format("{:.3f}", summary.per_pixel_mean), fmt::format("{:.1f}", summary.total_ms),
         fmt::format("{:.1f}", summary.spread_ms), ratio(summary.total_ms, msaa), ratio(summary.total_ms, noaa),
         or_dash(error.mse, fmt::format("{:.2e}", error.mse)),
         or_dash(error.psnr_db, fmt::format("{:.2f}", error.psnr_db)),
         or_dash(error.flip_mean, fmt::format("{:.4f}", error.flip_mean)), own(summary)});
  }
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  const bool any_parameters =
      std::ranges::any_of(summaries, [&](const Summary& summary) { return !own(summary).empty(); });
  std::string out = head_block(results, common, msaa, noaa) + "\n";
  for (const auto& row : rows) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i + 1 < row.size(); ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
    if (any_parameters) line += "  " + row.back();
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace subpixel::replay
