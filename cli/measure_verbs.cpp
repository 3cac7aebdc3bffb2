#include "cli/measure_verbs.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "capture_format/atomic_file.hpp"
#include "replay/measure/advisor.hpp"
#include "replay/measure/flip.hpp"
#include "replay/measure/image.hpp"
#include "replay/measure/maps.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/measure/results_file.hpp"

namespace subpixel::cli {
namespace {

using nlohmann::json;

struct CompareOptions {
  std::string reference, test, error_map;
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

int compare(const CompareOptions& options) {
  const replay::Image reference = replay::read_image(options.reference);
  const replay::Image test = replay::read_image(options.test);
  replay::require_same_shape(reference, test);
  const bool linear = reference.encoding == replay::Encoding::linear && test.encoding == replay::Encoding::linear;
  const replay::Image a = replay::to_display(reference);
  const replay::Image b = replay::to_display(test);
  const double mse = replay::mse(a, b);
  const double ssim = replay::ssim(a, b);
  const replay::FlipOptions viewing{.pixels_per_degree = options.pixels_per_degree};
  const replay::FlipResult flip = replay::flip(a, b, viewing);
  std::optional<replay::HdrFlipResult> hdr;
  if (linear) hdr = replay::hdr_flip(reference, test, viewing);
  const double relative = linear ? replay::hdr_relative_mse(reference, test) : std::nan("");
  if (!options.error_map.empty())
    write_file_atomically(
        options.error_map,
        replay::encode_png(
            replay::colour_values(hdr ? hdr->error.map : flip.map, 1, replay::ColourMap::magma, "FLIP", "").image));
  if (options.as_json) {
    json document = {{"reference", options.reference},
                     {"test", options.test},
                     {"width", a.width},
                     {"height", a.height},
                     {"mse", mse},
                     {"psnr", number(replay::psnr_db(mse))},
                     {"ssim", number(ssim)},
                     {"hdr_rel_mse", number(relative)},
                     {"flip", pooled(flip)}};
    document["flip"]["pixels_per_degree"] = options.pixels_per_degree;
    if (hdr) {
      document["hdr_flip"] = pooled(hdr->error);
      document["hdr_flip"]["start_exposure"] = hdr->start;
      document["hdr_flip"]["stop_exposure"] = hdr->stop;
      document["hdr_flip"]["exposures"] = hdr->exposures;
    }
    std::cout << document.dump(1) << "\n";
    return 0;
  }
  std::cout << fmt::format("size  {}x{}\nMSE   {:.6e}\nPSNR  {:.3f} dB\nSSIM  {:.6f}\n", a.width, a.height, mse,
                           replay::psnr_db(mse), ssim);
  if (linear) std::cout << fmt::format("HDR relative MSE  {:.6e}\n", relative);
  std::cout << fmt::format("FLIP  {}  at {:.2f} pixels per degree\n", pooled_line(flip), options.pixels_per_degree);
  if (hdr)
    std::cout << fmt::format("HDR-FLIP  {}  over {} exposures, {:.4f} to {:.4f} stops\n", pooled_line(hdr->error),
                             hdr->exposures, hdr->start, hdr->stop);
  return 0;
}

struct AdviseOptions {
  std::string results;
  replay::ErrorBudget budget;
  bool as_json = false;
};

int advise(const AdviseOptions& options) {
  const replay::Advice advice = replay::advise(replay::read_results(options.results), options.budget);
  std::cout << (options.as_json ? to_json(advice).dump(1) + "\n" : to_text(advice));
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
