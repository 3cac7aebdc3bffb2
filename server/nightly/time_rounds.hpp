// The rounds of times of a night: how many the machine's noise asks for, measured on this machine in processes that do
// nothing else, spread over the night. What they mean is time_test.hpp's.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/engine/replay_engine.hpp"
#include "server/nightly/config.hpp"
#include "server/nightly/planned_capture.hpp"

namespace subpixel::server {

class TimeRounds {
 public:
  using RequestFor = std::function<ReplayRequest(const PlannedCapture&)>;

  // All of them must outlive this. `here` replays on this machine, whatever replays the night: times of one night are
  // compared with those of others. `say` takes one line for people.
  TimeRounds(const std::vector<PlannedCapture>& planned, const GateOptions& gates, ReplayEngine& here,
             RequestFor request_for, std::function<void(const std::string& line)> say)
      : planned_(planned), gates_(gates), here_(here), request_for_(std::move(request_for)), say_(std::move(say)) {}

  // Measures how much the ratio of msaa to noaa varies, in the first capture that has both, and says it in
  // facts["noise"] beside the machine's load; the rounds of every cell follow from it.
  void measure_noise(nlohmann::json& facts);
  // Adds rounds to the cells of a night that were measured. `judge` judges the night with them; cells that then look
  // slower than in `baseline` (may be null) are measured again and judged again.
  void measure(NightRecord& night, const NightRecord* baseline, const std::function<void()>& judge);

 private:
  // What a round measures. Where the device is the processor, the time of all its threads: a busy machine makes them
  // wait, which this does not count, and what it does count is the work.
  enum class Measure { device_time, processor_time };
  using Cells = std::map<std::uint32_t, std::vector<NightCell*>>;  // by capture

  static double span_of_least(const NightCell& cell, Measure measure);
  static void add_round(NightCell& cell, const std::vector<NightCell>& round, Measure measure);
  Cells worth_timing(NightRecord& night) const;
  void add_rounds(const Cells& wanted, std::uint32_t rounds);
  // Rounds of a capture by some of its techniques; each one cells with frames, in the techniques' order.
  std::vector<std::vector<NightCell>> time_capture(std::uint32_t capture, const std::set<std::string>& techniques,
                                                   std::uint32_t rounds);
  // Worth more rounds: above what is allowed by the medians.
  bool looks_slower(const NightCell& cell, const NightRecord& night, const NightRecord& baseline) const;

  const std::vector<PlannedCapture>& planned_;
  const GateOptions& gates_;
  ReplayEngine& here_;
  RequestFor request_for_;
  std::function<void(const std::string& line)> say_;
  std::uint32_t rounds_ = 4;  // of every cell, as long as no noise was measured
  Measure measure_ = Measure::device_time;
};

}  // namespace subpixel::server
