// One frame by one technique within the device's budget of memory: whole where that holds it, else in bands of rows,
// one after the other through the same passes, put together on the host. Images, maps and counters are the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "replay/frame/run_frame.hpp"

namespace subpixel::replay {

class BandedFrame {
 public:
  // Nothing else may hold memory of the device's ledger meanwhile.
  BandedFrame(FrameScene& scene, const TechniqueSetting& setting);
  ~BandedFrame();
  BandedFrame(const BandedFrame&) = delete;
  BandedFrame& operator=(const BandedFrame&) = delete;

  // As RecordedFrame::time(); `after_cold` is called for each band. Throws UsageError that names the technique, the
  // budget and the least one that works where bands of the fewest rows do not fit either, or where it cannot be drawn
  // in bands at all.
  Timing time(std::uint32_t repeat, const std::function<void()>& after_cold = {});
  void run();

  // Of what time() or run() left; `fragments`: RecordedFrame::count_fragments().
  Memory memory() const;
  std::map<std::string, std::uint64_t> counters() const;
  std::map<std::string, std::uint64_t> fragments();
  FrameImages images();

 private:
  void draw(std::uint32_t repeat, const std::function<void()>& after_cold);
  bool draw_whole(std::uint32_t repeat, const std::function<void()>& after_cold);
  void draw_bands(std::uint32_t repeat, const std::function<void()>& after_cold);

  FrameScene& scene_;
  TechniqueSetting setting_;
  gpu::MemoryLedger& ledger_;
  const std::uint32_t current_;  // frame
  std::unique_ptr<RecordedFrame> whole_;
  Runs runs_;
  Memory memory_;
  FrameImages images_;
  std::map<std::string, std::uint64_t> counters_, fragments_;
};

}  // namespace subpixel::replay
