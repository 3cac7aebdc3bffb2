// Has a capture read and checked by a process of its own: a hostile file ends that process, never the server.
#pragma once

#include <filesystem>

#include "process/child_process.hpp"
#include "server/job_queue.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// Runs `program info FILE --json` and returns the fields of its summary. Name, hash, size and time are left to the
// caller. Throws HttpError 422 with the reader's message when the file is no valid capture.
CaptureRecord inspect_capture(const std::filesystem::path& file, const WorkerOptions& worker, std::stop_token stop);

}  // namespace subpixel::server
