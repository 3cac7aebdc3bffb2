// What a replay measured: plain structs and their JSON form, which the command line, the store, the nightly gate and
// the web all read. Field names and units are the contract of results.json.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace subpixel::replay {

// Parameter values by name, as given plus the defaults that filled the rest. Numbers are JSON numbers, choices strings.
using ParameterValues = std::map<std::string, nlohmann::json>;

struct PassTime {
  std::string name;
  double median_ms = 0;
};

struct Timing {
  double total_ms = 0;           // sum of the pass medians
  std::vector<PassTime> passes;  // warm medians in execution order
  double spread_ms = 0;          // largest minus smallest total over the repeats
  double cold_ms = 0;            // first run, which pays the pipeline compilation
  // The least of the warm runs, which what else the machine does touches least: ms of all passes, processor time of all
  // threads, and instructions in user space, 0 where they are not counted.
  double least_ms = 0, processor_ms = 0;
  std::uint64_t instructions = 0;
};

struct Memory {
  // The publication's format.
  double paper_bytes_per_pixel = 0;
  std::uint64_t paper_bytes = 0;
  // What this implementation's passes keep over the frame, measured: in formats fitted to what the scene needs, with
  // triangle numbers, lists of fragments and sums; without the scene, its triangle records, the images that come out
  // and the maps. The ordered and the list form of one technique differ in it, as in their times.
  double fitted_bytes_per_pixel = 0;
  std::uint64_t fitted_bytes = 0;
  std::uint64_t allocated_bytes = 0;  // the same with the images that come out and the maps
  // Within a budget (`memory` of the replay): bands of rows that the frame was drawn in, of which the two above are the
  // largest one's, and the most that passes held at a time; 0 in results of before there were budgets.
  std::uint32_t bands = 0;
  std::uint64_t peak_bytes = 0;
};

struct Shading {
  std::uint64_t executions = 0;  // lighting executions in the frame
  double per_pixel_mean = 0;
  std::vector<std::uint64_t> histogram;  // [k]: pixels with k executions
  // Executions that a processor pays whose 32 lanes of 8x4 pixels wait for the pixel with the most: the sum over those
  // groups of that number times their pixels. Crassin et al. 2016, section 5.2, argue at this granularity.
  std::uint64_t group_executions = 0;
  // Fragments each raster pass shades, by its name: of geometry, pixels of which a triangle covers a sample, summed
  // over its triangles and the times they are drawn, before depth and alpha; of a full-screen pass, its pixels.
  std::map<std::string, std::uint64_t> fragments;
};

// Display error is on the sRGB image in [0,1]; a metric that was not measured is NaN in memory and null in JSON.
struct ImageError {
  double mse, psnr_db, flip_mean, flip_p99, flip_max, hdr_rel_mse, flicker;
  ImageError();
};

struct FrameResult {
  std::uint32_t frame = 0;
  std::string technique;
  ParameterValues parameters;
  std::uint32_t samples = 0;
  std::uint32_t width = 0, height = 0;
  Timing ms;
  Memory memory;
  Shading shading;
  ImageError error;
  std::map<std::string, std::uint64_t> counters;
  std::map<std::string, std::string> images;  // role ("image", "error", "shading", ...) -> file name or blob hash
};

struct ResultsHead {
  std::string capture_hash, capture_title;
  std::string driver, driver_version, device, cpu_model;
  std::string build, date_utc;
  std::uint32_t width = 0, height = 0, repeat = 0, reference_samples = 0, point_lights = 0;
  bool every_light = false;  // ReplayOptions
  std::uint64_t triangles_first_frame = 0;
  // The budget of what passes hold, 0: none; after the last result the most bands that a frame was drawn in, and the
  // most that was held.
  std::uint32_t memory_mib = 0, bands = 0;
  std::uint64_t peak_bytes = 0;
  double wall_s = 0, outside_gpu_s = 0;           // whole run, and the part of it not spent in device passes
  std::map<std::string, double> outside_parts_s;  // what that part was spent on
  std::vector<std::string> features;              // what the scene needs, by name
};

struct Results {
  ResultsHead head;
  std::vector<FrameResult> results;
};

// The JSON forms. from_json throws InputError naming the field that is missing or of the wrong type.
nlohmann::json to_json(const FrameResult& result);
nlohmann::json to_json(const ResultsHead& head);
nlohmann::json to_json(const Results& results);
FrameResult frame_result_from_json(const nlohmann::json& json);
ResultsHead results_head_from_json(const nlohmann::json& json);
Results results_from_json(const nlohmann::json& json);

// One line for each result, all columns; RFC 4180.
std::string to_csv(const Results& results);
// A table for a terminal of any width: technique, parameters, bytes per pixel, executions, ms, ratio to msaa, error.
std::string to_table(const Results& results);

}  // namespace subpixel::replay
