// A technique with one set of parameters over all frames of a run: what tables, plots and the advisor compare.
#pragma once

#include <string>
#include <vector>

#include "replay/results/results.hpp"

namespace subpixel::replay {

struct Summary {
  std::string technique;
  ParameterValues parameters;
  std::uint32_t samples = 0;
  std::uint32_t frames = 0;
  // Means over the frames.
  double total_ms = 0, spread_ms = 0;
  double paper_bytes_per_pixel = 0, fitted_bytes_per_pixel = 0, fitted_bytes = 0, allocated_bytes = 0;
  double executions = 0, per_pixel_mean = 0;
  // A metric is the mean over the frames that have it, NaN when none has; flip_p99 and flip_max are the worst frame's,
  // psnr_db follows from the mean of the MSE.
  ImageError error;
  // Of the worst frame, NaN when a frame has none: a budget holds for every frame or not at all.
  double worst_mse = 0, worst_flip = 0;
};

// In the order of first appearance.
std::vector<Summary> summarise(const Results& results);

// "surfaces=3 merge_weight=equal": the parameters of one technique, without `samples`, which has its own column.
std::string parameters_text(const ParameterValues& parameters, std::string_view separator = " ");

// The parameters, `samples` aside, that every summary has with one value: said once, they need not stand in every row.
ParameterValues common_parameters(const std::vector<Summary>& summaries);
// `parameters` without those that `common` holds.
ParameterValues own_parameters(const ParameterValues& parameters, const ParameterValues& common);

// The result that ratios refer to: `technique` with 8 samples, else its first appearance, else null.
const Summary* baseline(const std::vector<Summary>& summaries, std::string_view technique);

}  // namespace subpixel::replay
