// The client's side of the service: send a capture, start a run, follow it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace subpixel::cli {

struct Submission {
  std::string file, server;
  std::string token_file;  // empty: the environment's SUBPIXEL_TOKEN, if any
  std::string techniques;  // of the command line's form; empty: only send the capture
  std::string frames, size, memory;
  std::optional<std::uint32_t> samples, repeat, reference_samples, point_lights, priority, retries;
  bool every_light = false;
  bool wait = false;
  bool once = false;  // an equal run of the service that has not failed or been cancelled will do
};

// Prints the capture's hash and the run's address; with `wait` also its progress, the table of its
// results as `subpixel replay` prints it, and their address.
// Returns 0. Throws UsageError for what the service finds wrong with the request, InputError when it can't be reached,
// does not take the capture, or the run fails.
int submit(const Submission& submission);

}  // namespace subpixel::cli
