// The description at /api/openapi.json against what the service answers: every operation, every status that it names,
// every member of every document. Metrics, health and the log's identifiers besides.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include "server/nightly/night_store.hpp"
#include "server/store/tokens.hpp"
#include "tests/service/service_fixture.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

// JSON Schema as far as the description uses it; whatever else stands in a schema is a failure.
class Schemas {
 public:
  explicit Schemas(const json& description) : all_(description.at("components").at("schemas")) {}

  // What is wrong with `value`; empty when nothing is.
  std::string problem(const json& value, const json& schema, const std::string& where = "$") const {
    for (const auto& [word, content] : schema.items()) {
      static const std::set<std::string> kWords{
          "$ref",    "type",     "properties", "required", "additionalProperties", "items", "enum", "oneOf", "pattern",
          "minimum", "minItems", "maxItems",   "default"};
      if (!kWords.contains(word)) return fmt::format("{}: the schema has a word that is not checked: {}", where, word);
    }
    if (schema.contains("$ref")) {
      const std::string name = schema.at("$ref").get<std::string>().substr(std::string("#/components/schemas/").size());
      return problem(value, all_.at(name), where);
    }
    if (schema.contains("oneOf")) {
      std::string problems;
      for (const json& each : schema.at("oneOf")) {
        std::string found = problem(value, each, where);
        if (found.empty()) return "";
        problems += found + "; ";
      }
      return problems;
    }
    if (schema.contains("type") && !has_type(value, schema.at("type"))) return where + ": it is " + value.dump();
    if (schema.contains("enum") && std::count(schema.at("enum").begin(), schema.at("enum").end(), value) == 0) {
      return where + ": it is " + value.dump();
    }
    if (value.is_number() && schema.contains("minimum") && value < schema.at("minimum")) return where + ": too small";
    if (value.is_string() && schema.contains("pattern") &&
        !std::regex_search(value.get<std::string>(), std::regex(schema.at("pattern").get<std::string>()))) {
      return where + ": it is " + value.dump();
    }
    if (value.is_array()) {
      for (std::size_t i = 0; schema.contains("items") && i < value.size(); ++i) {
        std::string found = problem(value[i], schema.at("items"), where + "[]");
        if (!found.empty()) return found;
      }
    }
    return value.is_object() ? object_problem(value, schema, where) : "";
  }

 private:
  static bool has_type(const json& value, const json& types) {
    for (const json& each : types.is_array() ? types : json::array({types})) {
      const std::string type = each;
      if ((type == "null" && value.is_null()) || (type == "object" && value.is_object()) ||
          (type == "array" && value.is_array()) || (type == "string" && value.is_string()) ||
          (type == "boolean" && value.is_boolean()) || (type == "number" && value.is_number()) ||
          (type == "integer" && value.is_number_integer())) {
        return true;
      }
    }
    return false;
  }
  std::string object_problem(const json& value, const json& schema, const std::string& where) const {
    const json properties = schema.value("properties", json::object());
    for (const json& name : schema.value("required", json::array())) {
      if (!value.contains(name)) return where + ": " + name.get<std::string>() + " is missing";
    }
    for (const auto& [name, member] : value.items()) {
      const json* inner = nullptr;
      if (properties.contains(name)) {
        inner = &properties.at(name);
      } else if (schema.contains("additionalProperties")) {
        inner = &schema.at("additionalProperties");
        if (inner->is_boolean()) return fmt::format("{}: {} is not described", where, name);
      } else {
        continue;
      }
      if (std::string found = problem(member, *inner, fmt::format("{}.{}", where, name)); !found.empty()) return found;
    }
    return "";
  }

  const json all_;
};

class Description : public ServiceTest {
 protected:
  void SetUp() override {
    start(options());
    description_ = client().get("/api/openapi.json");
  }

  // Sends a request and holds its answer to the description.
  httplib::Response ask(const std::string& method, const std::string& target, const std::string& body = "",
                        const httplib::Headers& headers = {}, const std::string& type = "application/json") {
    const httplib::Result result = method == "get"      ? client().http().Get(target, headers)
                                   : method == "delete" ? client().http().Delete(target, headers)
                                                        : client().http().Post(target, headers, body, type);
    EXPECT_TRUE(result) << target;
    if (!result) return {};
    const std::string path = target.substr(0, target.find('?'));
    for (const auto& [described, methods] : description_.at("paths").items()) {
      const std::string pattern = std::regex_replace(std::regex_replace(described, std::regex("\\."), "\\."),
                                                     std::regex("\\{[a-z]+\\}"), "[0-9a-f]+");
      if (!std::regex_match(path, std::regex(pattern)) || !methods.contains(method)) continue;
      SCOPED_TRACE(fmt::format("{} {}", method, target));
      hold(methods.at(method), *result);
      return *result;
    }
    ADD_FAILURE() << method << " " << target << " is not described";
    return *result;
  }
  json document(const std::string& target) { return json::parse(ask("get", target).body); }

  // What the description names and no answer was.
  std::set<std::string> unseen() const {
    std::set<std::string> all;
    for (const auto& [path, methods] : description_.at("paths").items()) {
      for (const auto& [method, operation] : methods.items()) {
        for (const auto& [status, answer] : operation.at("responses").items()) {
          if (status != "default") all.insert(operation.at("operationId").get<std::string>() + " " + status);
        }
      }
    }
    for (const std::string& seen : seen_) all.erase(seen);
    return all;
  }

  json description_;

 private:
  void hold(const json& operation, const httplib::Response& response) {
    const std::string status = std::to_string(response.status);
    const json& responses = operation.at("responses");
    ASSERT_TRUE(responses.contains(status)) << status << " is not described: " << response.body;
    seen_.insert(operation.at("operationId").get<std::string>() + " " + status);
    const json& answer = responses.at(status);
    if (!answer.contains("content")) {
      EXPECT_EQ(response.body, "");
      return;
    }
    const auto first = answer.at("content").begin();
    const std::string& media_type = first.key();
    std::string type = response.get_header_value("Content-Type");
    type = type.substr(0, type.find(';'));
    if (media_type == "image/*") {
      EXPECT_TRUE(type.starts_with("image/")) << type;
    } else {
      EXPECT_EQ(type, media_type);
    }
    if (media_type != "application/json") return;
    EXPECT_EQ(Schemas(description_).problem(json::parse(response.body), first->at("schema")), "") << response.body;
  }

  std::set<std::string> seen_;
};

TEST_F(Description, HoldsForEveryOperationStatusAndMember) {
  const std::string none(32, '0');
  for (const char* const path : {"/healthz", "/readyz", "/metrics", "/api/openapi.json", "/api/health", "/api/caller",
                                 "/api/techniques", "/api/limits", "/api/palettes"}) {
    ask("get", path);
  }
  ask("post", "/api/sign-out");
  {
    server::Store store(folder() / "data" / "subpixel.sqlite");
    const std::string token = server::TokenStore(store).add("one", server::Right::read, 1000, 1);
    ask("post", "/api/sign-in", json{{"token", token}}.dump());
  }
  ask("post", "/api/sign-in", R"({"token":"wrong"})");
  for (int i = 0; i < 10; ++i) client().http().Post("/api/sign-in", R"({"token":"wrong"})", "application/json");
  ask("post", "/api/sign-in", R"({"token":"wrong"})");

  const std::string bytes = fake_capture({{"frames", 2}, {"title", "A"}});
  const std::string octets = "application/octet-stream";
  const std::string hash = json::parse(ask("post", "/api/captures?name=a", bytes, {}, octets).body).at("hash");
  ask("post", "/api/captures?name=a", bytes, {}, octets);
  ask("post", "/api/captures?name=a", "PK", {}, octets);
  ask("post", "/api/captures?name=a", std::string((1 << 20) + 1, 'x'), {}, octets);
  ask("post", "/api/captures?name=a", "x", {}, "multipart/form-data; boundary=x");
  ask("get", "/api/captures?limit=1&offset=0");
  ask("get", "/api/captures?limit=0");
  ask("get", "/api/captures/" + none);
  ask("post", "/api/captures/" + hash + "/tags", R"({"tags":["one"]})");
  ask("post", "/api/captures/" + hash + "/tags", R"({"tags":[7]})");
  ask("post", "/api/captures/" + hash + "/tags", R"({"tags":[]})", {}, "text/plain");
  ask("post", "/api/captures/" + none + "/tags", R"({"tags":[]})");
  const auto parts = [&](const std::string& path) {
    const httplib::Response whole = ask("get", path);
    ask("get", path, "", {{"Range", "bytes=0-1"}});
    ask("get", path, "", {{"Range", "bytes=999999999-"}});
    ask("get", path, "", {{"If-None-Match", whole.get_header_value("ETag")}});
  };
  parts("/api/captures/" + hash + "/file");
  ask("get", "/api/captures/" + none + "/file");
  for (const std::string& at : {hash + "/pixel?technique=msaa&x=1&y=2", hash + "/pixel?technique=msaa&x=4001&y=2",
                                none + "/pixel?technique=msaa&x=1&y=2"}) {
    ask("get", "/api/captures/" + at);
  }
  for (const std::string& at : {hash + "/frame?width=8&height=4", hash + "/frame?frame=4001", none + "/frame"}) {
    ask("get", "/api/captures/" + at);
  }

  const json wanted = {{"capture", hash},   {"techniques", {{{"technique", "noaa"}}, "msaa:samples=4|8"}},
                       {"width", 32},       {"height", 18},
                       {"frames", {0, 1}},  {"samples", 8},
                       {"repeat", 1},       {"reference_samples", 64},
                       {"point_lights", 2}, {"every_light", true}};
  EXPECT_EQ(Schemas(description_).problem(wanted, {{"$ref", "#/components/schemas/RunRequest"}}), "");
  const std::int64_t run = json::parse(ask("post", "/api/runs", wanted.dump()).body).at("id");
  client().wait_for_end(run);
  ask("post", "/api/runs?once=1", wanted.dump());
  ask("post", "/api/runs", "{}");
  ask("post", "/api/runs", "{}", {}, "text/plain");
  json absent = wanted;
  absent["capture"] = none;
  ask("post", "/api/runs", absent.dump());
  ask("get", "/api/runs?limit=1&before=99&capture=" + hash);
  ask("get", "/api/runs?limit=x");
  const std::string path = "/api/runs/" + std::to_string(run);
  for (const std::string& of : {path, std::string("/api/runs/999999")}) {
    for (const char* const what : {"", "/events", "/results.json", "/results.csv", "/plot.svg?cost=memory&error=flip",
                                   "/points.csv", "/points.md", "/advice?max_mse=1"}) {
      ask("get", of + what);
    }
  }
  for (const char* const wrong : {"/events?after=x", "/plot.svg?cost=x", "/advice?max_flip=x"})
    ask("get", path + wrong);
  const json results = document(path + "/results.json").at("results");
  parts("/api/blobs/" + results.at(0).at("images").at("image").get<std::string>());
  ask("get", "/api/blobs/" + none);
  ask("get", "/api/captures/" + hash);

  const std::string slow = client().upload_fake({{"frames", 1}, {"result_ms", 60'000}});
  const std::string running = "/api/runs/" + std::to_string(client().start_run(slow));
  ask("delete", running);
  ask("delete", "/api/captures/" + slow);
  ask("get", running);
  ask("post", running + "/cancel");
  client().wait_for_end(std::stoll(running.substr(10)));
  ask("post", running + "/cancel");
  ask("post", "/api/runs/999999/cancel");
  ask("delete", running);
  ask("delete", running);
  ask("delete", "/api/captures/" + slow);
  ask("delete", "/api/captures/" + slow);

  server::Store store(folder() / "data" / "subpixel.sqlite");
  server::NightStore nights(store);
  std::int64_t night = 0, cell = 0;
  for (int i = 0; i < 2; ++i) {
    server::NightRecord record;
    record.name = "quick";
    record.config = json::object();
    record.baseline = "quick";
    if (night > 0) record.baseline_night = night;
    night = nights.add(record);
    nights.add_capture(night, 0,
                       {.name = "one", .source = "path", .hash = hash, .problem = "", .head = replay::ResultsHead{}});
    server::NightCell each;
    each.technique = "noaa";
    each.status = server::CellStatus::passed;
    each.gates = {{"images", server::GateOutcome::passed, "equal"}};
    each.time.references["msaa"] = {1, 2};
    each.time.rounds = {{1, {{"msaa", 2 + i}}}};
    cell = nights.add_cell(night, each);
    nights.add_frame(cell, stored_result(0, "noaa"), {{"image", stored_image(10, i)}});
    nights.finish(night, server::NightStatus::passed, "");
  }
  const std::string night_path = "/api/nights/" + std::to_string(night);
  ask("get", "/api/nights?limit=1&before=99&name=quick");
  ask("get", "/api/nights?limit=x");
  for (const char* const trends : {"/api/nights/trends", "/api/nights/trends.csv"}) {
    for (const char* const query : {"?name=quick", "?name=quick&capture=one&technique=noaa&limit=9", "?name=other", ""})
      ask("get", std::string(trends) + query);
  }
  for (const std::string& of : {night_path, std::string("/api/nights/999999")}) {
    for (const char* const what : {"", "/summary.md", "/summary.xml"}) ask("get", of + what);
    ask("get", of + "/cells/" + std::to_string(cell));
  }
  ask("post", "/api/baselines", json{{"name", "quick"}, {"night", night}, {"why", "good"}}.dump());
  ask("post", "/api/baselines", json{{"name", "quick"}, {"night", 999999}}.dump());
  ask("post", "/api/baselines", "{}");
  ask("post", "/api/baselines", "{}", {}, "text/plain");
  ask("get", "/api/baselines");
  ask("get", "/api/approvals?name=quick");

  std::ofstream(folder() / "data" / "captures" / (hash + ".spcap"), std::ios::binary) << "something else";
  ask("post", "/api/captures?name=a", bytes, {}, octets);
  server::ServiceOptions full = options();
  full.reserved_bytes = std::uint64_t{1} << 60;
  full.http.followers = 0;
  start(full);
  ask("get", "/readyz");
  ask("get", path + "/events");
  EXPECT_EQ(json(unseen()), json::array()) << "described and never answered";
}

TEST_F(Description, HasAnExampleOfAllThatDocsName) {
  std::ifstream file(std::string(SUBPIXEL_SOURCE_DIR) + "/docs/http_api.md");
  const std::string docs((std::istreambuf_iterator<char>(file)), {});
  for (const auto& [path, methods] : description_.at("paths").items()) {
    for (const auto& [method, operation] : methods.items()) {
      EXPECT_NE(docs.find(std::string("`").append(operation.at("operationId").get<std::string>()).append("`")),
                std::string::npos)
          << path;
    }
  }
}

// What the library refuses by itself is not told of as the request before it on the same thread.
TEST_F(Description, WhatIsNoHttpCountsAsNoOperation) {
  for (int i = 0; i < 40; ++i) {
    client().get("/api/health");
    EXPECT_EQ(raw_exchange(port(), "HELLO /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", true).substr(9, 3), "400");
  }
  const std::string metrics = client().http().Get("/metrics")->body;
  for (const char* const line : {"subpixel_http_requests_total{operation=\"get_health\",status=\"200\"} 40\n",
                                 "subpixel_http_requests_total{operation=\"other\",status=\"400\"} 40\n"})
    EXPECT_NE(metrics.find(line), std::string::npos) << line << " is not in\n" << metrics;
}

TEST_F(Description, MetricsCountWhatHappens) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::int64_t crashed =
      client().start_run(client().upload_fake({{"frames", 1}, {"fail_at", 0}, {"how", "segv"}}));
  client().wait_for_end(crashed);
  client().wait_for_end(client().start_run(hash));
  client().get("/api/runs/999999", 404);
  const std::string metrics = client().http().Get("/metrics")->body;
  for (const char* const line :
       {"subpixel_runs{kind=\"run\",status=\"done\",reason=\"\"} 1\n",
        "subpixel_runs{kind=\"run\",status=\"failed\",reason=\"crash\"} 1\n", "subpixel_captures 2\n",
        "subpixel_http_requests_total{operation=\"upload_capture\",status=\"201\"} 2\n",
        "subpixel_http_requests_total{operation=\"get_run\",status=\"404\"} 1\n",
        "subpixel_http_request_seconds_count{operation=\"upload_capture\"} 2\n",
        "subpixel_http_request_seconds_bucket{operation=\"upload_capture\",le=\"+Inf\"} 2\n",
        "subpixel_run_stage_seconds{stage=\"all\"} "}) {
    EXPECT_NE(metrics.find(line), std::string::npos) << line << " is not in\n" << metrics;
  }
  // Each line is one of the format's, each series of a metric that was introduced.
  std::istringstream lines(metrics);
  std::set<std::string> introduced;
  const std::regex sample(R"(([a-z_]+?)(_bucket|_sum|_count)?(\{([a-z]+="[^"]*",?)*\})? [-+.0-9e]+)");
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (line.starts_with("# TYPE ")) introduced.insert(line.substr(7, line.find(' ', 7) - 7));
    if (line.starts_with("#")) continue;
    ASSERT_TRUE(std::regex_match(line, match, sample)) << line;
    EXPECT_TRUE(introduced.contains(match[1]) || introduced.contains(match[1].str() + match[2].str())) << line;
  }
}

TEST_F(Description, EveryAnswerHasTheRequestsNumber) {
  const httplib::Result first = client().http().Get("/api/health"), second = client().http().Get("/api/health");
  EXPECT_FALSE(first->get_header_value("X-Request-Id").empty());
  EXPECT_NE(first->get_header_value("X-Request-Id"), second->get_header_value("X-Request-Id"));
  const auto given = [&](const std::string& id) {
    return client().http().Get("/api/health", {{"X-Request-Id", id}})->get_header_value("X-Request-Id");
  };
  EXPECT_EQ(given("proxy-7.a_b"), "proxy-7.a_b");
  EXPECT_NE(given("a b"), "a b");
  EXPECT_NE(given(std::string(65, 'a')), std::string(65, 'a'));
  EXPECT_FALSE(client().http().Get("/api/runs/1")->get_header_value("X-Request-Id").empty());
}

}  // namespace
}  // namespace subpixel::tests
