#include "bench/report/measured.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "replay/techniques/registry.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;

struct Time {
  double ms, spread_ms;
};

Interval ratio(const Time& time, const Time& base) {
  const double half = 0.5 * time.spread_ms, base_half = 0.5 * base.spread_ms;
  return {std::max(time.ms - half, 0.0) / (base.ms + base_half), time.ms / base.ms,
          (time.ms + half) / std::max(base.ms - base_half, 0.5 * base.ms)};
}

}  // namespace

std::vector<const Run*> Measured::of_kind(RunKind kind) const {
  std::vector<const Run*> found;
  for (const Run& run : runs)
    if (run.plan.kind == kind) found.push_back(&run);
  return found;
}

namespace {

bool is_still(const Run& run) {
  return !run.plan.point_lights && run.plan.kind != RunKind::frames;
}

}  // namespace

std::vector<const Run*> Measured::stills() const {
  std::vector<const Run*> found;
  for (const Run& run : runs)
    if (is_still(run)) found.push_back(&run);
  return found;
}

Measured Measured::at_width(std::uint32_t width, bool only) const {
  std::set<std::string> scenes;
  for (const Run& run : runs)
    if (is_still(run) && run.plan.width == width) scenes.insert(run.plan.scene);
  Measured kept;
  std::ranges::copy_if(runs, std::back_inserter(kept.runs), [&](const Run& run) {
    if (!is_still(run) || run.plan.width == width) return true;
    return !only && run.plan.kind == RunKind::sweep && !scenes.contains(run.plan.scene);
  });
  return kept;
}

const Run* Measured::with_lights(std::string_view scene, std::uint32_t point_lights) const {
  for (const Run& run : runs)
    if (run.plan.scene == scene && run.plan.point_lights == point_lights) return &run;
  return nullptr;
}

const FrameResult* find(const Run& run, std::string_view technique, const replay::ParameterValues& given) {
  const auto wanted = replay::find_technique(technique).with(given).values;
  for (const FrameResult& result : run.results.results)
    if (result.technique == technique && result.parameters == wanted) return &result;
  return nullptr;
}

const PairError* find_pair(const Run& run, const replay::TechniqueRequest& test, const replay::TechniqueRequest& base) {
  const auto whole = [](const replay::TechniqueRequest& request) {
    return replay::TechniqueRequest{request.technique,
                                    replay::find_technique(request.technique).with(request.parameters).values};
  };
  const auto found = run.pairs.find(pair_name({whole(test), whole(base)}));
  return found == run.pairs.end() ? nullptr : &found->second;
}

Interval time_ratio(const FrameResult& result, const FrameResult& base) {
  return ratio({result.ms.total_ms, result.ms.spread_ms}, {base.ms.total_ms, base.ms.spread_ms});
}

Interval passes_ratio(const FrameResult& result, const std::vector<std::string_view>& passes, const FrameResult& base,
                      const std::vector<std::string_view>& base_passes) {
  const auto time = [](const FrameResult& of, const std::vector<std::string_view>& names) {
    const double ms = passes_ms(of, names);
    return Time{ms, of.ms.total_ms > 0 ? ms * of.ms.spread_ms / of.ms.total_ms : 0};
  };
  return ratio(time(result, passes), time(base, base_passes));
}

double passes_ms(const FrameResult& result, const std::vector<std::string_view>& passes) {
  double sum = 0;
  for (const std::string_view name : passes) {
    const auto found = std::ranges::find(result.ms.passes, name, &replay::PassTime::name);
    sum += found == result.ms.passes.end() ? std::nan("") : found->median_ms;
  }
  return sum;
}

double counter_per_pixel(const FrameResult& result, const std::string& name) {
  const auto found = result.counters.find(name);
  return found == result.counters.end() ? 0
                                        : static_cast<double>(found->second) / (double(result.width) * result.height);
}

}  // namespace subpixel::report
