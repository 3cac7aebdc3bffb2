#include "server/worker_session.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/store/worker_files.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxProgressText = 200;

}  // namespace

WorkerSession::WorkerSession(Store& store, RunEvents& events, const RunRecord& run, std::filesystem::path out_dir,
                             const std::vector<std::pair<std::uint32_t, std::uint32_t>>& stored)
    : store_(store), events_(events), run_(run), out_dir_(std::move(out_dir)), taken_(stored.begin(), stored.end()) {}

bool WorkerSession::take_line(std::string_view line) {
  ++lines_;
  try {
    take_document(parse_json_document(line, "worker message", "the line"));
    return true;
  } catch (const json::exception& error) {
    refusal_ = fmt::format("the worker's line {} is no valid message: {}", lines_, printable(error.what(), 300));
  } catch (const Error& error) {
    refusal_ = fmt::format("the worker's line {} was refused: {}", lines_, printable(error.what(), 300));
  }
  return false;
}

void WorkerSession::take_document(const json& document) {
  const JsonField message(document, "worker message");
  const std::string type = message.member("type").text();
  if (done_) throw InputError("worker message", "it follows \"done\"", type);
  if (type == "progress") {
    take_progress(document);
  } else if (type == "head") {
    // Through the struct, so that what is stored has the form everyone reads.
    store_.set_head(run_.id, replay::to_json(replay::results_head_from_json(message.member("head").raw())));
  } else if (type == "result") {
    take_result(message.member("ordinal").u32(), message.member("result").raw());
  } else if (type == "error") {
    error_ = printable(message.member("message").text(), 2000);
  } else if (type == "done") {
    done_ = true;
  } else {
    message.member("type").fail("unknown type " + printable(type, 40));
  }
}

void WorkerSession::take_progress(const json& document) {
  const JsonField message(document, "worker message");
  json progress = {
      {"stage", printable(message.member("stage").text(), kMaxProgressText)},
      {"done", message.member("done").number()},
      {"total", message.member("total").number()},
      {"detail", message.has("detail") ? printable(message.member("detail").text(), kMaxProgressText) : ""}};
  place_.progress(progress.at("stage").get_ref<const std::string&>(),
                  progress.at("detail").get_ref<const std::string&>());
  events_.progress(run_.id, std::move(progress));
}

void WorkerSession::take_result(std::uint32_t ordinal, const json& document) {
  const replay::FrameResult result = replay::frame_result_from_json(document);
  require_wanted(ordinal, result);
  const std::map<std::string, Blob> images = read_worker_images(out_dir_, result);
  store_.add_result(run_.id, ordinal, result, images);
  taken_.emplace(result.frame, ordinal);
  for (const auto& [role, file] : result.images) {
    if (role.starts_with("reference")) continue;  // results of one frame share it
    std::error_code ignored;                      // a file that stays is removed with the job's folder
    std::filesystem::remove(out_dir_ / file, ignored);
  }
  if (run_.kind == RunKind::thumbnail && images.contains("image")) {
    for (const StoredResult& stored : store_.results(run_.id)) {
      store_.set_thumbnail(run_.capture, stored.document.at("images").at("image").get<std::string>());
    }
  }
  events_.changed(run_.id);
}

void WorkerSession::require_wanted(std::uint32_t ordinal, const replay::FrameResult& result) const {
  const auto [first, last] = run_.options.frames.value();
  if (result.frame < first || result.frame > last) {
    throw InputError("worker result", "it is for a frame outside of the run", fmt::format("frame {}", result.frame));
  }
  const auto& techniques = run_.options.techniques;
  if (ordinal >= techniques.size() || techniques[ordinal].technique != result.technique ||
      taken_.contains({result.frame, ordinal})) {
    throw InputError("worker result", "it is not of this run, or came twice",
                     fmt::format("frame {} {}", result.frame, printable(result.technique, 60)));
  }
}

}  // namespace subpixel::server
