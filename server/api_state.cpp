// How the service is: health, readiness, metrics; and its description.
#include <fmt/format.h>

#include <map>

#include "server/api.hpp"
#include "server/http_error.hpp"
#include "server/request_context.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

// Of why a run failed, the few kinds there are: a text would make a series of each run.
std::string failure_kind(const std::string& reason) {
  constexpr std::pair<std::string_view, std::string_view> kKinds[] = {{"memory ran out", "memory"},
                                                                      {"ended by signal", "crash"},
                                                                      {"said nothing", "silence"},
                                                                      {"ran longer", "time"},
                                                                      {"disk", "disk"},
                                                                      {"results can't be stored", "store"},
                                                                      {"given up", "given_up"},
                                                                      {"refused", "bad_output"},
                                                                      {"a line of more than", "bad_output"},
                                                                      {"is no valid message", "bad_output"},
                                                                      {"left out results", "bad_output"},
                                                                      {"without saying", "bad_output"},
                                                                      {"exit code", "exit"},
                                                                      {"internal error", "internal"}};
  for (const auto& [words, kind] : kKinds) {
    if (reason.find(words) != std::string::npos) return std::string(kind);
  }
  return "replay";  // what the worker itself said
}

}  // namespace

void Api::route_state(Routes& routes) {
  routes.add({.method = "GET",
              .path = "/healthz",
              .id = "is_alive",
              .meaning = "Whether the process answers",
              .right = Right::none,
              .answers = {{200, "text/plain"}}},
             [](const Request&, Response& response) { response.set_content("ok\n", "text/plain"); });
  routes.add({.method = "GET",
              .path = "/readyz",
              .id = "is_ready",
              .meaning = "Whether the store takes writes and the disk has room",
              .right = Right::none,
              .answers = {{200, "Readiness"}, {503, "Readiness"}}},
             [this](const Request&, Response& response) { get_readiness(response); });
  routes.add({.method = "GET",
              .path = "/metrics",
              .id = "get_metrics",
              .meaning = "Counters in the text format of Prometheus",
              .answers = {{200, "text/plain"}}},
             [this](const Request&, Response& response) {
               response.set_header("Cache-Control", "no-store");
               response.set_content(metrics_.text() + store_metrics(), "text/plain; version=0.0.4; charset=utf-8");
             });
  routes.add(
      {.method = "GET",
       .path = "/api/openapi.json",
       .id = "get_openapi",
       .meaning = "This description, OpenAPI 3.1",
       .right = Right::none,
       .answers = {{200, "application/json"}}},
      [this](const Request&, Response& response) { write_json(response, 200, routes_.description(SUBPIXEL_VERSION)); });
  routes.add({.method = "GET",
              .path = "/api/health",
              .id = "get_health",
              .meaning = "The service's state",
              .answers = {{200, "Health"}}},
             [this](const Request&, Response& response) { get_health(response); });
}

void Api::get_health(Response& response) const {
  const StoreCounts counts = store_.counts();
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200,
             {{"status", "ok"},
              {"version", SUBPIXEL_VERSION},
              {"captures", counts.captures},
              {"runs", counts.runs},
              {"queued", counts.queued},
              {"running", counts.running},
              {"upload_limit_bytes", options_.upload_limit_bytes},
              {"free_bytes", folder_.free_bytes()}});
}

void Api::get_readiness(Response& response) {
  std::string why;
  try {
    store_.probe();
    if (folder_.free_bytes() < options_.reserved_bytes) why = "the disk has too little room";
  } catch (const SqliteError& error) {
    why = std::string("the store can't be written: ") + error.what();
  }
  if (stop_.stop_requested()) why = "the service is ending";
  response.set_header("Cache-Control", "no-store");
  write_json(response, why.empty() ? 200 : 503, {{"ready", why.empty()}, {"why", why}});
}

std::string Api::store_metrics() const {
  const StoreGauges gauges = store_.gauges();
  std::string out = "# HELP subpixel_runs Runs by status; of failed ones also why.\n# TYPE subpixel_runs gauge\n";
  std::map<std::tuple<std::string, std::string, std::string>, std::uint64_t> runs;
  for (const std::string_view status : {"queued", "running", "done", "failed", "cancelled"}) {
    runs[{"run", std::string(status), ""}] = 0;
  }
  for (const StoreGauges::Runs& each : gauges.runs) {
    runs[{each.kind, each.status, each.status == "failed" ? failure_kind(each.reason) : ""}] += each.count;
  }
  for (const auto& [key, count] : runs) {
    out += fmt::format("subpixel_runs{{kind=\"{}\",status=\"{}\",reason=\"{}\"}} {}\n", std::get<0>(key),
                       std::get<1>(key), std::get<2>(key), count);
  }
  out +=
      "# HELP subpixel_run_stage_seconds Time of the stored runs outside of device passes, by stage; all: their whole "
      "time.\n# TYPE subpixel_run_stage_seconds gauge\n";
  for (const auto& [stage, seconds] : gauges.stage_seconds) {
    out += fmt::format("subpixel_run_stage_seconds{{stage=\"{}\"}} {}\n", metric_text(stage), seconds);
  }
  const auto gauge = [&](const char* name, const char* help, std::uint64_t value) {
    out += fmt::format("# HELP {0} {1}\n# TYPE {0} gauge\n{0} {2}\n", name, help, value);
  };
  gauge("subpixel_results", "Results stored.", gauges.results);
  gauge("subpixel_captures", "Captures stored.", gauges.captures);
  gauge("subpixel_capture_bytes", "Bytes of captures.", gauges.capture_bytes);
  gauge("subpixel_store_bytes", "Bytes of the store's file.", gauges.store_bytes);
  gauge("subpixel_store_free_bytes", "Bytes that are free within the store's file.", gauges.store_free_bytes);
  gauge("subpixel_disk_free_bytes", "Bytes free on the data folder's disk.", folder_.free_bytes());
  gauge("subpixel_followers", "Clients that follow a run.", followers_);
  return out;
}

}  // namespace subpixel::server
