// Nights, their cells and baselines over HTTP.
#include <fmt/format.h>

#include <algorithm>

#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/api.hpp"
#include "server/http_error.hpp"
#include "server/nightly/summaries.hpp"
#include "server/nightly/trends.hpp"
#include "server/request_context.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxListedNights = 200, kMaxTrendNights = 1000;
constexpr std::size_t kMaxReasonBytes = 500;

// A night in the list: how it ended, without what it measured.
json short_json(const NightRecord& night) {
  json document = to_json(night);
  document.erase("captures");
  document.erase("cells");
  return document;
}

const NightCell* find_cell(const NightRecord& night, const std::string& capture, const std::string& technique) {
  for (const NightCell& cell : night.cells) {
    if (cell.technique == technique && night.captures.at(cell.capture).name == capture) return &cell;
  }
  return nullptr;
}

json frames_json(const NightCell* tonight, const NightCell* baseline) {
  std::map<std::uint32_t, json> frames;
  const auto entry = [&](std::uint32_t frame) -> json& {
    json& document = frames[frame];
    if (document.is_null()) {
      document = {{"frame", frame}, {"tonight", nullptr}, {"baseline", nullptr}, {"difference", nullptr}};
    }
    return document;
  };
  if (tonight != nullptr) {
    for (const NightFrame& frame : tonight->frames) {
      json& document = entry(frame.result.frame);
      document["tonight"] = replay::to_json(frame.result);
      if (!frame.difference.empty()) document["difference"] = frame.difference;
    }
  }
  if (baseline != nullptr) {
    for (const NightFrame& frame : baseline->frames) {
      entry(frame.result.frame)["baseline"] = replay::to_json(frame.result);
    }
  }
  json list = json::array();
  for (auto& frame : frames) list.push_back(std::move(frame.second));
  return list;
}

json approvals_json(const std::vector<BaselineRecord>& approvals) {
  json list = json::array();
  for (const BaselineRecord& each : approvals) {
    list.push_back(
        {{"name", each.name}, {"night", each.night}, {"set_utc", each.set_utc}, {"who", each.who}, {"why", each.why}});
  }
  return list;
}

}  // namespace

void Api::route_nights(Routes& routes) {
  routes.add({.method = "GET",
              .path = "/api/nights",
              .id = "list_nights",
              .meaning = "Nights, newest first",
              .answers = {{200, "NightList"}, {400, ""}},
              .query = {{"limit", R"({"type":"integer","minimum":1,"maximum":200,"default":30})", "at most so many"},
                        {"before", R"({"type":"integer","minimum":1})", "with numbers below this"},
                        {"name", R"({"type":"string"})", "of this name"}}},
             [this](const Request& request, Response& response) { list_nights(request, response); });
  routes.add({.method = "GET",
              .path = "/api/nights/{night}",
              .id = "get_night",
              .meaning = "One night with its cells",
              .answers = {{200, "NightWithCells"}, {404, ""}}},
             [this](const Request&, Response& response) {
               response.set_header("Cache-Control", "no-store");
               write_json(response, 200, to_json(find_night(path_part(0))));
             });
  route_trends(routes);
  for (const bool markdown : {true, false}) {
    routes.add({.method = "GET",
                .path = markdown ? "/api/nights/{night}/summary.md" : "/api/nights/{night}/summary.xml",
                .id = markdown ? "get_night_markdown" : "get_night_junit",
                .meaning = markdown ? "Its summary" : "Its summary as JUnit XML",
                .answers = {{200, markdown ? "text/markdown" : "application/xml"}, {404, ""}}},
               [this, markdown](const Request&, Response& response) {
                 send_summary(find_night(path_part(0)), markdown, response);
               });
  }
  routes.add({.method = "GET",
              .path = "/api/nights/{night}/cells/{cell}",
              .id = "get_cell",
              .meaning = "A cell with its frames beside the baseline's",
              .answers = {{200, "Cell"}, {404, ""}}},
             [this](const Request&, Response& response) {
               send_cell(find_night(path_part(0)), parse_id(path_part(1)), response);
             });
  routes.add({.method = "GET",
              .path = "/api/baselines",
              .id = "list_baselines",
              .meaning = "Approved nights",
              .answers = {{200, "BaselineList"}}},
             [this](const Request&, Response& response) {
               response.set_header("Cache-Control", "no-store");
               write_json(response, 200, {{"baselines", approvals_json(nights_.baselines())}});
             });
  routes.add(
      {.method = "GET",
       .path = "/api/approvals",
       .id = "list_approvals",
       .meaning = "Every approval there was, newest first",
       .answers = {{200, "ApprovalList"}},
       .query = {{"name", R"({"type":"string"})", "of this baseline"}}},
      [this](const Request& request, Response& response) {
        response.set_header("Cache-Control", "no-store");
        write_json(response, 200, {{"approvals", approvals_json(nights_.approvals(request.get_param_value("name")))}});
      });
  routes.add({.method = "POST",
              .path = "/api/baselines",
              .id = "approve_night",
              .meaning = "Approves a finished night",
              .right = Right::approve,
              .answers = {{200, "Approved"}, {400, ""}, {404, ""}, {415, ""}},
              .body = "Approval"},
             [this](const Request& request, Response& response) { post_baseline(request, response); });
}

void Api::route_trends(Routes& routes) {
  const std::vector<QueryMember> query = {
      {"name", R"({"type":"string"})", "of the nights"},
      {"capture", R"({"type":"string"})", "of the cell; every cell of the newest night without capture and technique"},
      {"technique", R"({"type":"string"})", "of the cell"},
      {"limit", R"({"type":"integer","minimum":1,"maximum":1000,"default":200})", "newest nights of each cell"}};
  for (const bool csv : {false, true}) {
    routes.add(
        {.method = "GET",
         .path = csv ? "/api/nights/trends.csv" : "/api/nights/trends",
         .id = csv ? "get_trends_csv" : "get_trends",
         .meaning = csv ? "Numbers of cells over nights as CSV" : "Numbers of cells over nights, and where they moved",
         .answers = {{200, csv ? "text/csv" : "Trends"}, {400, ""}, {404, ""}},
         .query = query},
        [this, csv](const Request& request, Response& response) { send_trends(request, csv, response); });
  }
}

void Api::send_trends(const Request& request, bool csv, Response& response) const {
  const std::string name = request.get_param_value("name");
  const std::string capture = request.get_param_value("capture"), technique = request.get_param_value("technique");
  if (name.empty()) throw HttpError(400, "trends", "the name of the nights is missing", "name");
  if (capture.empty() != technique.empty())
    throw HttpError(400, "trends", "a cell has a capture and a technique", capture.empty() ? "capture" : "technique");
  const auto limit = static_cast<std::uint32_t>(query_number(request, "limit", 1, kMaxTrendNights, 200));
  std::vector<std::pair<std::string, std::string>> cells;
  if (capture.empty()) {
    cells = trend_cells(nights_, name);
  } else {
    cells.emplace_back(capture, technique);
  }
  json list = json::array();
  std::string text;
  bool any = false;
  for (const auto& [of_capture, of_technique] : cells) {
    const CellTrend trend = cell_trend(nights_, name, of_capture, of_technique, limit);
    if (trend.nights.empty()) continue;
    if (csv) text += to_csv(trend, !any);
    if (!csv) list.push_back(to_json(trend));
    any = true;
  }
  if (!any) throw HttpError(404, "there is no such trend", "no finished night of this name measured it", name);
  response.set_header("Cache-Control", "no-store");
  if (!csv) return write_json(response, 200, {{"trends", list}});
  response.set_header("Content-Disposition", "attachment; filename=\"trends.csv\"");
  response.set_content(text, "text/csv; charset=utf-8");
}

void Api::send_summary(const NightRecord& night, bool markdown, Response& response) const {
  response.set_header("Cache-Control", "no-store");
  response.set_header("Content-Disposition",
                      fmt::format("inline; filename=\"night-{}.{}\"", night.id, markdown ? "md" : "xml"));
  if (markdown) return response.set_content(to_markdown(night), "text/markdown; charset=utf-8");
  response.set_content(to_junit(night), "application/xml; charset=utf-8");
}

NightRecord Api::find_night(const std::string& id) const {
  std::optional<NightRecord> night = nights_.night(parse_id(id), false);
  if (!night) throw HttpError(404, "there is no such night", "none has this number", id);
  return *std::move(night);
}

void Api::list_nights(const Request& request, Response& response) const {
  const auto limit = static_cast<std::uint32_t>(query_number(request, "limit", 1, kMaxListedNights, 30));
  const std::int64_t before = query_number(request, "before", 1, INT64_MAX, 0);
  const std::vector<NightRecord> nights = nights_.nights(limit + 1, before, request.get_param_value("name"));
  json list = json::array();
  for (std::size_t i = 0; i < nights.size() && i < limit; ++i) list.push_back(short_json(nights[i]));
  // One more than asked for was read, so that a full last page is not followed by an empty one.
  const json next = nights.size() > limit ? json(nights[limit - 1].id) : json(nullptr);
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, {{"nights", list}, {"next_before", next}});
}

void Api::send_cell(const NightRecord& night, std::int64_t cell, Response& response) const {
  const auto found = std::ranges::find(night.cells, cell, &NightCell::id);
  if (found == night.cells.end()) {
    throw HttpError(404, "there is no such cell", "none of this night has this number", std::to_string(cell));
  }
  const std::string capture = night.captures.at(found->capture).name;
  const std::optional<NightCell> tonight = nights_.cell(found->id);
  std::optional<NightCell> before;
  if (night.baseline_night) {
    if (const std::optional<NightRecord> baseline = nights_.night(*night.baseline_night, false)) {
      const NightCell* counterpart = find_cell(*baseline, capture, found->technique);
      if (counterpart != nullptr) before = nights_.cell(counterpart->id);
    }
  }
  json document = {{"id", found->id},
                   {"capture", capture},
                   {"technique", found->technique},
                   {"status", to_text(found->status)},
                   {"gates", to_json(found->gates)},
                   {"time", to_json(found->time)},
                   {"baseline_time", before ? to_json(before->time) : json(nullptr)},
                   {"frames", frames_json(tonight ? &*tonight : nullptr, before ? &*before : nullptr)}};
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, document);
}

void Api::post_baseline(const Request& request, Response& response) {
  const std::string what = "baseline";
  const json document = parse_json_document(read_json_body(request, "the baseline"), what, "the body");
  const JsonField top(document, what);
  check_names(top, {"name", "night", "why"}, what, "top level");
  const std::string name = top.member("name").text();
  if (name.empty() || name.size() > 100) top.member("name").fail("expected a name of 1 to 100 bytes");
  const std::uint32_t night = top.member("night").u32();
  const std::string why = top.has("why") ? top.member("why").text() : "";
  if (why.size() > kMaxReasonBytes || printable(why) != why) {
    top.member("why").fail(fmt::format("expected at most {} printable bytes", kMaxReasonBytes));
  }
  const std::optional<TokenRecord>& caller = request_context().caller;
  if (!nights_.set_baseline(name, night, caller ? caller->name : "", why)) {
    throw HttpError(404, "there is no such night", "none that has ended has this number", std::to_string(night));
  }
  write_json(response, 200, {{"name", name}, {"night", night}});
}

}  // namespace subpixel::server
