// How a replay in a process of its own talks to whoever started it: one JSON document per line on standard output.
//   in:  `subpixel worker --job FILE`; FILE is the JSON form of ReplayJob.
//   out: {"type":"progress","stage":"replay","done":3,"total":12,"detail":"frame 1 msaa"}
//        {"type":"head","head":{ResultsHead}}                      once, before the first result, and again at the end
//        {"type":"result","ordinal":1,"result":{FrameResult}}      as each is measured; images are file names in
//        `out_dir`, `ordinal` is the place of its technique in the job's list
//        {"type":"error","message":"what: why: where","exit":3}    then exits with that code;
//        70 (base/failure.hpp) is a mistake of ours, and the message asks for a report
//        {"type":"done"}
// Every file a line names is complete on disk before the line is written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::replay {

struct ReplayOptions {
  std::vector<TechniqueRequest> techniques;
  std::uint32_t samples = 8;                                      // for techniques whose `samples` is not given
  std::optional<std::pair<std::uint32_t, std::uint32_t>> frames;  // inclusive range; all when absent
  std::uint32_t width = 0, height = 0;                            // 0: as recorded
  std::uint32_t repeat = 3;
  std::uint32_t reference_samples = 512;      // 0: no reference, no error
  std::optional<std::uint32_t> point_lights;  // use this many (extra ones are placed in the scene); absent: as recorded
  // Every shading point evaluates all of them, also those out of whose range it lies: the same bits, later.
  bool every_light = false;
  // That a frame's passes may hold at a time; a frame that needs more is drawn in bands, the same bits. 0: no limit.
  std::uint32_t memory_mib = 0;
  // Times without images, maps, shading counts or errors: every technique of a frame in turn, and all of them again,
  // `rounds` times. 0: the whole replay. Each round reports its results as a replay does.
  std::uint32_t rounds = 0;
  // Frame x technique results to leave out because they are stored already: "frame/index in `techniques`".
  std::vector<std::pair<std::uint32_t, std::uint32_t>> skip;
  // No technique is replayed: the references of what is asked for come into the cache, and no result comes out.
  bool references_only = false;
};

// The frames, both included, that are asked for of a capture with `frame_count` of them: all where none are named,
// nothing where it does not have them.
std::optional<std::pair<std::uint32_t, std::uint32_t>> frames_of(const ReplayOptions& options, std::size_t frame_count);

struct ReplayJob {
  std::filesystem::path capture;
  std::filesystem::path out_dir;    // images and maps go here
  std::filesystem::path cache_dir;  // references by content hash
  ReplayOptions options;
};

nlohmann::json to_json(const ReplayJob& job);
ReplayJob replay_job_from_json(const nlohmann::json& json);

}  // namespace subpixel::replay
