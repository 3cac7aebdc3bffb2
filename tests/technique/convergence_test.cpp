// Two rasterisers agree: our msaa tends to the reference, which the device's own rasteriser draws. The bounds are 1.5
// times the mean squared errors of display values measured at 160x90 against 512 samples.
#include <gtest/gtest.h>
#include <unistd.h>

#include "replay/results/results_file.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

struct Bound {
  const char* scene;
  double mse_at_64;
  const char* alpha = "to_coverage";
};

void PrintTo(const Bound& bound, std::ostream* out) {
  *out << bound.scene << " " << bound.alpha;
}

class Convergence : public testing::TestWithParam<Bound> {};

TEST_P(Convergence, OfMsaaToTheReference) {
  const auto& [scene, bound, alpha] = GetParam();
  const auto folder = std::filesystem::temp_directory_path() / ("subpixel-convergence-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const bool park = std::string(scene) == "park_small";
  const std::string make = park ? "import '" SUBPIXEL_SOURCE_DIR "/scenes/described/park_small.json' scene.spcap"
                                : std::string("generate ") + scene + " scene.spcap";
  const Finished made = run_binary(make + " --frames 1 --size 160x90", folder);
  if (park && made.error.find("sweethome3d") != std::string::npos)
    GTEST_SKIP() << "the models of sweethome3d-furniture are not installed";
  ASSERT_EQ(made.code, 0) << made.error;
  const Finished replayed = run_binary(
      std::string("replay scene.spcap --repeat 1 --out out --techniques msaa:alpha=") + alpha + ":samples='4|16|64'",
      folder);
  ASSERT_EQ(replayed.code, 0) << replayed.error;
  double before = 1;
  for (const auto& result : replay::read_results(folder / "out" / "results.json").results) {
    std::printf("%-12s %-12s %2u samples: MSE %.2e\n", scene, alpha, result.samples, result.error.mse);
    EXPECT_LT(result.error.mse, before);
    EXPECT_EQ(result.counters.at("invalid_pixels"), 0u);
    before = result.error.mse;
  }
  EXPECT_LT(before, bound);
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Convergence,
                         testing::Values(Bound{"grass", 9.5e-5}, Bound{"city", 9.6e-5}, Bound{"park_small", 2.4e-5},
                                         Bound{"foliage", 1.9e-3}, Bound{"foliage", 1.2e-4, "per_sample"}));

}  // namespace
}  // namespace subpixel::tests
