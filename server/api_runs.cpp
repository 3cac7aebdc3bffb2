// Runs, their progress and their results over HTTP.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "base/numbers.hpp"
#include "replay/results/advisor.hpp"
#include "replay/results/plots.hpp"
#include "server/api.hpp"
#include "server/http_error.hpp"
#include "server/request_context.hpp"
#include "server/run_request.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxListedRuns = 200;
constexpr std::uint32_t kResultsAtATime = 32;

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

std::string event_text(std::string_view name, const json& data, std::int64_t id = 0) {
  // The document is one line: JSON escapes line ends.
  const std::string id_line = id > 0 ? fmt::format("id: {}\n", id) : "";
  return fmt::format("{}event: {}\ndata: {}\n\n", id_line, name, data.dump());
}

// How a run stands, in the short form that changes while it runs.
json status_json(const RunRecord& run, const std::optional<json>& progress) {
  return {{"status", to_text(run.status)},
          {"reason", run.reason},
          {"stored_results", run.stored_results},
          {"expected_results", run.expected_results},
          {"progress", progress ? *progress : json(nullptr)}};
}

// Which of `names` the query asks for, the first without it.
std::size_t query_choice(const httplib::Request& request, const std::string& name,
                         std::span<const std::string_view> names) {
  if (!request.has_param(name)) return 0;
  const auto found = std::ranges::find(names, request.get_param_value(name));
  if (found == names.end()) {
    throw HttpError(400, "the query is wrong", fmt::format("expected one of {}", fmt::join(names, ", ")), name);
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<double> query_amount(const httplib::Request& request, const std::string& name) {
  if (!request.has_param(name)) return std::nullopt;
  const auto value = parse_number<double>(request.get_param_value(name));
  if (!value || !(*value >= 0) || !std::isfinite(*value)) {
    throw HttpError(400, "the query is wrong", "expected a number of 0 or more", name);
  }
  return value;
}

}  // namespace

void Api::route_runs(Routes& routes) {
  routes.add({.method = "POST",
              .path = "/api/runs",
              .id = "start_run",
              .meaning = "Starts a run",
              .right = Right::submit,
              .answers = {{201, "Run"}, {200, "Run"}, {400, ""}, {404, ""}, {415, ""}},
              .query = {{"once", R"({"type":"integer","enum":[0,1],"default":0})",
                         "1: answer with an equal run that is queued, running or done"}},
              .body = "RunRequest"},
             [this](const Request& request, Response& response) { post_run(request, response); });
  routes.add({.method = "GET",
              .path = "/api/runs",
              .id = "list_runs",
              .meaning = "Runs, newest first",
              .answers = {{200, "RunList"}, {400, ""}},
              .query = {{"limit", R"({"type":"integer","minimum":1,"maximum":200,"default":50})", "at most so many"},
                        {"before", R"({"type":"integer","minimum":1})", "with numbers below this"},
                        {"capture", R"({"type":"string"})", "of this capture"}}},
             [this](const Request& request, Response& response) { list_runs(request, response); });
  routes.add({.method = "GET",
              .path = "/api/runs/{run}",
              .id = "get_run",
              .meaning = "One run",
              .answers = {{200, "Run"}, {404, ""}}},
             [this](const Request&, Response& response) {
               response.set_header("Cache-Control", "no-store");
               write_json(response, 200, run_json(find_run(path_part(0))));
             });
  routes.add({.method = "DELETE",
              .path = "/api/runs/{run}",
              .id = "delete_run",
              .meaning = "Deletes it with its results",
              .right = Right::admin,
              .answers = {{204, ""}, {404, ""}, {409, ""}}},
             [this](const Request&, Response& response) {
               const std::string id = path_part(0);
               if (store_.delete_run(find_run(id).id) == Store::Deletion::in_use) {
                 throw HttpError(409, "the run can't be deleted", "it is queued or running; cancel it first", id);
               }
               response.status = 204;
             });
  routes.add({.method = "POST",
              .path = "/api/runs/{run}/cancel",
              .id = "cancel_run",
              .meaning = "Cancels it",
              .right = Right::submit,
              .answers = {{202, "Run"}, {404, ""}, {409, ""}}},
             [this](const Request&, Response& response) { cancel_run(find_run(path_part(0)).id, response); });
  routes.add({.method = "GET",
              .path = "/api/runs/{run}/events",
              .id = "follow_run",
              .meaning = "Progress as server-sent events",
              .answers = {{200, "text/event-stream"}, {400, ""}, {404, ""}, {503, ""}},
              .query = {{"after", R"({"type":"integer","minimum":0})", "results after this one, as Last-Event-ID"}}},
             [this](const Request& request, Response& response) {
               send_events(find_run(path_part(0)).id, request, response);
             });
  for (const bool as_csv : {false, true}) {
    routes.add(
        {.method = "GET",
         .path = as_csv ? "/api/runs/{run}/results.csv" : "/api/runs/{run}/results.json",
         .id = as_csv ? "get_results_csv" : "get_results",
         .meaning = "What is measured so far",
         .answers = {{200, as_csv ? "text/csv" : "Results"}, {404, ""}}},
        [this, as_csv](const Request&, Response& response) { send_results(find_run(path_part(0)), as_csv, response); });
  }
  const QueryMember cost{"cost", R"({"type":"string","enum":["time","ratio","memory"],"default":"time"})", "across"};
  const QueryMember error{"error", R"({"type":"string","enum":["mse","flip"],"default":"mse"})", "up"};
  struct Plot {
    const char *file, *id, *meaning, *media_type;
    std::vector<QueryMember> query;
  };
  for (const Plot& plot : {Plot{"plot.svg", "get_plot", "Cost against error", "image/svg+xml", {cost, error}},
                           Plot{"points.csv", "get_points_csv", "The plots' points", "text/csv", {}},
                           Plot{"points.md", "get_points_markdown", "The plots' points", "text/markdown", {}}}) {
    std::vector<Answer> answers{{200, plot.media_type}, {404, ""}};
    if (!plot.query.empty()) answers.push_back({400, ""});
    routes.add({.method = "GET",
                .path = std::string("/api/runs/{run}/") + plot.file,
                .id = plot.id,
                .meaning = plot.meaning,
                .answers = answers,
                .query = plot.query},
               [this, kind = std::string(plot.file)](const Request& request, Response& response) {
                 send_plots(request, kind, response);
               });
  }
  routes.add({.method = "GET",
              .path = "/api/runs/{run}/advice",
              .id = "get_advice",
              .meaning = "The cheapest settings within a budget",
              .answers = {{200, "Advice"}, {400, ""}, {404, ""}},
              .query = {{"max_flip", R"({"type":"number","minimum":0})", "largest mean FLIP"},
                        {"max_mse", R"({"type":"number","minimum":0})", "largest MSE"}}},
             [this](const Request& request, Response& response) { send_advice(request, response); });
}

void Api::send_results(const RunRecord& run, bool as_csv, Response& response) const {
  response.set_header("Cache-Control", "no-store");
  response.set_header("Content-Disposition",
                      fmt::format("inline; filename=\"run-{}-results.{}\"", run.id, as_csv ? "csv" : "json"));
  if (as_csv) return response.set_content(replay::to_csv(measured(run)), "text/csv; charset=utf-8");
  // The documents as they are stored, which reading and writing them would not change.
  const json head = run.head ? *run.head : replay::to_json(replay::ResultsHead{});
  response.set_content(fmt::format(R"({{"head":{},"results":{}}})", head.dump(), store_.results_text(run.id)),
                       "application/json");
}

replay::Results Api::measured(const RunRecord& run) const {
  replay::Results results;
  if (run.head) results.head = replay::results_head_from_json(*run.head);
  for (const StoredResult& result : store_.results(run.id)) {
    results.results.push_back(replay::frame_result_from_json(result.document));
  }
  return results;
}

void Api::send_plots(const Request& request, const std::string& kind, Response& response) const {
  const RunRecord run = find_run(path_part(0));
  const std::vector<replay::Summary> summaries = replay::summarise(measured(run));
  response.set_header("Cache-Control", "no-store");
  const auto name_file = [&](const std::string& name) {
    response.set_header("Content-Disposition", fmt::format("inline; filename=\"run-{}-{}\"", run.id, name));
  };
  if (kind != "plot.svg") name_file(kind);
  if (kind == "points.csv") return response.set_content(replay::points_csv(summaries), "text/csv; charset=utf-8");
  if (kind == "points.md") {
    return response.set_content(replay::points_markdown(summaries), "text/markdown; charset=utf-8");
  }
  const auto cost = static_cast<replay::PlotCost>(query_choice(request, "cost", replay::kPlotCosts));
  const auto error = static_cast<replay::PlotError>(query_choice(request, "error", replay::kPlotErrors));
  name_file(fmt::format("{}-{}.svg", replay::kPlotCosts[static_cast<std::size_t>(cost)],
                        replay::kPlotErrors[static_cast<std::size_t>(error)]));
  response.set_content(replay::to_svg(replay::make_plot(summaries, cost, error)), "image/svg+xml");
}

void Api::send_advice(const Request& request, Response& response) const {
  const RunRecord run = find_run(path_part(0));
  replay::ErrorBudget budget;
  budget.max_flip = query_amount(request, "max_flip");
  budget.max_mse = query_amount(request, "max_mse");
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, replay::to_json(replay::advise(measured(run), budget)));
}

RunRecord Api::find_run(const std::string& id) const {
  std::optional<RunRecord> run = store_.run(parse_id(id));
  if (!run || run->kind != RunKind::run) throw HttpError(404, "there is no such run", "none has this number", id);
  request_context().run = run->id;
  return *std::move(run);
}

json Api::run_json(const RunRecord& run) const {
  replay::ReplayJob job;
  job.options = run.options;
  json request = replay::to_json(job).at("options");
  request.erase("skip");
  json document = status_json(run, events_.progress(run.id));
  document["id"] = run.id;
  document["capture"] = {{"hash", run.capture}, {"name", run.capture_name}, {"title", run.capture_title}};
  document["created_utc"] = run.created_utc;
  document["started_utc"] = text_or_null(run.started_utc);
  document["finished_utc"] = text_or_null(run.finished_utc);
  document["request"] = request;
  document["priority"] = run.place.priority;
  document["retries"] = run.place.retries;
  document["submitter"] = run.place.submitter;
  document["head"] = run.head ? *run.head : json(nullptr);
  return document;
}

std::optional<RunRecord> Api::equal_run(const std::string& capture, const replay::ReplayOptions& options) const {
  const auto request_of = [](const replay::ReplayOptions& of) {
    json request =
        replay::to_json(replay::ReplayJob{.capture = {}, .out_dir = {}, .cache_dir = {}, .options = of}).at("options");
    request.erase("skip");
    return request;
  };
  const json wanted = request_of(options);
  std::int64_t before = 0;
  while (true) {
    const std::vector<RunRecord> runs = store_.runs(kMaxListedRuns, before, capture);
    for (const RunRecord& run : runs) {
      const bool ended_badly = run.status == RunStatus::failed || run.status == RunStatus::cancelled;
      if (!ended_badly && request_of(run.options) == wanted) return run;
    }
    if (runs.size() < kMaxListedRuns) return std::nullopt;
    before = runs.back().id;
  }
}

void Api::post_run(const Request& request, Response& response) {
  const std::string body = read_json_body(request, "the run");
  RunRequest wanted = parse_run_request(body);
  const std::optional<CaptureRecord> capture = store_.capture(wanted.capture);
  if (!capture) throw HttpError(404, "there is no such capture", "none has this hash", "capture");
  const std::uint64_t expected = resolve_frames(wanted.options, capture->frame_count);
  if (query_number(request, "once", 0, 1, 0) == 1) {
    if (const std::optional<RunRecord> equal = equal_run(capture->hash, wanted.options)) {
      request_context().run = equal->id;
      return write_json(response, 200, run_json(*equal));
    }
  }
  const std::optional<TokenRecord>& caller = request_context().caller;
  wanted.place.submitter = caller ? caller->name : request.remote_addr;
  const std::optional<std::int64_t> id =
      store_.add_run(RunKind::run, capture->hash, wanted.options, expected, wanted.place);
  if (!id) throw HttpError(404, "there is no such capture", "it was deleted meanwhile", "capture");
  queue_.notify();
  response.set_header("Location", fmt::format("/api/runs/{}", *id));
  write_json(response, 201, run_json(find_run(std::to_string(*id))));
}

void Api::list_runs(const Request& request, Response& response) const {
  const auto limit = static_cast<std::uint32_t>(query_number(request, "limit", 1, kMaxListedRuns, 50));
  const std::int64_t before = query_number(request, "before", 1, INT64_MAX, 0);
  const std::vector<RunRecord> runs = store_.runs(limit + 1, before, request.get_param_value("capture"));
  json list = json::array();
  for (std::size_t i = 0; i < runs.size() && i < limit; ++i) list.push_back(run_json(runs[i]));
  // One more than asked for was read, so that a full last page is not followed by an empty one.
  const json next = runs.size() > limit ? json(runs[limit - 1].id) : json(nullptr);
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, {{"runs", list}, {"next_before", next}});
}

void Api::cancel_run(std::int64_t id, Response& response) {
  if (!queue_.cancel(id))
    throw HttpError(409, "the run can't be cancelled", "it has ended already", std::to_string(id));
  write_json(response, 202, run_json(find_run(std::to_string(id))));
}

void Api::send_events(std::int64_t id, const Request& request, Response& response) {
  // A browser repeats the last event's id when it reconnects; the query is for clients that can't set the header.
  const std::string last = request.has_header("Last-Event-ID") ? request.get_header_value("Last-Event-ID")
                                                               : request.get_param_value("after");
  const std::int64_t last_seen = last.empty() ? 0 : parse_id(last);
  if (last_seen < 0) throw HttpError(400, "the request is refused", "the event's id is no number", "Last-Event-ID");
  if (followers_.fetch_add(1) >= options_.http.followers) {
    --followers_;
    response.set_header("Retry-After", "5");
    throw HttpError(503, "the progress can't be followed", "too many clients follow runs", std::to_string(id));
  }
  const std::shared_ptr<const void> place(nullptr, [this](const void*) { --followers_; });
  response.set_header("Cache-Control", "no-store");
  response.set_header("X-Accel-Buffering", "no");      // nginx hands on at once what comes
  const bool chunked = request.version != "HTTP/1.0";  // knows none: the connection's end is that of the stream
  const auto follow = [=](std::size_t, httplib::DataSink&) {
    Exchange::current().follow({.topic = id, .position = last_seen, .chunked = chunked, .place = place});
    return false;
  };
  if (chunked) {
    response.set_chunked_content_provider("text/event-stream", follow);
  } else {
    response.set_content_provider("text/event-stream", follow);
  }
}

std::optional<News> Api::run_news(std::int64_t id, std::int64_t last_seen) const {
  // The status is read before the results: when it is final, the results that follow are all there are.
  const std::optional<RunRecord> run = store_.run(id);
  if (!run) return std::nullopt;
  News news{.text = {}, .position = last_seen};
  const std::vector<StoredResult> results = store_.results_after(id, last_seen, kResultsAtATime);
  for (const StoredResult& result : results) {
    news.text += event_text(
        "result", {{"sequence", result.sequence}, {"ordinal", result.technique_ordinal}, {"result", result.document}},
        result.sequence);
    news.position = result.sequence;
  }
  news.more = results.size() == kResultsAtATime;
  if (news.more) return news;
  const json status = status_json(*run, events_.progress(id));
  news.last = is_final(run->status);
  news.text += event_text("status", status);
  if (news.last) news.text += event_text("end", status);
  return news;
}

}  // namespace subpixel::server
