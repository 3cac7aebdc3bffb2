// One night from its configuration to its verdict: replays every capture in a worker process, stores the results,
// compares them with the baseline.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "process/child_process.hpp"
#include "server/engine/replay_engine.hpp"
#include "server/nightly/config.hpp"
#include "server/nightly/night.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

struct NightOptions {
  std::filesystem::path worker;  // run as `worker worker --job FILE`
  ChildLimits limits;
  std::string commit;                                     // of what is measured; empty: this build's
  std::function<void(const std::string& line)> progress;  // one line for people; may be absent
  ReplayEngine* engine = nullptr;  // where captures are replayed; none: in processes of this machine
};

// The folder is claimed for the night, the store is the folder's. A capture that can't be replayed fails its cells and
// the night goes on. Returns the night as it is stored, with frames. Throws InputError for a full
// disk, and what ends the engine (the night is interrupted then, with that reason).
NightRecord run_night(const NightlyConfig& config, const DataFolder& folder, Store& store, const NightOptions& options);

}  // namespace subpixel::server
