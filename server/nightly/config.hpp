// What a night replays and how it is judged: the JSON of `subpixel nightly --config FILE` (docs/nightly.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "replay/results/worker_protocol.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::server {

enum class SourceKind { path, scene, tag };

struct CaptureSource {
  SourceKind kind = SourceKind::path;
  std::string name;            // of the row; for a tag the stored captures' own names are used
  std::filesystem::path path;  // kind path
  std::string scene;           // kind scene
  capture::GenerateOptions generate;
  std::string tag;                // kind tag
  replay::ReplayOptions options;  // techniques with every parameter filled in
};

// A metric fails when it is above `limit`, or above the baseline's by more than `absolute` plus `relative` of it.
struct ErrorBound {
  std::optional<double> limit;
  double absolute = 0, relative = 0;
};

struct GateOptions {
  // Equal to the baseline, on the same driver, driver version and CPU model.
  bool memory = true, shading = true, counters = true, images = true;
  // On another machine: the share and, for what is counted, the number by which memory, shadings and counters may
  // differ, the mean square difference of the images, and the share that errors may rise beyond their bounds.
  double across_relative = 0.01, across_absolute = 8, across_image_mse = 1e-4, across_error = 0.5;
  std::map<std::string, ErrorBound> error;  // by the metric's name in results.json
  bool time = true;
  double time_slower = 0.5;        // share by which the ratios to msaa and noaa may rise, beyond both nights' spreads
  double time_minimum_ms = 5;      // of a cell; below, the clock says more about the machine than about the technique
  std::uint32_t time_confirm = 2;  // times a slower cell is measured again before it fails
};

struct NightlyConfig {
  std::string name;
  std::optional<std::filesystem::path> data;
  std::string baseline;
  std::vector<CaptureSource> captures;
  GateOptions gates;
  std::uint32_t keep = 0;   // newest nights of this name that are kept; 0: all
  nlohmann::json document;  // as read
};

// `folder` is what relative paths start from. Throws InputError with line and column for broken JSON, with the field's
// path for a missing, unknown or wrong field.
NightlyConfig parse_nightly_config(std::string_view text, const std::filesystem::path& folder);

// The same of a file, whose name stands first in every message.
NightlyConfig read_nightly_config(const std::filesystem::path& file);

}  // namespace subpixel::server
