#include "cli/measure_verbs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "replay/measure/comparison.hpp"
#include "replay/measure/maps.hpp"
#include "replay/results/advisor.hpp"
#include "replay/results/results_file.hpp"

namespace subpixel::cli {
namespace {

using nlohmann::json;

struct CompareOptions {
  std::string reference, test, error_map, layer;
  double pixels_per_degree = replay::FlipOptions{}.pixels_per_degree;
  bool as_json = false;
};

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json pooled(const replay::FlipResult& flip) {
  return {{"mean", flip.mean},
          {"weighted_first_quartile", flip.weighted_first_quartile},
          {"weighted_median", flip.weighted_median},
          {"weighted_third_quartile", flip.weighted_third_quartile},
          {"p99", flip.p99},
          {"max", flip.maximum}};
}

std::string pooled_line(const replay::FlipResult& flip) {
  return fmt::format("mean {:.6f}  weighted quartiles {:.6f} {:.6f} {:.6f}  p99 {:.6f}  max {:.6f}", flip.mean,
                     flip.weighted_first_quartile, flip.weighted_median, flip.weighted_third_quartile, flip.p99,
                     flip.maximum);
}

json to_json(const CompareOptions& options, const replay::ImageFile& reference, const replay::ImageFile& test,
             const replay::Comparison& found) {
  json document = {
      {"reference", options.reference},
      {"test", options.test},
      {"width", found.width},
      {"height", found.height},
      {"channels", {{"reference", reference.channels}, {"test", test.channels}}},
      {"not_compared", {{"reference", reference.left_out}, {"test", test.left_out}}},
      {"pixels_outside_window", {{"reference", reference.pixels_outside}, {"test", test.pixels_outside}}},
      {"not_finite_pixels", {{"reference", found.not_finite_pixels[0]}, {"test", found.not_finite_pixels[1]}}},
      {"clamped_pixels", {{"reference", found.clamped_pixels[0]}, {"test", found.clamped_pixels[1]}}},
      {"differing_pixels", found.differing_pixels},
      {"largest_difference", number(found.largest_difference)},
      {"largest_difference_at", found.largest_at},
      {"mse", found.mse},
      {"psnr", number(found.psnr_db)},
      {"ssim", number(found.ssim)},
      {"hdr_rel_mse", found.hdr_relative_mse ? json(*found.hdr_relative_mse) : json(nullptr)},
      {"alpha_mse", found.alpha_mse ? json(*found.alpha_mse) : json(nullptr)},
      {"alpha_differing_pixels", found.alpha_differing_pixels},
      {"flip", pooled(found.flip)}};
  document["flip"]["pixels_per_degree"] = options.pixels_per_degree;
  if (found.hdr_flip) {
    document["hdr_flip"] = pooled(found.hdr_flip->error);
    document["hdr_flip"]["start_exposure"] = found.hdr_flip->start;
    document["hdr_flip"]["stop_exposure"] = found.hdr_flip->stop;
    document["hdr_flip"]["exposures"] = found.hdr_flip->exposures;
  }
  return document;
}

// Up to as many as a line holds; --json has all.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMostListed = 12;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMostListed; ++i)
    text += (i == 0 ? "" : ", ") + printable(names[i], 60);
  if (names.size() > kMostListed) text += fmt::format(" and {} more", names.size() - kMostListed);
  return text.empty() ? "none" : text;
}

// "12 and 0", or nothing when there are none in both.
std::string both(const std::array<std::uint64_t, 2>& counts, const char* format) {
  if (counts[0] == 0 && counts[1] == 0) return "";
  return fmt::format(fmt::runtime(format), counts[0], counts[1]);
}

std::string to_text(const CompareOptions& options, const replay::ImageFile& reference, const replay::ImageFile& test,
                    const replay::Comparison& found) {
  std::string out = fmt::format("size  {}x{}\n", found.width, found.height);
  const std::string channels = listed(reference.channels), test_channels = listed(test.channels);
  out += channels == test_channels ? fmt::format("compared  {}\n", channels)
                                   : fmt::format("compared  {} with {}\n", channels, test_channels);
  if (!reference.left_out.empty() || !test.left_out.empty())
    out += fmt::format("not compared  {} of the reference; {} of the test\n", listed(reference.left_out),
                       listed(test.left_out));
  out += both({reference.pixels_outside, test.pixels_outside},
              "not compared  {} pixels of the reference, {} of the test, outside of the display window\n");
  const std::uint64_t pixels = std::uint64_t{found.width} * found.height;
  out += found.differing_pixels == 0
             ? "differ  no pixel\n"
             : fmt::format("differ  {} of {} pixels; most, by {:.6g}, that at {},{}\n", found.differing_pixels, pixels,
                           found.largest_difference, found.largest_at[0], found.largest_at[1]);
  out += both(found.not_finite_pixels,
              "not finite  {} pixels of the reference, {} of the test; each counts as the largest difference\n");
  out += both(found.clamped_pixels,
              "outside 0 to 1  {} pixels of the reference, {} of the test; MSE, PSNR, SSIM and FLIP see 0 or 1\n");
  out += fmt::format("MSE   {:.6e}\nPSNR  {:.3f} dB\n", found.mse, found.psnr_db);
  out += std::isnan(found.ssim) ? "SSIM  none: a side is below 11 pixels\n" : fmt::format("SSIM  {:.6f}\n", found.ssim);
  if (found.hdr_relative_mse) out += fmt::format("HDR relative MSE  {:.6e}\n", *found.hdr_relative_mse);
  out += fmt::format("FLIP  {}  at {:.2f} pixels per degree\n", pooled_line(found.flip), options.pixels_per_degree);
  if (found.hdr_flip)
    out += fmt::format("HDR-FLIP  {}  over {} exposures, {:.4f} to {:.4f} stops\n", pooled_line(found.hdr_flip->error),
                       found.hdr_flip->exposures, found.hdr_flip->start, found.hdr_flip->stop);
  if (found.alpha_mse)
    out += fmt::format("alpha MSE  {:.6e}, {} of {} pixels differ\n", *found.alpha_mse, found.alpha_differing_pixels,
                       pixels);
  return out;
}

int compare(const CompareOptions& options) {
  const replay::ImageFile reference = replay::read_image_file(options.reference, options.layer);
  const replay::ImageFile test = replay::read_image_file(options.test, options.layer);
  const replay::Comparison found =
      replay::compare_images(reference, test, {.pixels_per_degree = options.pixels_per_degree});
  if (!options.error_map.empty()) {
    const replay::Image& map = found.hdr_flip ? found.hdr_flip->error.map : found.flip.map;
    write_file_atomically(options.error_map,
                          replay::encode_png(replay::colour_values(map, 1, replay::ColourMap::magma)));
  }
  std::cout << (options.as_json ? json_text(to_json(options, reference, test, found), 1) + "\n"
                                : to_text(options, reference, test, found));
  return 0;
}

struct AdviseOptions {
  std::string results;
  replay::ErrorBudget budget;
  bool as_json = false;
};

int advise(const AdviseOptions& options) {
  const replay::Advice advice = replay::advise(replay::read_results(options.results), options.budget);
  std::cout << (options.as_json ? json_text(to_json(advice), 1) + "\n" : to_text(advice));
  return advice.within > 0 ? 0 : 1;
}

}  // namespace

void add_measure_verbs(CLI::App& app, std::function<int()>& action) {
  const auto compare_options = std::make_shared<CompareOptions>();
  CLI::App* const compare_verb =
      app.add_subcommand("compare", "MSE, PSNR, SSIM and FLIP of two images; HDR-FLIP of two linear ones");
  compare_verb->add_option("reference", compare_options->reference, "Image that is right")->required();
  compare_verb->add_option("test", compare_options->test, "Image to compare with it")->required();
  compare_verb->add_option("--pixels-per-degree", compare_options->pixels_per_degree,
                           "Viewing conditions of FLIP; default: a 0.7 m wide display of 3840 pixels from 0.7 m");
  compare_verb->add_option("--error-map", compare_options->error_map,
                           "Write FLIP's map as a PNG; of two linear images (EXR, HDR) that of HDR-FLIP");
  compare_verb->add_option("--layer", compare_options->layer,
                           "Layer or part of OpenEXR files to compare; needed where several have colours");
  compare_verb->add_flag("--json", compare_options->as_json, "One JSON document");
  compare_verb->callback(
      [compare_options, &action] { action = [compare_options] { return compare(*compare_options); }; });

  const auto advise_options = std::make_shared<AdviseOptions>();
  CLI::App* const advise_verb = app.add_subcommand(
      "advise", "Cheapest technique and parameters within an error budget; exit code 1 when none is");
  advise_verb->add_option("results", advise_options->results, "results.json of a replay")->required();
  advise_verb->add_option("--max-flip", advise_options->budget.max_flip, "Largest mean FLIP of any frame");
  advise_verb->add_option("--max-mse", advise_options->budget.max_mse, "Largest MSE of any frame");
  advise_verb->add_flag("--json", advise_options->as_json, "One JSON document");
  advise_verb->callback([advise_options, &action] { action = [advise_options] { return advise(*advise_options); }; });
}

}  // namespace subpixel::cli
