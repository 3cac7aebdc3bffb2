#include "server/fuzz/json_doors.hpp"

#include <stdexcept>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "server/capture_inspection.hpp"
#include "server/nightly/config.hpp"
#include "server/run_request.hpp"
#include "server/worker_session.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

enum Door : std::size_t { night_config, worker_line, capture_summary, run_request, results_document };

std::string result_line() {
  replay::FrameResult result;
  result.technique = "noaa";
  result.parameters = {{"shading", "ggx"}};
  result.ms.passes = {{"shade", 2.5}};
  result.shading.histogram = {1, 2, 3};
  result.counters = {{"stored", 5}};
  return json{{"type", "result"}, {"ordinal", 0}, {"result", replay::to_json(result)}}.dump();
}

std::string head_line() {
  replay::ResultsHead head;
  head.driver = "llvmpipe";
  head.outside_parts_s = {{"load", 1.5}};
  head.features = {"alpha"};
  return json{{"type", "head"}, {"head", replay::to_json(head)}}.dump();
}

std::string results_text() {
  replay::Results results;
  results.results.push_back(replay::frame_result_from_json(json::parse(result_line()).at("result")));
  return replay::to_json(results).dump();
}

}  // namespace

struct JsonDoors::State {
  explicit State(const std::filesystem::path& path) : folder(path), store(folder.store()) {
    CaptureRecord capture;
    capture.hash = std::string(32, 'a');
    capture.frame_count = 2;
    capture.summary = json::object();
    store.add_capture(capture);
    start_run();
  }

  void start_run() {
    if (run.id != 0) store.delete_run(run.id);
    replay::ReplayOptions options;
    options.techniques = {{"noaa", {}}, {"msaa", {}}};
    options.frames = {0, 1};
    store.add_run(RunKind::run, std::string(32, 'a'), options, 4);
    run = store.start_next_run().value();
  }

  DataFolder folder;
  Store store;
  RunEvents events{[](std::int64_t) {}};
  RunRecord run;
};

JsonDoors::JsonDoors(const std::filesystem::path& folder) : state_(std::make_unique<State>(folder)) {}

JsonDoors::~JsonDoors() = default;

const std::vector<std::vector<std::string>>& JsonDoors::examples() {
  static const std::vector<std::vector<std::string>> kExamples{
      {R"({"name":"n","techniques":["noaa","msaa:samples=4|8"],"size":[64,32],"repeat":2,"keep":3,"frames":[0,1],)"
       R"("captures":[{"scene":"streaming_*"},{"path":"a.spcap","name":"b"},{"tag":"t","also":"fxaa"}],)"
       R"("gates":{"images":false,"error":{"mse":{"limit":0.1,"relative":0.02}},"time":{"slower":0.25,"alarm":0.02},)"
       R"("across":{"relative":0.05}}})",
       R"({"name":"all","techniques":"all","captures":[{"scene":"cube","seed":3}],"data":"d","gates":{"time":false}})"},
      {head_line(), result_line(), R"({"type":"progress","stage":"replay","done":1,"total":2.5,"detail":"x"})",
       R"({"type":"error","message":"m"})", R"({"type":"done"})"},
      {R"({"title":"t","frame_count":2,"width":64,"height":32,"triangles":12,"features":["alpha"],"frames":[[1]]})"},
      {R"({"capture":"a","techniques":["msaa:samples=4|8",{"technique":"noaa","parameters":{"shading":"ggx"}}],)"
       R"("samples":8,"frames":[0,1],"width":32,"height":18,"repeat":1,"reference_samples":64,"point_lights":2})"},
      {results_text()}};
  return kExamples;
}

JsonDoors::Outcome JsonDoors::take(std::size_t which, std::string_view text) {
  State& s = *state_;
  try {
    switch (static_cast<Door>(which)) {
      case night_config:
        parse_nightly_config(text, s.folder.root());
        break;
      case worker_line: {
        WorkerSession session(s.store, s.events, s.run, s.folder.uploads(), {});
        if (!session.take_line(text)) return Outcome::refused;
        if (!s.store.results(s.run.id).empty()) s.start_run();  // a run has a result once
        break;
      }
      case capture_summary:
        if (json::parse(parse_capture_summary(text).summary.dump()) != parse_json_document(text, "summary", "it"))
          throw std::logic_error("a summary changes when it is written");
        break;
      case run_request: {
        replay::ReplayOptions options = parse_run_request(text).options;
        resolve_frames(options, 2);
        break;
      }
      case results_document: {
        const json once = replay::to_json(replay::results_from_json(parse_json_document(text, "results", "it")));
        if (replay::to_json(replay::results_from_json(once)) != once)
          throw std::logic_error("results change when they are written");
        break;
      }
      default:
        throw std::logic_error("there is no such door");
    }
  } catch (const Error&) {
    return Outcome::refused;
  }
  return Outcome::taken;
}

}  // namespace subpixel::server
