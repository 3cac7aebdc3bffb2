// How a request is divided: which frames by which techniques make one task of a cluster.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "server/engine/replay_engine.hpp"

namespace subpixel::server {

struct ShardSize {
  double seconds = 300;              // of work by the times of the last night
  std::uint32_t first_results = 16;  // frame x technique results of a shard where no times are known
};

struct Shard {
  std::size_t request = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // (frame, technique), as in ReplayOptions::skip
  double seconds = 0;                                          // what it should take; 0: not known
};

// Frames `first` to `last` of request number `number`, each result in one shard. Whole frames stay together as long as
// they fit, so that the times a frame's techniques are compared by are of one process; a frame that does not fit is
// divided by techniques. Shards of a request are about equally long.
std::vector<Shard> plan_shards(const ReplayRequest& request, std::size_t number, std::uint32_t first,
                               std::uint32_t last, const ShardSize& size);

// What a shard's job leaves out of frames `first` to `last`: everything else.
std::vector<std::pair<std::uint32_t, std::uint32_t>> left_out(
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs, std::uint32_t first, std::uint32_t last,
    std::size_t techniques);

}  // namespace subpixel::server
