// Who wins where: from the summaries of one run.
#pragma once

#include <string>
#include <vector>

#include "bench/report/measured.hpp"
#include "replay/results/plots.hpp"
#include "replay/results/summary.hpp"

namespace subpixel::report {

// The setting with the lowest error among those that take no longer than `msaa` 8x, itself included; null without it.
const replay::Summary* lowest_error_in_time(const std::vector<replay::Summary>& summaries, replay::PlotError error);
// The setting with the fewest published bytes a pixel among those whose error is at most `budget`; of equal bytes the
// one with less error; null when none is within.
const replay::Summary* least_memory(const std::vector<replay::Summary>& summaries, replay::PlotError error,
                                    double budget);

double error_of(const replay::Summary& summary, replay::PlotError error);
std::string setting_name(const replay::Summary& summary);

// The first page: for each question that an engineer asks, which technique answers it on how many of the frames, then
// frame by frame. Of the sweeps, as Markdown.
std::string which_for_which_markdown(const Measured& measured);

// Tables over all sweeps, as Markdown.
std::string winners_markdown(const Measured& measured);

}  // namespace subpixel::report
