// What nodes and the machine that divides the work say to each other, as files of a folder that all of them see. Every
// file is complete on the disk before it has its name, and what names it by its hash says what must be in it, so a half
// of one never counts. Both sides read with distrust: files may be damaged, or another's.
//
//   tasks/ARRAY-INDEX.json          what a task of an array does: ShardTask
//   blobs/HH/HASH                   an image's bytes, by content hash; HH are its first two digits
//   results/SHARD/F-T.HASH.json     one result, of frame F by technique T, its images named by hash
//   results/SHARD/end.HASH.json     how the shard's worker ended
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/engine/replay_engine.hpp"

namespace subpixel::server {

// NOLINTNEXTLINE(bugprone-exception-escape): moving JSON is declared noexcept
struct ShardTask {
  replay::ReplayJob job;  // without out_dir, which is the node's own
  std::filesystem::path results, blobs;
  std::filesystem::path worker;
  std::uint64_t silence_s = 600;
};
nlohmann::json to_json(const ShardTask& task);
// Throws InputError.
ShardTask read_shard_task(const std::filesystem::path& file);

struct ImageName {
  std::string file, hash;  // the worker's name of it; of its bytes
  std::uint64_t bytes = 0;
};

// NOLINTNEXTLINE(bugprone-exception-escape): moving JSON is declared noexcept
struct ShardResult {
  std::uint32_t ordinal = 0;
  replay::FrameResult result;               // images by the worker's file names
  std::map<std::string, ImageName> images;  // by role
};

struct ShardEnd {
  ReplayEnd end;
  std::string node;
  double seconds = 0;  // of the task, all of it
};

// Writes the bytes unless a file of that hash and size is there, and names them.
ImageName write_blob(const std::filesystem::path& blobs, const std::string& file, const Blob& blob);
// Throws InputError when the file is not there or not what it is named.
Blob read_blob(const std::filesystem::path& blobs, const ImageName& name);
// Both throw InputError when it can't be written.
void write_result(const std::filesystem::path& results, const ShardResult& result);
void write_end(const std::filesystem::path& results, const ShardEnd& end);

// What of a shard is there. Files that are not what they are named, or not of this shard, are deleted and named in
// `refused`.
struct ShardOutcome {
  std::map<std::pair<std::uint32_t, std::uint32_t>, ShardResult> results;  // by frame and technique
  std::optional<ShardEnd> end;
  std::vector<std::string> refused;
};
ShardOutcome read_outcome(const std::filesystem::path& results, const replay::ReplayJob& job,
                          const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs);

// Does what a task says, on a node. Returns when everything is written; throws InputError or DeviceError when it is
// not, so that it has to be done again, perhaps elsewhere.
void run_shard_task(const std::filesystem::path& task_file);

}  // namespace subpixel::server
