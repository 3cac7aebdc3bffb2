// Crassin, McGuire, Fatahalian and Lefohn 2016.
#include <fmt/format.h>

#include <cmath>

#include "bench/report/claims.hpp"

namespace subpixel::report {
namespace {

using replay::FrameResult;
constexpr const char* kPublication = "Crassin et al. 2016";
constexpr std::uint32_t kWidth = 1280;  // section 5, figure 15
const std::vector<std::string> kScenes{"city", "foliage", "bamboo", "tubes", "fur"};
// They set it up for no loss against shading every sample.
const replay::ParameterValues kLossless{{"normal_threshold", 1}};

// The first run that measured both.
std::pair<const FrameResult*, const FrameResult*> first_pair(const Measured& measured,
                                                             const replay::ParameterValues& agaa, const char* technique,
                                                             const replay::ParameterValues& parameters) {
  for (const Run& run : measured.runs) {
    const FrameResult* ours = find(run, "agaa", agaa);
    const FrameResult* other = find(run, technique, parameters);
    if (ours != nullptr && other != nullptr) return {ours, other};
  }
  return {nullptr, nullptr};
}

std::vector<Comparison> memory(const Measured& measured) {
  struct Row {
    int samples;
    const char* published;
    double least, most;  // what the published words allow
  };
  std::vector<Comparison> comparisons;
  for (const Row& row : {Row{8, "37%, \"a little under 40%\"", 36.5, 37.5}, Row{16, "\"almost 50%\"", 47, 50},
                         Row{32, "54%", 53.5, 54.5}}) {
    const FrameResult* ours =
        first_pair(measured, {{"samples", row.samples}}, "agaa", {{"samples", row.samples}}).first;
    if (ours == nullptr) continue;
    const double bytes = ours->memory.paper_bytes_per_pixel;
    const double saved = 100 * (1 - bytes / (16.0 * row.samples));
    comparisons.push_back({fmt::format("{}x", row.samples), row.published,
                           fmt::format("{:.0f} of {} bytes/pixel: {:.1f}%", bytes, 16 * row.samples, saved),
                           saved >= row.least && saved <= row.most ? Outcome::held : Outcome::not_held, saved});
  }
  return comparisons;
}

std::vector<Comparison> memory_of_sbaa(const Measured& measured) {
  struct Row {
    int surfaces;
    double percent;
  };
  std::vector<Comparison> comparisons;
  for (const Row& row : {Row{4, 37}, Row{2, 20}}) {
    const auto [ours, sbaa] = first_pair(measured, {}, "sbaa", {{"surfaces", row.surfaces}});
    if (ours == nullptr) continue;
    const double saved = 100 * (1 - ours->memory.paper_bytes_per_pixel / sbaa->memory.paper_bytes_per_pixel);
    comparisons.push_back(
        {fmt::format("S={}", row.surfaces), fmt::format("{:.0f}% less", row.percent),
         fmt::format("{:.0f} and {:.0f} bytes/pixel: {:.1f}% {}", ours->memory.paper_bytes_per_pixel,
                     sbaa->memory.paper_bytes_per_pixel, std::abs(saved), saved < 0 ? "more" : "less"),
         equal(saved, row.percent, 1), saved});
  }
  return comparisons;
}

const replay::TechniqueRequest kOurs{"agaa", {}}, kTwoSurfaces{"sbaa", {{"surfaces", 2}}},
    kFourSurfaces{"sbaa", {{"surfaces", 4}}}, kEvery{"msaa", {}}, kOurs32{"agaa", {{"samples", 32}}},
    kEvery32{"msaa", {{"samples", 32}}};

std::vector<Comparison> quality(const Measured& measured) {
  return as_alike_as(measured, {kOurs, kEvery, kFourSurfaces, kEvery, 1.05}, &PairError::mse);
}
std::vector<Comparison> as_many_shadings(const Measured& measured) {
  return as_alike_as(measured, {kOurs, kEvery, kTwoSurfaces, kEvery}, &PairError::mse);
}
std::vector<Comparison> like_32x(const Measured& measured) {
  return as_alike_as(measured, {kOurs32, kEvery32, kEvery, kEvery32}, &PairError::flip_mean);
}

std::vector<Comparison> anisotropic(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    const FrameResult* toksvig = find(*run, "agaa");
    const FrameResult* sggx = find(*run, "agaa", {{"ndf", "sggx"}});
    if (toksvig == nullptr || sggx == nullptr || std::isnan(sggx->error.mse)) continue;
    comparisons.push_back({run->plan.scene, "better on thin metal",
                           fmt::format("{:.2f} / {:.2f}", sggx->error.mse * 1e4, toksvig->error.mse * 1e4),
                           at_most(exactly(sggx->error.mse), toksvig->error.mse), sggx->error.mse / toksvig->error.mse,
                           run->plan.scene});
  }
  return comparisons;
}

std::vector<Comparison> stability(const Measured& measured) {
  return steadier_than(measured, "agaa", "sbaa", {{"surfaces", 2}});
}

std::vector<Comparison> more_samples(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    constexpr int kSamples[] = {4, 8, 32};
    const FrameResult* at[3];
    for (int i = 0; i < 3; ++i) at[i] = find(*run, "agaa", {{"aggregates", 3}, {"samples", kSamples[i]}});
    if (at[0] == nullptr || at[1] == nullptr || at[2] == nullptr || std::isnan(at[0]->error.mse)) continue;
    const bool falls = at[1]->error.mse <= at[0]->error.mse && at[2]->error.mse <= at[1]->error.mse;
    comparisons.push_back(
        {run->plan.scene, "falls",
         fmt::format("{:.2f}, {:.2f}, {:.2f}", at[0]->error.mse * 1e4, at[1]->error.mse * 1e4, at[2]->error.mse * 1e4),
         falls ? Outcome::held : Outcome::not_held, at[2]->error.mse / at[0]->error.mse, run->plan.scene});
  }
  return comparisons;
}

// In groups of 8x4 pixels, which take as long as their busiest one.
std::vector<Comparison> executions(const Measured& measured, const char* technique,
                                   const replay::ParameterValues& parameters, double percent) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.stills()) {
    const FrameResult* ours = find(*run, "agaa");
    const FrameResult* other = find(*run, technique, parameters);
    if (ours == nullptr || other == nullptr || other->shading.group_executions == 0) continue;
    const double share = 100 * static_cast<double>(ours->shading.group_executions) /
                         static_cast<double>(other->shading.group_executions);
    const double pixels =
        100 * static_cast<double>(ours->shading.executions) / static_cast<double>(other->shading.executions);
    comparisons.push_back({run->plan.scene, fmt::format("{:.0f}%", percent),
                           fmt::format("{:.0f}%, by pixels {:.0f}%", share, pixels), at_most(exactly(share), percent),
                           share, run->plan.scene});
  }
  return comparisons;
}

std::vector<Comparison> of_simple_complex(const Measured& measured) {
  return executions(measured, "simple_complex", kLossless, 25);
}

std::vector<Comparison> of_sbaa(const Measured& measured) {
  return executions(measured, "sbaa", {{"surfaces", 6}}, 45);
}

// Table 1: speed-ups over Simple/Complex.
struct Row {
  const char* scene;
  const char* stands_for;
  double shading8, frame8, shading32, frame32;
};
constexpr Row kTable1[] = {{"city", "Old City", 2.84, 1.54, 6.48, 1.95},
                           {"foliage", "FoliageMap", 2.85, 1.74, 9.23, 2.52},
                           {"bamboo", "Bamboo", 3.50, 1.53, 6.13, 2.53},
                           {"tubes", "Metal", 2.46, 1.04, 4.25, 1.07},
                           {"fur", "Fur Ball", 2.08, 1.00, 2.23, 1.00}};
// The fur ball has one light, the others 16 and one with a shadow.
std::uint32_t lights_of(std::string_view scene) {
  return scene == "fur" ? 0 : 16;
}
replay::ParameterValues timed(int samples, const char* shading, bool lossless) {
  replay::ParameterValues values{{"samples", samples}, {"shading", shading}};
  if (lossless) values.insert(kLossless.begin(), kLossless.end());
  return values;
}

Interval inverse(const Interval& interval) {
  return {1 / interval.high, 1 / interval.value, 1 / interval.low};
}

enum class Part { shading, frame };

// From stored attributes to display values: lighting, the mean over samples and the sky, the tone curve. `shade` of
// `agaa` does all of it; `simple_complex` resolves in a pass of its own.
Interval shading_ratio(const FrameResult& agaa, const FrameResult& simple_complex) {
  return passes_ratio(agaa, {"shade"}, simple_complex, {"shade simple", "shade complex", "resolve"});
}

std::optional<Interval> gain_of(const Run& run, Part part, int samples, const char* shading) {
  const FrameResult* ours = find(run, "agaa", timed(samples, shading, false));
  const FrameResult* base = find(run, "simple_complex", timed(samples, shading, true));
  if (ours == nullptr || base == nullptr) return std::nullopt;
  const Interval gain = inverse(part == Part::frame ? time_ratio(*ours, *base) : shading_ratio(*ours, *base));
  return std::isnan(gain.value) ? std::nullopt : std::optional(gain);
}

std::vector<Comparison> speed(const Measured& measured, Part part, std::optional<double> wanted) {
  std::vector<Comparison> comparisons;
  for (const Row& row : kTable1) {
    const Run* run = measured.with_lights(row.scene, lights_of(row.scene));
    if (run == nullptr) continue;
    for (const int samples : {8, 32}) {
      const auto gain = gain_of(*run, part, samples, "blinn_phong");
      if (!gain) continue;
      const double published = part == Part::shading ? (samples == 8 ? row.shading8 : row.shading32)
                                                     : (samples == 8 ? row.frame8 : row.frame32);
      comparisons.push_back({fmt::format("{} {}x", row.scene, samples),
                             fmt::format("{:.2f} ({})", published, row.stands_for),
                             fmt::format("{:.2f} ({:.2f} to {:.2f})", gain->value, gain->low, gain->high),
                             at_least(*gain, wanted.value_or(published)), gain->value, row.scene});
    }
  }
  return comparisons;
}

// Speed-ups of shading with GGX over those with Blinn-Phong.
std::vector<Comparison> ggx(const Measured& measured) {
  std::vector<Comparison> comparisons;
  for (const Row& row : kTable1) {
    const Run* run = measured.with_lights(row.scene, lights_of(row.scene));
    if (run == nullptr) continue;
    const auto dear = gain_of(*run, Part::shading, 8, "ggx"), cheap = gain_of(*run, Part::shading, 8, "blinn_phong");
    if (!dear || !cheap) continue;
    const Interval more{dear->low / cheap->high, dear->value / cheap->value, dear->high / cheap->low};
    comparisons.push_back({row.scene, "about 1.1 times",
                           fmt::format("{:.2f} / {:.2f}: {:.2f} ({:.2f} to {:.2f})", dear->value, cheap->value,
                                       more.value, more.low, more.high),
                           at_least(more, 1), more.value, row.scene});
  }
  return comparisons;
}

std::string frame_shares(const Measured& measured) {
  std::vector<const Run*> runs;
  for (const Row& row : kTable1)
    if (const Run* run = measured.with_lights(row.scene, lights_of(row.scene))) runs.push_back(run);
  const auto share = [](const char* technique, std::vector<std::string_view> passes) {
    return [technique, passes](const Run& run) {
      const bool lossless = std::string_view(technique) == "simple_complex";
      const FrameResult* result = find(run, technique, timed(8, "blinn_phong", lossless));
      return result == nullptr ? std::nan("") : 100 * passes_ms(*result, passes) / result->ms.total_ms;
    };
  };
  const auto executions_share = [](const Run& run) {
    const FrameResult* ours = find(run, "agaa", timed(8, "blinn_phong", false));
    const FrameResult* base = find(run, "simple_complex", timed(8, "blinn_phong", true));
    if (ours == nullptr || base == nullptr) return std::nan("");
    return 100 * static_cast<double>(ours->shading.executions) / static_cast<double>(base->shading.executions);
  };
  return fmt::format(
      "At 8x the geometry passes that both share, in software here, take {}% of the frame of `simple_complex`, and its "
      "lighting {}%, so there is less to gain. `agaa` has {}% of its executions, and each costs more: depths are read "
      "again, shadows are filtered over the footprint.",
      range_text(runs, share("simple_complex", {"setup", "visibility", "list"}), "{:.0f}"),
      range_text(runs, share("simple_complex", {"shade simple", "shade complex"}), "{:.0f}"),
      range_text(runs, executions_share, "{:.0f}"));
}

std::string execution_counts(const Measured& measured) {
  const auto runs = measured.stills();
  const auto complex = [](const Run& run) {
    const FrameResult* base = find(run, "simple_complex", kLossless);
    return base == nullptr ? std::nan("") : 100 * counter_per_pixel(*base, "complex");
  };
  const auto mean = [](const char* technique, const replay::ParameterValues& parameters) {
    return [=](const Run& run) {
      const FrameResult* result = find(run, technique, parameters);
      return result == nullptr ? std::nan("") : result->shading.per_pixel_mean;
    };
  };
  return fmt::format(
      "Plain pixels are lit once by all three, and complex ones are only {}% of the frames here. `sbaa` with S=6 has "
      "{} executions a pixel, `agaa` {}: where a smooth surface shows several triangles in a pixel, `sbaa` merges them "
      "by their planes, while a distance in space parts them.",
      range_text(runs, complex, "{:.0f}"), range_text(runs, mean("sbaa", {{"surfaces", 6}}), "{:.2f}"),
      range_text(runs, mean("agaa", {}), "{:.2f}"));
}

}  // namespace

std::vector<Claim> agaa_claims() {
  return {
      {"agaa", kPublication, "section 5.4, abstract", "memory against full samples", "37%, almost 50%, 54% saved",
       "The published format of c=2 against 16 bytes a sample, within what the words allow.", "samples", "{:.1f}",
       "{}% saved", &memory, nullptr},
      {"agaa", kPublication, "section 5.4", "memory against SBAA", "37% less than S=4, 20% less than S=2",
       "The published formats of c=2 and `sbaa` in merge mode at 8x, within a point.", "surfaces", "{:.1f}", "{}% less",
       &memory_of_sbaa,
       [](const Measured&) {
         return std::string(
             "The second figure does not follow from the bytes that the same section lists: 6 a sample and 16 an "
             "aggregate with a byte of membership are 81, 7 a sample and 18 a surface are 92, and at 16x they are 132 "
             "and 148: 12% and 11% less. Figure 14 may count something that the text does not say.");
       }},
      {"agaa", kPublication, "sections 5.1.1 and 5.4, figure 9",
       "two aggregates look as good as SBAA with four surfaces", "nearly the same quality",
       "MSE (in 1e-4) of c=2 / `sbaa` S=4 against `msaa` 8x, at most 1.05 times. Their baseline is every sample shaded "
       "at "
       "as many samples, so what 8 samples miss of the scene is not held against either.",
       "scene", "{:.2f}", "{} times the MSE", &quality,
       [](const Measured&) {
         return std::string(
             "Where thin things stand close together, in and out of each other's shadow, light and shadow are averaged "
             "apart within an aggregate (docs/techniques/agaa.md has the parts one by one).");
       },
       kWidth, kScenes},
      {"agaa", kPublication, "section 5.1.1", "better than SBAA at as many shadings", "higher quality",
       "MSE (in 1e-4) of c=2 / `sbaa` S=2 against `msaa` 8x, no larger.", "scene", "{:.2f}", "{} times the MSE",
       &as_many_shadings, nullptr, kWidth, kScenes},
      {"agaa", kPublication, "abstract", "two aggregates compare to 32x MSAA", "comparable",
       "Mean FLIP between c=2 at 32x and `msaa` 32x, at most that between `msaa` 8x and 32x: what a step of samples "
       "changes (c=2 / `msaa` 8x).",
       "scene", "{:.2f}", "{} times the FLIP of 8x", &like_32x,
       [](const Measured&) {
         return std::string(
             "What two aggregates average within a pixel weighs more there than what 24 samples more find.");
       },
       kWidth, kScenes},
      {"agaa", kPublication, "figure 12", "more samples help at three aggregates", "error falls",
       "MSE in 1e-4 of c=3 at 4x, 8x, 32x, the figure's, not rising.", "scene", "{:.2f}",
       "from 4x to 32x {} times the MSE", &more_samples,
       [](const Measured&) {
         return std::string("What is left is lost within aggregates, and more samples do not bring it back.");
       },
       kWidth, kScenes},
      {"agaa", kPublication, "sections 5.1.1, 5.1.2", "steadier over time than SBAA", "more temporal stability",
       "Flicker of c=2 / `sbaa` S=2, mean over 16 frames at 320x180: as many shadings.", "scene", "{:.2f}",
       "{} times the flicker", &stability,
       [](const Measured&) { return std::string("Aggregates follow the triangles of a frame, which change."); }},
      {"agaa",
       kPublication,
       "sections 5.1.3, 5.1.4, figures 10 and 11",
       "SGGX serves thin curved metal better",
       "better than Toksvig",
       "MSE (in 1e-4) of `ndf=sggx` / `toksvig` on the metal tubes, no larger.",
       "scene",
       "{:.2f}",
       "{} times the MSE",
       &anisotropic,
       [](const Measured&) { return std::string("A tube's normals in a pixel are one-sided, which SGGX is not."); },
       kWidth,
       {"tubes"}},
      {"agaa",
       kPublication,
       "section 5.2, figure 13",
       "executions of Simple/Complex",
       "less than 25% (Old City)",
       "Lighting executions of c=2 at 8x in percent of `simple_complex` set to lose nothing, in groups of 8x4 pixels "
       "that "
       "take as long as their busiest: their argument. A pixel has one at least and plain pixels have one in either.",
       "scene",
       "{:.0f}",
       "{}%",
       &of_simple_complex,
       &execution_counts,
       kWidth,
       {"city"}},
      {"agaa",
       kPublication,
       "section 5.2, figure 13",
       "executions of SBAA with six surfaces",
       "45% (Old City)",
       "The same in percent of `sbaa` S=6.",
       "scene",
       "{:.0f}",
       "{}%",
       &of_sbaa,
       &execution_counts,
       kWidth,
       {"city"}},
      {"agaa", kPublication, "section 5.3", "constantly faster than Simple/Complex", "frame 1.00 and more",
       "Speed-up of the whole frame at 1280x720, Blinn-Phong, 16 lights (fur: the sun alone), over `simple_complex` "
       "set to "
       "lose nothing, at least 1; the spread in brackets.",
       "scene", "{:.2f}", "{}", [](const Measured& measured) { return speed(measured, Part::frame, 1.0); },
       &frame_shares},
      {"agaa", kPublication, "table 1", "speed-up of the frame", "1.00 to 1.74 (8x), 1.00 to 2.53 (32x)",
       "The same, at least that of the scene it stands for.", "scene", "{:.2f}", "{}",
       [](const Measured& measured) { return speed(measured, Part::frame, std::nullopt); }, &frame_shares},
      {"agaa", kPublication, "table 1", "speed-up of shading", "2.08 to 3.50 (8x), 2.23 to 9.23 (32x)",
       "`shade` against both lighting passes and the resolve of `simple_complex`, which `shade` contains, at least "
       "that of "
       "the scene it stands for.",
       "scene", "{:.2f}", "{}", [](const Measured& measured) { return speed(measured, Part::shading, std::nullopt); },
       &frame_shares},
      {"agaa", kPublication, "section 5.3", "GGX gains more than Blinn-Phong", "speed-ups about 10% higher",
       "Speed-up of shading at 8x with GGX over that with Blinn-Phong, at least 1.", "scene", "{:.2f}", "{}", &ggx,
       [](const Measured&) {
         return std::string("A dearer light costs an aggregate's filters as much as it costs a sample here.");
       }}};
}

}  // namespace subpixel::report
