#include "replay/results/summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/printable.hpp"

namespace subpixel::replay {
namespace {

// A mean over the values that exist, and their maximum.
class Accumulator {
 public:
  void add(double value) {
    if (std::isnan(value)) return;
    sum_ += value;
    maximum_ = count_ == 0 ? value : std::max(maximum_, value);
    ++count_;
  }
  double mean() const { return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : sum_ / count_; }
  std::uint32_t count() const { return count_; }
  double maximum() const { return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : maximum_; }

 private:
  double sum_ = 0, maximum_ = 0;
  std::uint32_t count_ = 0;
};

bool same_point(const Summary& summary, const FrameResult& result) {
  return summary.technique == result.technique && summary.samples == result.samples &&
         summary.parameters == result.parameters;
}

struct Accumulators {
  Accumulator ms, spread, paper, fitted_per_pixel, fitted, allocated, executions, per_pixel;
  Accumulator mse, flip_mean, flip_p99, flip_max, hdr, flicker;

  void add(const FrameResult& result) {
    ms.add(result.ms.total_ms);
    spread.add(result.ms.spread_ms);
    paper.add(result.memory.paper_bytes_per_pixel);
    fitted_per_pixel.add(result.memory.fitted_bytes_per_pixel);
    fitted.add(static_cast<double>(result.memory.fitted_bytes));
    allocated.add(static_cast<double>(result.memory.allocated_bytes));
    executions.add(static_cast<double>(result.shading.executions));
    per_pixel.add(result.shading.per_pixel_mean);
    mse.add(result.error.mse);
    flip_mean.add(result.error.flip_mean);
    flip_p99.add(result.error.flip_p99);
    flip_max.add(result.error.flip_max);
    hdr.add(result.error.hdr_rel_mse);
    flicker.add(result.error.flicker);
  }

  void store(Summary& summary) const {
    summary.total_ms = ms.mean();
    summary.spread_ms = spread.mean();
    summary.paper_bytes_per_pixel = paper.mean();
    summary.fitted_bytes_per_pixel = fitted_per_pixel.mean();
    summary.fitted_bytes = fitted.mean();
    summary.allocated_bytes = allocated.mean();
    summary.executions = executions.mean();
    summary.per_pixel_mean = per_pixel.mean();
    summary.error.mse = mse.mean();
    summary.error.psnr_db = -10 * std::log10(mse.mean());
    summary.error.flip_mean = flip_mean.mean();
    summary.error.flip_p99 = flip_p99.maximum();
    summary.error.flip_max = flip_max.maximum();
    summary.error.hdr_rel_mse = hdr.mean();
    summary.error.flicker = flicker.mean();
    const double none = std::numeric_limits<double>::quiet_NaN();
    summary.worst_mse = mse.count() == summary.frames ? mse.maximum() : none;
    summary.worst_flip = flip_mean.count() == summary.frames ? flip_mean.maximum() : none;
  }
};

}  // namespace

std::vector<Summary> summarise(const Results& results) {
  std::vector<Summary> summaries;
  std::vector<Accumulators> accumulators;
  for (const FrameResult& result : results.results) {
    auto found = std::ranges::find_if(summaries, [&](const Summary& summary) { return same_point(summary, result); });
    if (found == summaries.end()) {
      Summary summary;
      summary.technique = result.technique;
      summary.parameters = result.parameters;
      summary.samples = result.samples;
      summaries.push_back(std::move(summary));
      accumulators.emplace_back();
      found = summaries.end() - 1;
    }
    ++found->frames;
    accumulators[static_cast<std::size_t>(found - summaries.begin())].add(result);
  }
  for (std::size_t i = 0; i < summaries.size(); ++i) accumulators[i].store(summaries[i]);
  return summaries;
}

std::string parameters_text(const ParameterValues& parameters, std::string_view separator) {
  std::string text;
  for (const auto& [name, value] : parameters) {
    if (name == "samples") continue;
    if (!text.empty()) text += separator;
    text += printable(name + "=" + (value.is_string() ? value.get<std::string>() : value.dump()));
  }
  return text;
}

ParameterValues common_parameters(const std::vector<Summary>& summaries) {
  if (summaries.empty()) return {};
  ParameterValues common = summaries.front().parameters;
  common.erase("samples");
  for (const Summary& summary : summaries) {
    std::erase_if(common, [&](const auto& parameter) {
      const auto found = summary.parameters.find(parameter.first);
      return found == summary.parameters.end() || found->second != parameter.second;
    });
  }
  return common;
}

ParameterValues own_parameters(const ParameterValues& parameters, const ParameterValues& common) {
  ParameterValues own = parameters;
  std::erase_if(own, [&](const auto& parameter) { return common.contains(parameter.first); });
  return own;
}

const Summary* baseline(const std::vector<Summary>& summaries, std::string_view technique) {
  const Summary* first = nullptr;
  for (const Summary& summary : summaries) {
    if (summary.technique != technique) continue;
    if (summary.samples == 8) return &summary;
    if (first == nullptr) first = &summary;
  }
  return first;
}

}  // namespace subpixel::replay
