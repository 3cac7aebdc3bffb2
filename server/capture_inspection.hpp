// Has a capture read and checked by a process of its own: a hostile file ends that process, never the server.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "process/child_process.hpp"
#include "server/job_queue.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// Runs `program info FILE --json` and returns the fields of its summary. Name, hash, size and time are left to the
// caller. Throws HttpError 422 with the reader's message when the file is no valid capture.
CaptureRecord inspect_capture(const std::filesystem::path& file, const WorkerOptions& worker, std::stop_token stop);

// The same of what that process printed. Throws InputError.
CaptureRecord parse_capture_summary(std::string_view text);

// What `program VERB FILE --json` with `options` prints, one JSON document; `what` begins messages: "the pixel's story
// is not told". Throws HttpError: 400 with the program's message for options it refuses, 422 for a capture it can't
// read or a device that can't do it.
struct Question {
  std::string verb;
  std::vector<std::string> options;
  std::string what;
};
nlohmann::json ask_program(const std::filesystem::path& file, const Question& question, const WorkerOptions& worker,
                           std::stop_token stop);

}  // namespace subpixel::server
