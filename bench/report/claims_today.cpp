// What engineers pick today: visibility buffers (Burns and Hunt 2013, Schied and Dachsbacher 2015), SMAA (Jimenez et
// al. 2012) and temporal anti-aliasing (Yang et al. 2020).
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "bench/report/claims.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;

std::vector<Comparison> frame_times(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const FrameResult* ours = find(*run, "visibility");
    const FrameResult* gbuffer = find(*run, "simple_complex");
    if (ours == nullptr || gbuffer == nullptr) continue;
    const Interval ratio = time_ratio(*ours, *gbuffer);
    comparisons.push_back({run->plan.scene, "faster",
                           fmt::format("{:.2f} ({:.2f} to {:.2f})", ratio.value, ratio.low, ratio.high),
                           at_most(ratio, 1), ratio.value, run->plan.scene});
  }
  return comparisons;
}

std::vector<Comparison> geometry_times(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.of_kind(RunKind::lights)) {
    if (run->plan.point_lights != 5) continue;
    for (const int samples : {4, 8}) {
      const FrameResult* visibility = find(*run, "msaa", {{"samples", samples}});
      const FrameResult* gbuffer = find(*run, "msaa", {{"samples", samples}, {"prepass", false}});
      if (visibility == nullptr || gbuffer == nullptr) continue;
      const Interval ratio = passes_ratio(*visibility, {"visibility"}, *gbuffer, {"gbuffer"});
      comparisons.push_back({fmt::format("{}, {}x", run->plan.scene, samples), "cheaper",
                             fmt::format("{:.2f} ({:.2f} to {:.2f})", ratio.value, ratio.low, ratio.high),
                             at_most(ratio, 1), ratio.value, run->plan.scene});
    }
  }
  return comparisons;
}

constexpr double kGBufferBytes = 20;

// Without depth, which a G-buffer of that size is without as well.
std::vector<Comparison> triangle_buffer(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    const FrameResult* ours = find(*run, "dais");
    if (ours == nullptr || run->plan.width != 3840) continue;
    const double bytes = ours->memory.paper_bytes_per_pixel - 4 * 8, percent = 100 * bytes / (kGBufferBytes * 8);
    comparisons.push_back({run->plan.scene, "30%",
                           fmt::format("{:.1f} bytes a pixel, {:.1f}%; {:.3f} triangles a pixel", bytes, percent,
                                       counter_per_pixel(*ours, "stored_triangles")),
                           at_most(exactly(percent), 32), percent, run->plan.scene});
  }
  return comparisons;
}

std::string triangles_seen(const Measured& measured) {
  const auto seen = [](const Run& run) {
    const FrameResult* ours = find(run, "dais");
    return ours == nullptr ? std::nan("") : counter_per_pixel(*ours, "visible_triangles");
  };
  return fmt::format(
      "A stored triangle has 100 bytes, so 16 bytes a pixel are 0.16 triangles; {} are seen here, since the field's "
      "blades stay smaller than a pixel at that size.",
      range_text(measured.stills(), seen, "{:.3f}"));
}

std::vector<Comparison> better_filter(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const FrameResult* ours = find(*run, "smaa");
    const FrameResult* other = find(*run, "fxaa");
    if (ours == nullptr || other == nullptr || std::isnan(ours->error.flip_mean)) continue;
    comparisons.push_back({run->plan.scene, "better",
                           fmt::format("{:.4f} / {:.4f}", ours->error.flip_mean, other->error.flip_mean),
                           at_most(exactly(ours->error.flip_mean), other->error.flip_mean),
                           ours->error.flip_mean / other->error.flip_mean, run->plan.scene});
  }
  return comparisons;
}

std::string filters(const Measured& measured) {
  const auto mse = [](const Run& run) {
    const FrameResult* ours = find(run, "smaa");
    const FrameResult* other = find(run, "fxaa");
    return ours == nullptr || other == nullptr ? std::nan("") : ours->error.mse / other->error.mse;
  };
  return fmt::format(
      "SMAA keeps an image sharp that one sample a pixel has already made wrong: where blades and fibres are thinner "
      "than a pixel there is no outline to follow, and blurring more, as FXAA does, is nearer to the mean (MSE {} "
      "times that of `fxaa`).",
      range_text(measured.of_kind(RunKind::sweep), mse, "{:.2f}"));
}

std::vector<Comparison> accumulated(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const FrameResult* ours = find(*run, "taa");
    const FrameResult* one = find(*run, "noaa");
    const FrameResult* eight = find(*run, "msaa");
    if (ours == nullptr || one == nullptr || eight == nullptr || std::isnan(ours->error.mse)) continue;
    // How much of the way from one sample to eight.
    const double way = (one->error.mse - ours->error.mse) / (one->error.mse - eight->error.mse);
    comparisons.push_back(
        {run->plan.scene, "most of the way",
         fmt::format("{:.2f} of {:.2f} to {:.2f}", ours->error.mse * 1e4, one->error.mse * 1e4, eight->error.mse * 1e4),
         at_least(exactly(way), 0.5), 100 * way, run->plan.scene});
  }
  return comparisons;
}

std::vector<Comparison> steadier_than_one(const Measured& measured) {
  return steadier_than(measured, "taa", "noaa");
}

}  // namespace

std::vector<Claim> today_claims() {
  return {
      {"visibility", "Burns and Hunt 2013", "figure 1", "outperforms a G-buffer with many samples",
       "faster with large sample counts",
       "Whole frames of `visibility` over those of `simple_complex`, both 8x, in one run, below 1: the faster of our "
       "G-buffers, which lights a sample more than once only in pixels that need it.",
       "scene", "{:.2f}", "{}", &frame_times, nullptr},
      {"visibility", "Burns and Hunt 2013", "abstract", "generating it is cheaper than generating a G-buffer",
       "no texture reads, no material",
       "The pass \"visibility\" over the G-buffer pass of `msaa` without a depth pass first (`prepass=false`), at "
       "1920x1080, below 1.",
       "scene, samples", "{:.2f}", "{}", &geometry_times, nullptr},
      {"dais", "Schied and Dachsbacher 2015", "first figure", "a geometry buffer of 30% at 3840x2160",
       "30% of 20 bytes a sample, 8x",
       "Triangle numbers and triangle buffer over 20 bytes a sample, at 3840x2160 and 8 samples, at most 32%.", "scene",
       "{:.1f}", "{}%", &triangle_buffer, &triangles_seen},
      {"smaa", "Jimenez et al. 2012", "abstract", "better than the filters before it", "overall quality",
       "Mean FLIP of `smaa` against the reference, at most that of `fxaa`; one sample a pixel, SMAA 1x.", "scene",
       "{:.2f}", "{} times the FLIP", &better_filter, &filters},
      {"taa", "Yang et al. 2020", "section 1", "supersampling, amortised over frames",
       "one sample a frame, many in the image",
       "The share of the way from the MSE of `noaa` to that of `msaa` 8x (in 1e-4) that `taa` goes at rest, at least "
       "half.",
       "scene", "{:.0f}", "{}% of the way", &accumulated,
       [](const Measured&) {
         return std::string("History is clipped to what the newest frame's neighbours show, which thin things leave.");
       }},
      {"taa", "Yang et al. 2020", "section 1", "steadier than one sample a pixel", "less flickering",
       "Flicker of `taa` / `noaa`, mean over 16 frames at 320x180 with a moving camera.", "scene", "{:.2f}",
       "{} times the flicker", &steadier_than_one, nullptr}};
}

}  // namespace subpixel::report
