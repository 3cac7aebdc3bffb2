// What a technique is: one constant per file in this folder, listed in registry.cpp.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::gpu {
class PassRecorder;
}

namespace subpixel::replay {

struct FrameSetup;

// One named part of a memory layout and its size. Bits, since published formats have fields of 1 to 26 bits.
struct LayoutEntry {
  std::string name;
  double bits_per_pixel = 0;
};

struct MemoryLayout {
  std::vector<LayoutEntry> paper;   // the publication's format
  std::vector<LayoutEntry> fitted;  // only what this scene needs
};

// One map a technique can produce, with what its values mean.
struct MapDescription {
  std::string_view name, title, unit;
  double maximum = 0;  // value shown in the last colour; 0: the samples of the run
};

struct Technique {
  std::string_view name;   // registry name, "msaa"
  std::string_view title;  // for people
  std::string_view paper;  // citation, empty for baselines without one
  Parameters parameters;
  std::vector<MapDescription> maps;
  MemoryLayout (*layout)(const FrameSetup&);
  void (*record)(gpu::PassRecorder&, const FrameSetup&);
};

// All techniques, in the order they are listed to users. The only list there is.
std::span<const Technique* const> techniques();
// Throws UsageError that names the valid ones.
const Technique& find_technique(std::string_view name);
// The registry as JSON: [{name, title, paper, parameters: [{name, kind, doc, unit, minimum, maximum, allowed, choices,
// default}], maps: [{name, title, unit, maximum}]}]
nlohmann::json registry_json();

}  // namespace subpixel::replay
