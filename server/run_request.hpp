// The body of POST /api/runs, checked against the registry and the capture it names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "replay/results/worker_protocol.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

struct RunRequest {
  std::string capture;            // content hash
  replay::ReplayOptions options;  // every parameter filled in; `frames` as given
  QueuePlace place;               // its submitter is not in the body
};

// Throws InputError (with line and column for broken JSON, with the field's path otherwise) or UsageError, which names
// the valid techniques, parameters and ranges.
RunRequest parse_run_request(std::string_view body);

// `options` with its frames checked against the capture's count (all of them when not given). Returns how many results
// the run will have. Throws InputError.
std::uint64_t resolve_frames(replay::ReplayOptions& options, std::uint32_t frame_count);

// What the thumbnail of a capture is rendered with.
replay::ReplayOptions thumbnail_options();

}  // namespace subpixel::server
