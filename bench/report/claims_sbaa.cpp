// Salvi and Vidimce 2012, whose numbers are those of the papers that compare themselves with it.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "bench/report/claims.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;

std::vector<Comparison> above_msaa(const Measured& measured) {
  // Table 1 of Wang et al.: error over that of 8x MSAA.
  const std::map<std::string, std::string> published = {{"city", "1.87 (Citadel), 1.21 (Villa)"},
                                                        {"bamboo", "1.71"},
                                                        {"grass", "3.77 (Tentacles)"},
                                                        {"arcade", "1.03 (Sponza)"},
                                                        {"cathedral", "1.15 (Sibenik)"}};
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    const FrameResult* ours = find(*run, "sbaa");
    const FrameResult* msaa = find(*run, "forward");
    if (ours == nullptr || msaa == nullptr || std::isnan(ours->error.mse)) continue;
    const auto known = published.find(run->plan.scene);
    comparisons.push_back({run->plan.scene, known == published.end() ? "above 1" : known->second,
                           fmt::format("{:.2f}", ours->error.mse / msaa->error.mse),
                           at_least(exactly(ours->error.mse), msaa->error.mse), ours->error.mse / msaa->error.mse,
                           run->plan.scene});
  }
  return comparisons;
}

}  // namespace

std::vector<Claim> sbaa_claims() {
  return {{"sbaa",
           "Wang et al. 2015 of Salvi and Vidimče 2012",
           "table 1",
           "four surfaces err more than 8x MSAA",
           "1.03 to 3.8 times the MSE",
           "MSE of S=4 over that of `forward` 8x, above 1: their 8x MSAA shades once a visible fragment.",
           "scene",
           "{:.2f}",
           "{} times the MSE",
           &above_msaa,
           [](const Measured& measured) {
             const auto dropped = [](const Run& run) {
               const FrameResult* ours = find(run, "sbaa");
               return ours == nullptr ? std::nan("") : counter_per_pixel(*ours, "dropped");
             };
             return fmt::format(
                 "Four surfaces hold nearly all of what shows: {} samples a pixel belong to others and are left out.",
                 range_text(measured.stills(), dropped, "{:.3f}"));
           },
           1920,
           {"city", "bamboo", "grass", "arcade", "cathedral"}}};
}

}  // namespace subpixel::report
