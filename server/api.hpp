// The HTTP API (docs/http_api.md) and the viewer's files.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "server/access.hpp"
#include "server/capture_import.hpp"
#include "server/capture_inspection.hpp"
#include "server/http_server.hpp"
#include "server/job_queue.hpp"
#include "server/metrics.hpp"
#include "server/nightly/night_store.hpp"
#include "server/own_names.hpp"
#include "server/routes.hpp"
#include "server/run_events.hpp"
#include "server/service.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

class Api {
 public:
  // All arguments outlive the API.
  Api(const ServiceOptions& options, const DataFolder& folder, Store& store, RunEvents& events, JobQueue& queue);

  // Sets every route, limit and header of `http`.
  void route(HttpServer& http);
  // Answers until `http` is shut down.
  void serve(HttpServer& http);
  // Ends inspections of uploads that are under way.
  void stop() { stop_.request_stop(); }

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  // api.cpp
  void dispatch(const Request& request, Response& response) const;
  // What is refused before the body, whoever would answer.
  void admit(const Request& request);
  void check_request(const Request& request) const;
  void check_origin(const Request& request) const;
  void answered(const Request& request, const Response& response);
  // api_state.cpp
  void route_state(Routes& routes);
  void get_health(Response& response) const;
  void get_readiness(Response& response);
  std::string store_metrics() const;
  // api_access.cpp
  void route_access(Routes& routes);
  void post_sign_in(const Request& request, Response& response);
  // api_captures.cpp
  void route_captures(Routes& routes);
  void list_captures(const Request& request, Response& response) const;
  void get_capture(const std::string& hash, Response& response) const;
  void post_capture(const Request& request, Response& response);
  // The capture made of an upload that is a model or a frame.
  std::unique_ptr<CaptureImport> import_upload(const Upload& upload, const std::string& kind, const std::string& name);
  void delete_capture(const std::string& hash, Response& response);
  void send_capture_file(const Request& request, const std::string& hash, Response& response) const;
  void send_blob(const Request& request, const std::string& hash, Response& response) const;
  void send_story(const Request& request, const std::string& hash, Response& response);
  nlohmann::json ask_about_pixels(const std::string& hash, const Question& question);
  void send_frame_view(const Request& request, const std::string& hash, Response& response);
  void post_tags(const std::string& hash, const Request& request, Response& response);
  // api_runs.cpp
  void route_runs(Routes& routes);
  void send_results(const RunRecord& run, bool as_csv, Response& response) const;
  void post_run(const Request& request, Response& response);
  // The newest run with the same request that has not failed or been cancelled.
  std::optional<RunRecord> equal_run(const std::string& capture, const replay::ReplayOptions& options) const;
  void list_runs(const Request& request, Response& response) const;
  void cancel_run(std::int64_t id, Response& response);
  void send_events(std::int64_t id, const Request& request, Response& response);
  std::optional<News> run_news(std::int64_t id, std::int64_t last_seen) const;
  void send_plots(const Request& request, const std::string& kind, Response& response) const;
  void send_advice(const Request& request, Response& response) const;
  replay::Results measured(const RunRecord& run) const;
  nlohmann::json run_json(const RunRecord& run) const;
  RunRecord find_run(const std::string& id) const;
  // api_nights.cpp
  void route_nights(Routes& routes);
  void route_trends(Routes& routes);
  void send_trends(const Request& request, bool csv, Response& response) const;
  void send_summary(const NightRecord& night, bool markdown, Response& response) const;
  void list_nights(const Request& request, Response& response) const;
  void send_cell(const NightRecord& night, std::int64_t cell, Response& response) const;
  void post_baseline(const Request& request, Response& response);
  NightRecord find_night(const std::string& id) const;

  const ServiceOptions& options_;
  const DataFolder& folder_;
  Store& store_;
  NightStore nights_;
  RunEvents& events_;
  JobQueue& queue_;
  OwnNames names_;
  Access access_;
  Routes routes_;
  Metrics metrics_;
  std::stop_source stop_;
  std::atomic<std::size_t> followers_{0};  // clients that follow a run
  std::mutex captures_mutex_;              // a capture's file and its record come and go together
  std::mutex imports_mutex_;               // one at a time: each may take gigabytes
  std::atomic<std::size_t> imports_{0};    // and those that wait
  std::mutex story_mutex_;                 // held while a pixel's story is told or a frame is shown
};

// A whole number from the query, `absent` without it. Throws HttpError 400 outside of [minimum, maximum].
std::int64_t query_number(const httplib::Request& request, const std::string& name, std::int64_t minimum,
                          std::int64_t maximum, std::int64_t absent);

// The number in a path, -1 for one that is none.
std::int64_t parse_id(const std::string& text);

// The body of a request that must be JSON; `what` is what it asks for. Throws HttpError 415 for another content type,
// which a page of another site could send unasked, and as Exchange::body() does.
std::string read_json_body(const httplib::Request& request, const std::string& what);

}  // namespace subpixel::server
