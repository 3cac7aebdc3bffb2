// What the report measures: which scenes at which sizes through which techniques.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::report {

// sweep: every technique with its main parameters, what plots are made of and what claims have beside. paper: what a
// publication's claims are judged by, at its own size. lights: what it timed with a number of lights of its own.
// frames: several frames at a small size, for flicker.
enum class RunKind { sweep, paper, lights, frames };

// Two settings of a run whose images are compared with each other instead of with a reference.
struct ImagePair {
  replay::TechniqueRequest test, base;
};
// "streaming S=3 / forward 8x".
std::string pair_name(const ImagePair& pair);

// One replay of the first frames of one scene; all ratios are within one.
struct RunPlan {
  RunKind kind = RunKind::sweep;
  std::string scene;  // of `subpixel generate --list`, or "park"; "grass@0.5": of that density
  std::uint32_t width = 0, height = 0;
  std::optional<std::uint32_t> point_lights;  // absent: as recorded
  bool every_light = false;                   // ReplayOptions; of kind lights, as publications light by all
  std::uint32_t reference_samples = 0, repeat = 0;
  std::vector<replay::TechniqueRequest> techniques;  // every parameter filled in
  std::uint32_t frames = 1;
  std::vector<ImagePair> pairs = {};  // of `techniques`

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
