// Kerzner and Salvi 2014.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/report/claims.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;
constexpr const char* kPublication = "Kerzner and Salvi 2014";
constexpr std::uint32_t kWidth = 1280;  // their program's window; the counts of table 1 fit it
const std::vector<std::string> kScenes{"grass", "arcade", "plant"};

std::vector<Comparison> memory(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    for (const auto& [samples, bytes, percent] : {std::tuple{8, 96.0, 50.0}, std::tuple{4, 80.0, 83.3}}) {
      const FrameResult* ours = find(*run, "streaming", {{"samples", samples}});
      const FrameResult* base = find(*run, "simple_complex", {{"samples", samples}});
      if (ours == nullptr || base == nullptr) continue;
      const double share = 100 * ours->memory.paper_bytes_per_pixel / base->memory.paper_bytes_per_pixel;
      const bool same = equal(ours->memory.paper_bytes_per_pixel, bytes, 0.05) == Outcome::held;
      comparisons.push_back({fmt::format("{}x", samples), fmt::format("{:.0f} bytes/pixel, {:.1f}%", bytes, percent),
                             fmt::format("{:.0f} bytes/pixel, {:.1f}%", ours->memory.paper_bytes_per_pixel, share),
                             same ? equal(share, percent, 0.05) : Outcome::not_held, share});
    }
    if (!comparisons.empty()) break;  // the published format does not depend on the scene
  }
  return comparisons;
}

struct Share {
  const char* scene;
  const char* stands_for;
  double at8, at4;  // percent
};
constexpr Share kShares[] = {
    {"arcade", "Sponza", 77.8, 92.2}, {"plant", "PowerPlant", 70.5, 88.7}, {"grass", "Grass", 44.9, 72.9}};

double executions_share(const Run& run, int samples) {
  const FrameResult* ours = find(run, "streaming", {{"samples", samples}});
  const FrameResult* base = find(run, "simple_complex", {{"samples", samples}});
  if (ours == nullptr || base == nullptr || base->shading.executions == 0) return std::nan("");
  return 100 * static_cast<double>(ours->shading.executions) / static_cast<double>(base->shading.executions);
}

std::vector<Comparison> executions(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    const auto published = std::ranges::find_if(kShares, [&](const Share& of) { return of.scene == run->plan.scene; });
    if (published == std::end(kShares)) continue;
    for (const int samples : {8, 4}) {
      const double share = executions_share(*run, samples), theirs = samples == 8 ? published->at8 : published->at4;
      if (std::isnan(share)) continue;
      comparisons.push_back({fmt::format("{} {}x", run->plan.scene, samples),
                             fmt::format("{:.1f}% ({})", theirs, published->stands_for), fmt::format("{:.1f}%", share),
                             equal(share, theirs, 2), share, run->plan.scene});
    }
  }
  return comparisons;
}

// The share falls as more blades meet in a pixel: fields of other densities.
std::string densities(const Measured& measured) {
  std::string rows;
  for (const Run& run : measured.runs) {
    const FrameResult* base = find(run, "simple_complex");
    if (!run.plan.scene.starts_with("grass") || run.plan.width != kWidth || run.plan.point_lights || base == nullptr)
      continue;
    const auto at = run.plan.scene.find('@');
    rows += fmt::format("{}{} of its blades {:.1f}% and {:.1f}% at {:.2f} executions a pixel of `simple_complex` 8x",
                        rows.empty() ? "" : ", ", at == std::string::npos ? "1" : run.plan.scene.substr(at + 1),
                        executions_share(run, 8), executions_share(run, 4), base->shading.per_pixel_mean);
  }
  return fmt::format(
      "The share is a property of the scene: the more fragments meet in a pixel, the more of them merge. The field of "
      "grass with {}. Table 1 has 2.77 there (2.55 million in 1280x720): grass as sparse as theirs is about as cheap, "
      "and where ours is off, it has fewer executions than published, not more.",
      rows.empty() ? "all densities unmeasured" : rows);
}

const replay::TechniqueRequest kOurs{"streaming", {}}, kFour{"streaming", {{"surfaces", 4}}}, kForward{"forward", {}},
    kLauritzen{"simple_complex", {}};

std::vector<Comparison> three_surfaces(const Measured& measured) {
  return as_alike_as(measured, {kOurs, kForward, kLauritzen, kForward}, &PairError::flip_mean);
}

std::vector<Comparison> fourth_surface(const Measured& measured) {
  return as_alike_as(measured, {kOurs, kFour, kLauritzen, kForward}, &PairError::flip_mean);
}

std::vector<Comparison> two_surfaces(const Measured& measured) {
  std::vector<Comparison> comparisons =
      as_alike_as(measured, {{"streaming", {{"surfaces", 2}}}, kForward, kOurs, kForward}, &PairError::flip_mean);
  for (Comparison& comparison : comparisons) {
    comparison.published = "not acceptable";
    comparison.outcome = comparison.value >= 1 ? Outcome::held : Outcome::not_held;
  }
  return comparisons;
}

// Figure 1 names one scene without its name; figures 5 and 6 show lines near each other or below.
std::vector<Comparison> frame_time(const Measured& measured) {
  std::vector<Comparison> comparisons;
  const Interval* best = nullptr;
  std::vector<Interval> ratios;
  for (const Run* run : measured.stills()) {
    const FrameResult* ours = find(*run, "streaming");
    const FrameResult* base = find(*run, "simple_complex");
    if (ours == nullptr || base == nullptr || run->plan.repeat < 2) continue;
    ratios.push_back(time_ratio(*ours, *base));
    const Interval& ratio = ratios.back();
    comparisons.push_back({run->plan.scene, "on par or less",
                           fmt::format("{:.2f} ({:.2f} to {:.2f})", ratio.value, ratio.low, ratio.high),
                           at_most(ratio, 1), ratio.value, run->plan.scene});
  }
  for (const Interval& ratio : ratios)
    if (best == nullptr || ratio.value < best->value) best = &ratio;
  if (best != nullptr)
    comparisons.push_back({"the best of them", "0.7 (figure 1)",
                           fmt::format("{:.2f} ({:.2f} to {:.2f})", best->value, best->low, best->high),
                           at_most(*best, 0.7), best->value});
  return comparisons;
}

double compression_share(const Run& run) {
  const FrameResult* ours = find(run, "streaming");
  return ours == nullptr ? std::nan("") : 100 * (1 - passes_ms(*ours, {"setup", "shade"}) / ours->ms.total_ms);
}

// From the still with the fewest fragments a pixel to that with the most.
std::vector<Comparison> compression(const Measured& measured) {
  std::vector<const Run*> runs;
  for (const Run* run : measured.stills())
    if (const FrameResult* ours = find(*run, "streaming");
        ours != nullptr && run->plan.repeat > 1 && ours->counters.contains("listed_fragments"))
      runs.push_back(run);
  if (runs.size() < 2) return {};
  const auto fragments = [](const Run* run) { return counter_per_pixel(*find(*run, "streaming"), "listed_fragments"); };
  const auto [few, many] = std::ranges::minmax(runs, {}, fragments);
  const double low = compression_share(*few), high = compression_share(*many);
  return {{fmt::format("{} to {}", few->plan.scene, many->plan.scene), "35% to 80%",
           fmt::format("{:.0f}% to {:.0f}% of the frame at {:.1f} and {:.1f} fragments a pixel", low, high,
                       fragments(few), fragments(many)),
           low < high ? Outcome::held : Outcome::not_held, high - low}};
}

std::string discards(const Measured& measured) {
  const auto of = [](const char* name) {
    return [name](const Run& run) {
      const FrameResult* ours = find(run, "streaming");
      return ours == nullptr ? std::nan("") : counter_per_pixel(*ours, name);
    };
  };
  const auto fourth = [](const Run& run) {
    const FrameResult* four = find(run, "streaming", {{"surfaces", 4}});
    const FrameResult* ours = find(run, "streaming");
    return four == nullptr || ours == nullptr ? std::nan("") : four->error.mse / ours->error.mse;
  };
  return fmt::format(
      "A pixel of three places discards surfaces that show: {} samples a pixel. A fourth place alone, nothing else "
      "changed, leaves {} of the MSE to the reference, so it is the places that are short, where blades and pipes "
      "thinner than anything in the paper's figures meet. Hidden surfaces with long depth intervals keep some of them: "
      "`occlusion=depth_test` is our remedy.",
      range_text(measured.stills(), of("discards"), "{:.2f}"), range_text(measured.stills(), fourth, "{:.2f}"));
}

}  // namespace

std::vector<Claim> streaming_claims() {
  return {
      {"streaming", kPublication, "table 1, left", "memory against `simple_complex`",
       "96 and 80 bytes/pixel: 50.0%, 83.3%", "The published formats at 8x and 4x, equal to a digit.", "samples",
       "{:.1f}", "{}%", &memory, nullptr},
      {"streaming", kPublication, "table 1, right", "fewer lighting executions than `simple_complex`",
       "77.8% (Sponza), 70.5% (PowerPlant), 44.9% (Grass) at 8x; 92.2%, 88.7%, 72.9% at 4x",
       "The share of the scene that stands for theirs, within 2 points either way: too low a share shows another "
       "scene, "
       "as too high a one does.",
       "scene", "{:.1f}", "{}%", &executions, &densities, kWidth, kScenes},
      {"streaming", kPublication, "figures 4 and 7", "three surfaces look like 8x MSAA", "indistinguishable",
       "Mean FLIP between the images of S=3 and `forward` 8x, their reference, at most that between `simple_complex`'s "
       "and the same, of which they say it too (S=3 / `simple_complex`). An error against a finer reference would hold "
       "the samples' number against them.",
       "scene", "{:.2f}", "{} times the FLIP of `simple_complex`", &three_surfaces, &discards, kWidth, kScenes},
      {"streaming", kPublication, "section 4, figure 4", "a fourth surface changes nothing visible",
       "no visible difference",
       "Mean FLIP between the images of S=3 and S=4, at most that between `simple_complex` and `forward` 8x, which "
       "pass "
       "for alike.",
       "scene", "{:.2f}", "{} times the FLIP of `simple_complex`", &fourth_surface, &discards, kWidth, kScenes},
      {"streaming", kPublication, "section 5", "two surfaces are too few", "three are required",
       "Mean FLIP to `forward` 8x of S=2, larger than that of S=3 (S=2 / S=3).", "scene", "{:.2f}",
       "{} times the FLIP of S=3", &two_surfaces, nullptr, kWidth, kScenes},
      {"streaming", kPublication, "figures 1, 5, 6", "30% less frame time in one figure, on par elsewhere",
       "0.7; about 1",
       "Whole frames over those of `simple_complex` at 8x with 32 lights; the spread of the repeats in brackets. "
       "Figure 1 gives 30% for one scene, figures 5 and 6 show frames often faster, else on par.",
       "scene", "{:.2f}", "{}", &frame_time,
       [](const Measured& measured) {
         const auto lighting = [](const Run& run) {
           const FrameResult* ours = find(run, "streaming");
           const FrameResult* base = find(run, "simple_complex");
           if (ours == nullptr || base == nullptr) return std::nan("");
           return passes_ms(*ours, {"shade"}) / passes_ms(*base, {"shade simple", "shade complex"});
         };
         return fmt::format(
             "Its lighting takes {} of the time of that of `simple_complex`, but collecting and merging fragments is "
             "{}% "
             "of the frame. It evaluates every fragment that is nearest so far, where the others fetch attributes for "
             "visible triangles only, and here depth tests have no hardware to run in.",
             range_text(measured.stills(), lighting, "{:.2f}"),
             range_text(measured.stills(), &compression_share, "{:.0f}"));
       },
       kWidth, kScenes},
      {"streaming",
       kPublication,
       "figure 5",
       "compression takes over as fragments rise",
       "4.0 of 11.3 ms to 20.7 of 26 ms",
       "The share of all passes but set-up and shading in the frame, larger in the scene with the most fragments a "
       "pixel "
       "than in that with the fewest. Their two frames of Sponza differ in nothing else.",
       "scenes",
       "{:.0f}",
       "{} points more",
       &compression,
       nullptr,
       kWidth,
       {}}};
}

}  // namespace subpixel::report
