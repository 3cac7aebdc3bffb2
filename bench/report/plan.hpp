// What the report measures: which scenes at which sizes through which techniques.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::report {

// sweep: every technique with its main parameters, what plots and most claims are made of. size: the main techniques at
// another size. lights: what a publication timed with a number of lights of its own.
enum class RunKind { sweep, size, lights };

// One replay of the first frame of one scene; all ratios are within one.
struct RunPlan {
  RunKind kind = RunKind::sweep;
  std::string scene;  // of `subpixel generate --list`, or "park"
  std::uint32_t width = 0, height = 0;
  std::optional<std::uint32_t> point_lights;  // absent: as recorded
  std::uint32_t reference_samples = 0, repeat = 0;
  std::vector<replay::TechniqueRequest> techniques;  // every parameter filled in

  std::string name() const;  // "grass_640x360", "city_1280x720_lights50": the stored file without its extension
};

struct PlanOptions {
  bool quick = false;                   // two scenes, one small size
  std::vector<std::string> scenes;      // only these; empty: all
  std::uint32_t width = 0, height = 0;  // of the sweeps; 0: 640x360, quick 320x180
  std::string techniques;               // of the sweeps, the command line's syntax; empty: the main sweeps
};

// Throws UsageError for an unknown scene, technique or parameter.
std::vector<RunPlan> make_plan(const PlanOptions& options);

// "streaming S=3", "msaa 16x", "agaa c=2 ndf=sggx": the technique, what its sweep is about, and what is not a default.
std::string setting_name(const std::string& technique, const replay::ParameterValues& parameters);

}  // namespace subpixel::report
