// The stored runs, and how claims look things up in them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/report/plan.hpp"
#include "bench/report/verdict.hpp"
#include "replay/results/results.hpp"

namespace subpixel::report {

// What one image differs from another by, both of one run.
struct PairError {
  double mse = 0, flip_mean = 0;  // of display values
};

struct Run {
  RunPlan plan;
  replay::Results results;
  std::map<std::string, PairError> pairs = {};  // by pair_name()
};

struct Measured {
  std::vector<Run> runs;

  std::vector<const Run*> of_kind(RunKind kind) const;
  // Single frames with the recorded lights: what error, counts and most times are looked up in.
  std::vector<const Run*> stills() const;
  // Of the stills those of this width; of a scene without such a run its sweep, unless `only` that width is asked for.
  // All other runs stay.
  Measured at_width(std::uint32_t width, bool only = false) const;
  const Run* with_lights(std::string_view scene, std::uint32_t point_lights) const;  // null when there is none
};

// The result of a technique with `given` parameters and its defaults for all others; null when it was not measured.
// Throws UsageError for names that the registry doesn't have.
const replay::FrameResult* find(const Run& run, std::string_view technique, const replay::ParameterValues& given = {});

// Of two settings with their other parameters at the defaults; null when they were not compared.
const PairError* find_pair(const Run& run, const replay::TechniqueRequest& test, const replay::TechniqueRequest& base);

// Time of `result` over that of `base`. The ends are by half of the spread of the repeats of each, as in the plots.
Interval time_ratio(const replay::FrameResult& result, const replay::FrameResult& base);
// The same for the sum of some passes, whose spread is taken for the same share of them as that of the whole frame.
Interval passes_ratio(const replay::FrameResult& result, const std::vector<std::string_view>& passes,
                      const replay::FrameResult& base, const std::vector<std::string_view>& base_passes);
// ms of the named passes; NaN when one of them is not there, as after a technique was rearranged.
double passes_ms(const replay::FrameResult& result, const std::vector<std::string_view>& passes);
// The sum of a counter over the pixels; 0 when the result has none of that name.
double counter_per_pixel(const replay::FrameResult& result, const std::string& name);

}  // namespace subpixel::report
