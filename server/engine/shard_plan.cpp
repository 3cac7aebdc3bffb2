#include "server/engine/shard_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace subpixel::server {

std::vector<Shard> plan_shards(const ReplayRequest& request, std::size_t number, std::uint32_t first,
                               std::uint32_t last, const ShardSize& size) {
  const auto frames = static_cast<std::size_t>(last) - first + 1;
  const auto techniques = static_cast<std::uint32_t>(request.job.options.techniques.size());
  const bool known = request.technique_seconds.size() == techniques;
  // Of each technique on one frame, in shards.
  std::vector<double> costs(techniques, 1.0 / std::max(size.first_results, 1u));
  if (known) {
    for (std::size_t i = 0; i < techniques; ++i)
      costs[i] = request.technique_seconds[i] / static_cast<double>(frames) / std::max(size.seconds, 1e-3);
  }
  const double frame_cost = std::accumulate(costs.begin(), costs.end(), 0.0);
  // Times may be anything: clamped before they are numbers of shards.
  const auto pieces = [](double cost, std::size_t most) {
    return static_cast<std::size_t>(std::clamp(std::ceil(cost - 1e-9), 1.0, static_cast<double>(most)));
  };
  std::vector<Shard> shards;
  const auto add = [&](std::uint32_t begin, std::uint32_t end, std::uint32_t low, std::uint32_t high) {
    Shard shard{number, {}, 0};
    for (std::uint32_t frame = begin; frame < end; ++frame) {
      for (std::uint32_t technique = low; technique < high; ++technique) {
        shard.pairs.emplace_back(frame, technique);
        if (known) shard.seconds += costs[technique] * size.seconds;
      }
    }
    shards.push_back(std::move(shard));
  };
  const bool fits = frame_cost <= 1;
  const std::size_t per_shard = fits ? static_cast<std::size_t>(1 / std::max(frame_cost, 1e-9) + 1e-9) : 1;
  const std::size_t groups = (frames + per_shard - 1) / std::max<std::size_t>(per_shard, 1);
  for (std::size_t group = 0; group < groups; ++group) {
    const auto begin = static_cast<std::uint32_t>(first + frames * group / groups);
    const auto end = static_cast<std::uint32_t>(first + frames * (group + 1) / groups);
    const std::size_t parts = fits ? 1 : pieces(frame_cost, techniques);
    std::uint32_t low = 0;
    double done = 0;
    for (std::size_t part = 1; part <= parts && low < techniques; ++part) {
      std::uint32_t high = low;
      do {
        done += costs[high++];
      } while (high < techniques && (part == parts || done + costs[high] / 2 <= frame_cost * static_cast<double>(part) /
                                                                                    static_cast<double>(parts)));
      add(begin, end, low, high);
      low = high;
    }
  }
  return shards;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> left_out(
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs, std::uint32_t first, std::uint32_t last,
    std::size_t techniques) {
  const std::set<std::pair<std::uint32_t, std::uint32_t>> kept(pairs.begin(), pairs.end());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> skip;
  for (std::uint64_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t technique = 0; technique < techniques; ++technique) {
      const std::pair pair{static_cast<std::uint32_t>(frame), technique};
      if (!kept.contains(pair)) skip.push_back(pair);
    }
  }
  return skip;
}

}  // namespace subpixel::server
