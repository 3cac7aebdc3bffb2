// Captures that somebody leaves in a folder come into the store with a tag, and what a tag may hold is kept to its
// limits.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/job_queue.hpp"
#include "server/nightly/config.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// Takes every *.spcap of the folder that nobody has written to for its `quiet_s`, oldest first: checked by a process of
// its own, copied, tagged. Its file stays; one that is stored already only gets the tag. Returns a line for each that
// was taken or refused.
std::vector<std::string> take_captures(const WatchedFolder& watched, const DataFolder& folder, Store& store,
                                       const WorkerOptions& worker);

// Deletes captures of a tag, oldest first, beyond its number and its bytes, with their files. Its runs go with
// it; one that has other tags, or a run that is not over, only loses the tag. Returns a line for each.
std::vector<std::string> keep_tag_limits(const TagLimit& limit, const DataFolder& folder, Store& store);

}  // namespace subpixel::server
