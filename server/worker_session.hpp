// What the server makes of one worker's lines (replay/results/worker_protocol.hpp): results and their images go to the
// store, progress to the waiting streams. Every line is checked; the worker is a process that may have gone wrong.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "server/engine/worker_place.hpp"
#include "server/run_events.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

class WorkerSession {
 public:
  // `out_dir` is where the worker's images are; `stored` the results it was told to skip.
  WorkerSession(Store& store, RunEvents& events, const RunRecord& run, std::filesystem::path out_dir,
                const std::vector<std::pair<std::uint32_t, std::uint32_t>>& stored);

  // One line of the worker. False when the worker has to be ended: refusal() says why. Throws SqliteError.
  bool take_line(std::string_view line);

  const std::string& refusal() const { return refusal_; }     // why a line was refused
  const std::string& worker_error() const { return error_; }  // the worker's own "error" line
  const WorkerPlace& place() const { return place_; }
  bool done() const { return done_; }  // the worker said "done"
  bool complete() const { return taken_.size() == run_.expected_results; }

 private:
  void take_document(const nlohmann::json& document);
  void take_result(std::uint32_t ordinal, const nlohmann::json& json);
  void take_progress(const nlohmann::json& document);
  void require_wanted(std::uint32_t ordinal, const replay::FrameResult& result) const;

  Store& store_;
  RunEvents& events_;
  const RunRecord& run_;
  std::filesystem::path out_dir_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> taken_;  // (frame, technique ordinal) stored so far
  std::uint64_t lines_ = 0;
  std::string refusal_, error_;
  WorkerPlace place_;
  bool done_ = false;
};

}  // namespace subpixel::server
