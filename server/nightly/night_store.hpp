// The nights of a store: what they measured, their images, and the nights approved as baselines. Safe to call from any
// thread; throws SqliteError as the store does.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "replay/results/results.hpp"
#include "server/nightly/night.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

struct BaselineRecord {
  std::string name;
  std::int64_t night = 0;
  std::string set_utc;
  std::string who, why;  // empty where it was not said
};

class NightStore {
 public:
  // `store` must outlive this.
  explicit NightStore(Store& store) : store_(store) {}

  // Begins a night and returns its number. `night` gives name, build, configuration and baseline.
  std::int64_t add(const NightRecord& night);
  void add_capture(std::int64_t night, std::uint32_t ordinal, const NightCapture& capture);
  // Stores the cell without frames and returns its number.
  std::int64_t add_cell(std::int64_t night, const NightCell& cell);
  // Stores one measured frame with its images; the returned one names them by hash.
  NightFrame add_frame(std::int64_t cell, const replay::FrameResult& result, const std::map<std::string, Blob>& images);
  // Adds the image of the difference to the baseline and returns its hash.
  std::string add_difference(std::int64_t frame, const Blob& image);
  // Status, gates and time of a cell that is stored.
  void update_cell(const NightCell& cell);
  // What the night says of its machine (NightRecord::facts).
  void set_facts(std::int64_t night, const nlohmann::json& facts);
  void finish(std::int64_t id, NightStatus status, std::string_view reason);
  // Nights that a process left running.
  void interrupt_running(std::string_view reason = "the process ended before the night did");
  // Deletes all but the newest `keep` nights of a name, baselines, and what kept nights were compared with.
  void drop_old(std::string_view name, std::uint32_t keep);
  // With captures and cells; frames only when asked for.
  std::optional<NightRecord> night(std::int64_t id, bool with_frames) const;
  // One cell with its frames.
  std::optional<NightCell> cell(std::int64_t id) const;
  // Newest first, without frames; ids below `before` (0: from the newest).
  std::vector<NightRecord> nights(std::uint32_t limit, std::int64_t before, std::string_view name) const;
  // Finished nights of a name that measured a cell, newest first; each with that capture and that cell only, its frames
  // with it.
  std::vector<NightRecord> nights_of_cell(std::string_view name, std::string_view capture, std::string_view technique,
                                          std::uint32_t limit) const;
  // Names a finished night; false when there is none of that number.
  bool set_baseline(std::string_view name, std::int64_t night, std::string_view who = "", std::string_view why = "");
  std::vector<BaselineRecord> baselines() const;
  // Every approval there was, newest first, of one name or of all (empty).
  std::vector<BaselineRecord> approvals(std::string_view name) const;

 private:
  Store& store_;
};

}  // namespace subpixel::server
