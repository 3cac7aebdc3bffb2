// A capture of a night and how it is replayed.
#pragma once

#include <filesystem>

#include "replay/results/worker_protocol.hpp"
#include "server/nightly/night.hpp"

namespace subpixel::server {

struct PlannedCapture {
  NightCapture capture;
  std::filesystem::path path;
  replay::ReplayOptions options;
};

}  // namespace subpixel::server
