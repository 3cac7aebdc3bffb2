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
  std::string tag;                 // kind tag
  bool against_yesterday = false;  // kind tag: its newest capture, compared with the one before (against.hpp)
  replay::ReplayOptions options;   // techniques with every parameter filled in
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
  // Shares by which today's capture may be above yesterday's: draws, triangles, materials, memory, executions, error.
  std::map<std::string, double> against{{"draws", 0.1},  {"triangles", 0.1},  {"materials", 0.1},
                                        {"memory", 0.1}, {"executions", 0.1}, {"error", 0.1}};
  bool time = true;
  double time_slower = 0.03;        // share by which the ratios to msaa and noaa may rise before a test can fail
  double time_minimum_ms = 5;       // of a cell; below, the clock says more about the machine than about the technique
  double time_alarm = 0.01;         // false alarms by chance, in nights, of all cells together
  std::uint32_t time_rounds = 48;   // most rounds of a cell in one night
  double instructions_more = 0.02;  // share by which instructions may rise, where they are counted
};

// A folder whose captures are stored with a tag before the night begins.
struct WatchedFolder {
  std::filesystem::path folder;
  std::string tag;
  std::uint32_t quiet_s = 10;  // since a file was written to
};

// What a tag may hold; 0: any number.
struct TagLimit {
  std::string tag;
  std::uint32_t keep = 0;
  std::uint64_t bytes = 0;
};

struct Webhook {
  std::string url;
  std::string secret_variable;  // of the environment, with the key that signs; empty: not signed
};

// Who is told how a night ended.
struct NoticeOptions {
  std::vector<Webhook> webhooks;
  std::uint32_t attempts = 5;
  std::vector<std::string> mail_to;
  std::string mail_from;
  std::string sendmail = "/usr/sbin/sendmail";
  bool only_failed = false;
};

struct NightlyConfig {
  std::string name;
  std::optional<std::filesystem::path> data;
  std::string baseline;
  std::vector<CaptureSource> captures;
  GateOptions gates;
  std::vector<WatchedFolder> watched;
  std::vector<TagLimit> tag_limits;
  NoticeOptions notices;
  std::filesystem::path folder;  // what its paths start from
  std::uint32_t keep = 0;        // newest nights of this name that are kept; 0: all
  nlohmann::json document;       // as read
};

// The gates of a configuration that was read before; the defaults where it has none or they can't be read any more.
GateOptions gates_of(const nlohmann::json& document);

// `folder` is what relative paths start from. Throws InputError with line and column for broken JSON, with the field's
// path for a missing, unknown or wrong field.
NightlyConfig parse_nightly_config(std::string_view text, const std::filesystem::path& folder);

// The same of a file, whose name stands first in every message.
NightlyConfig read_nightly_config(const std::filesystem::path& file);

}  // namespace subpixel::server
