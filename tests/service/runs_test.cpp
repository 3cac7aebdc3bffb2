// Runs: what a request may say, what comes back, progress events, cancelling.
#include <set>

#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

struct Event {
  std::string name, id;
  json data;
};

// All events until the stream ends or `stop_at` of them arrived.
std::vector<Event> read_events(int port, std::int64_t run, const std::string& last_id = "",
                               std::size_t stop_at = 100'000) {
  Client client(port);
  std::vector<Event> events;
  std::string pending;
  const httplib::Headers headers = last_id.empty() ? httplib::Headers{} : httplib::Headers{{"Last-Event-ID", last_id}};
  client.http().Get("/api/runs/" + std::to_string(run) + "/events", headers, [&](const char* bytes, std::size_t size) {
    pending.append(bytes, size);
    for (std::size_t blank; (blank = pending.find("\n\n")) != std::string::npos; pending.erase(0, blank + 2)) {
      Event event;
      std::istringstream lines(pending.substr(0, blank));
      for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("event: ")) event.name = line.substr(7);
        if (line.starts_with("id: ")) event.id = line.substr(4);
        if (line.starts_with("data: ")) event.data = json::parse(line.substr(6));
      }
      if (!event.name.empty()) events.push_back(event);
    }
    return events.size() < stop_at;
  });
  return events;
}

class Runs : public ServiceTest {
 protected:
  json request(const std::string& capture) {
    return {{"capture", capture}, {"techniques", {{{"technique", "noaa"}}, {{"technique", "msaa"}}}}};
  }
  static std::string path(std::int64_t run) { return "/api/runs/" + std::to_string(run); }
};

TEST_F(Runs, RunToItsEndStoresEveryResult) {
  const std::string hash = client().upload_fake({{"title", "Two frames"}, {"frames", 2}});
  const httplib::Result started = client().post_run(request(hash));
  ASSERT_EQ(started->status, 201) << started->body;
  const std::int64_t id = json::parse(started->body).at("id");
  EXPECT_EQ(started->get_header_value("Location"), path(id));

  const json run = client().wait_for_end(id);
  EXPECT_EQ(run.at("status"), "done") << run;
  EXPECT_EQ(run.at("stored_results"), 4);
  EXPECT_EQ(run.at("expected_results"), 4);
  EXPECT_EQ(run.at("head").at("driver"), "fake");
  EXPECT_EQ(run.at("request").at("frames"), json({0, 1}));
  EXPECT_EQ(run.at("request").at("techniques").at(1).at("parameters").at("samples"), 8) << "defaults are filled in";

  const json results = client().get(path(id) + "/results.json");
  EXPECT_EQ(results.at("head").at("capture_title"), "Two frames");
  ASSERT_EQ(results.at("results").size(), 4u);
  const json& first = results.at("results").at(0);
  EXPECT_EQ(first.at("frame"), 0);
  EXPECT_EQ(first.at("technique"), "noaa");
  EXPECT_TRUE(first.at("images").contains("error"));

  const httplib::Result csv = client().http().Get(path(id) + "/results.csv");
  EXPECT_TRUE(csv->get_header_value("Content-Type").starts_with("text/csv"));
  EXPECT_EQ(std::ranges::count(csv->body, '\n'), 5) << csv->body;
}

TEST_F(Runs, BlobsAreImmutableAndTagged) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::int64_t run = client().start_run(hash);
  client().wait_for_end(run);
  const json images = client().get(path(run) + "/results.json").at("results").at(1).at("images");
  const std::map<std::string, std::string> types{
      {"image", "image/png"}, {"error", "image/png"}, {"hdr", "image/x-exr"}};
  for (const auto& [role, type] : types) {
    const httplib::Result blob = client().http().Get("/api/blobs/" + images.at(role).get<std::string>());
    ASSERT_EQ(blob->status, 200);
    EXPECT_EQ(blob->get_header_value("Content-Type"), type);
    EXPECT_NE(blob->get_header_value("Cache-Control").find("immutable"), std::string::npos);
    const httplib::Result again = client().http().Get("/api/blobs/" + images.at(role).get<std::string>(),
                                                      {{"If-None-Match", blob->get_header_value("ETag")}});
    EXPECT_EQ(again->status, 304);
    EXPECT_TRUE(again->body.empty());
  }
  EXPECT_TRUE(client().http().Get("/api/blobs/" + images.at("image").get<std::string>())->body.starts_with("\x89PNG"));
}

TEST_F(Runs, TechniquesAreTheRegistry) {
  std::set<std::string> names;
  const json registry = client().get("/api/techniques");
  for (const json& technique : registry.at("techniques")) {
    names.insert(technique.at("name").get<std::string>());
    for (const json& parameter : technique.at("parameters")) {
      for (const char* field : {"name", "kind", "doc", "unit", "default"}) EXPECT_TRUE(parameter.contains(field));
    }
  }
  EXPECT_TRUE(names.contains("noaa"));
  EXPECT_TRUE(names.contains("msaa"));
}

TEST_F(Runs, BrokenJsonIsNamedByLineAndColumn) {
  const auto where = [&](const std::string& body) {
    return error_of(client().http().Post("/api/runs", body, "application/json"), 400).at("where").get<std::string>();
  };
  EXPECT_EQ(where("{\n  \"capture\": \"x\",\n  oops\n}"), "line 3, column 3");
  EXPECT_EQ(where("{\"a\":1,}"), "line 1, column 8");
  EXPECT_EQ(where(""), "line 1, column 1");
  EXPECT_EQ(where("{\"a\": \"\xff\"}"), "line 1, column 8");
  EXPECT_EQ(where(std::string(500'000, '[')), "the body") << "nesting is bounded";
  EXPECT_EQ(where("[]"), "top level");
}

TEST_F(Runs, RequestsOutOfRangeAreNamedByField) {
  const std::string hash = client().upload_fake({{"frames", 3}});
  const auto refused = [&](const json& patch, const std::string& expected) {
    json body = request(hash);
    body.update(patch);
    const json error = error_of(client().post_run(body), 400);
    EXPECT_NE(error.dump().find(expected), std::string::npos) << patch << " gave " << error;
  };
  refused({{"width", 16385}, {"height", 10}}, "1 to 16384");
  refused({{"width", 0}, {"height", 10}}, "width");
  refused({{"width", 100}}, "width, height");
  refused({{"width", 1e300}, {"height", 10}}, "width");
  refused({{"width", -5}, {"height", 10}}, "width");
  refused({{"width", 4294967297}, {"height", 10}}, "width");
  refused({{"width", "10"}, {"height", 10}}, "width");
  refused({{"repeat", 0}}, "repeat");
  refused({{"repeat", 1001}}, "1 to 1000");
  refused({{"samples", 65}}, "samples");
  refused({{"samples", 7}}, "samples");
  refused({{"reference_samples", 1 << 20}}, "reference_samples");
  refused({{"reference_samples", 4100}}, "0 or a multiple of 4 from 4 to 4096");
  refused({{"reference_samples", 6}}, "6 is not 0 or a multiple of 4");
  refused({{"point_lights", 100'000}}, "point_lights");
  refused({{"every_light", 1}}, "every_light");
  refused({{"frames", {0, 3}}}, "<= 2");
  refused({{"frames", {2, 1}}}, "frames");
  refused({{"frames", {0}}}, "frames");
  refused({{"frames", "all"}}, "frames");
  refused({{"frames", {-1, 1}}}, "frames[0]");
  refused({{"skip", {{0, 0}}}}, "unknown field skip");
  refused({{"techniques", json::array()}}, "at least one");
  refused({{"techniques", "msaa"}}, "techniques");
  refused({{"techniques", {{{"technique", "msaa"}}, {{"technique", "msaa"}, {"parameters", {{"samples", 8}}}}}}},
          "twice");
  EXPECT_TRUE(client().get("/api/runs").at("runs").empty());
}

TEST_F(Runs, UnknownTechniquesAndParametersNameTheValidOnes) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const auto why = [&](const json& technique) {
    return error_of(client().post_run({{"capture", hash}, {"techniques", {technique}}}), 400).dump();
  };
  const std::string unknown = why({{"technique", "msa"}});
  EXPECT_NE(unknown.find("noaa"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("msaa"), std::string::npos) << unknown;
  const std::string parameter = why({{"technique", "msaa"}, {"parameters", {{"sample", 8}}}});
  EXPECT_NE(parameter.find("samples"), std::string::npos) << parameter;
  const std::string value = why({{"technique", "msaa"}, {"parameters", {{"samples", 5}}}});
  EXPECT_NE(value.find("16"), std::string::npos) << value;
  why({{"technique", "msaa"}, {"parameters", {{"samples", {1, 2}}}}});
  why({{"technique", "msaa"}, {"parameters", {{"samples", nullptr}}}});
  why({{"technique", "msaa"}, {"param", 1}});
  why({{"technique", std::string(100'000, 'x')}});
  why("msaaa");
  why(7);
}

TEST_F(Runs, UnknownCaptureAndWrongTypeOfBody) {
  error_of(client().post_run(request(std::string(32, '0'))), 404);
  error_of(client().post_run(request("../../etc/passwd")), 404);
  error_of(client().http().Post("/api/runs", "{}", "text/plain"), 415);
}

TEST_F(Runs, ListIsPagedNewestFirst) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  std::vector<std::int64_t> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(client().start_run(hash));
  json page = client().get("/api/runs?limit=2");
  ASSERT_EQ(page.at("runs").size(), 2u);
  EXPECT_EQ(page.at("runs").at(0).at("id"), ids[4]);
  std::size_t seen = 2;
  while (!page.at("next_before").is_null()) {
    page = client().get("/api/runs?limit=2&before=" + page.at("next_before").dump());
    EXPECT_FALSE(page.at("runs").empty());
    seen += page.at("runs").size();
  }
  EXPECT_EQ(seen, 5u);
  EXPECT_EQ(client().get("/api/runs?capture=" + std::string(32, '0')).at("runs").size(), 0u);
  for (const char* query : {"limit=0", "limit=201", "limit=-1", "limit=x", "before=0", "before=99999999999999999999"}) {
    error_of(client().http().Get("/api/runs?" + std::string(query)), 400);
  }
  for (const std::int64_t id : ids) client().wait_for_end(id);
}

TEST_F(Runs, EventsTellEveryResultAndTheEnd) {
  const std::string hash = client().upload_fake({{"frames", 3}, {"result_ms", 20}});
  const std::int64_t run = client().start_run(hash);
  const std::vector<Event> events = read_events(port(), run);
  std::vector<std::string> ids;
  bool progress_seen = false;
  for (const Event& event : events) {
    if (event.name == "result") ids.push_back(event.id);
    if (event.name == "status" && event.data.at("progress").is_object()) progress_seen = true;
  }
  EXPECT_EQ(ids, (std::vector<std::string>{"1", "2", "3", "4", "5", "6"}));
  EXPECT_TRUE(progress_seen);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().name, "end");
  EXPECT_EQ(events.back().data.at("status"), "done");
}

TEST_F(Runs, EventsResumeAfterTheLastOneSeen) {
  const std::string hash = client().upload_fake({{"frames", 4}, {"result_ms", 20}});
  const std::int64_t run = client().start_run(hash);
  std::string last;
  for (const Event& event : read_events(port(), run, "", 5)) {
    if (event.name == "result") last = event.id;
  }
  std::vector<std::string> rest;
  for (const Event& event : read_events(port(), run, last)) {
    if (event.name == "result") rest.push_back(event.id);
  }
  ASSERT_FALSE(rest.empty());
  EXPECT_EQ(std::stoi(rest.front()), (last.empty() ? 0 : std::stoi(last)) + 1);
  EXPECT_EQ(rest.back(), "8");
  const std::vector<Event> after_the_end = read_events(port(), run, "8");
  ASSERT_EQ(after_the_end.size(), 2u);
  EXPECT_EQ(after_the_end.back().name, "end");
  error_of(client().http().Get(path(run) + "/events", {{"Last-Event-ID", "x"}}), 400);
}

TEST_F(Runs, ManyFollowersLeaveRoomForOthers) {
  server::ServiceOptions few = options();
  few.http.followers = 48;
  start(few);
  const std::string hash = client().upload_fake({{"frames", 1}, {"result_ms", 60'000}});
  const std::int64_t run = client().start_run(hash);
  std::atomic<bool> stop{false};
  std::atomic<int> following{0}, refused{0};
  std::vector<std::thread> followers;
  for (int i = 0; i < 60; ++i) {
    followers.emplace_back([&] {
      Client mine(port());
      bool counted = false;
      const httplib::Result result = mine.http().Get(
          path(run) + "/events",
          [&](const httplib::Response& response) {
            if (response.status != 200) ++refused;
            return response.status == 200;
          },
          [&](const char*, std::size_t) {
            if (!std::exchange(counted, true)) ++following;
            return !stop;
          });
    });
  }
  for (int i = 0; i < 500 && following + refused < 60; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(following, 48);
  EXPECT_EQ(refused, 12);
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
  stop = true;
  client().http().Post(path(run) + "/cancel", "", "application/json");
  for (std::thread& follower : followers) follower.join();
}

TEST_F(Runs, CancelEndsARunningRunAndKeepsItsResults) {
  const std::string hash = client().upload_fake({{"frames", 50}, {"result_ms", 40}});
  const std::int64_t run = client().start_run(hash);
  const std::int64_t waiting = client().start_run(hash);
  while (client().get(path(run)).at("stored_results") < 2) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(client().http().Post(path(waiting) + "/cancel", "", "application/json")->status, 202);
  EXPECT_EQ(client().get(path(waiting)).at("status"), "cancelled") << "a queued run ends at once";
  EXPECT_EQ(client().http().Post(path(run) + "/cancel", "", "application/json")->status, 202);
  const json ended = client().wait_for_end(run, std::chrono::seconds(5));
  EXPECT_EQ(ended.at("status"), "cancelled");
  EXPECT_GE(ended.at("stored_results"), 2);
  EXPECT_FALSE(client().get(path(run) + "/results.json").at("results").empty());
  error_of(client().http().Post(path(run) + "/cancel", "", "application/json"), 409);
  EXPECT_EQ(client().http().Delete(path(run))->status, 204);
  client().get(path(run), 404);
}

TEST_F(Runs, ReadersAreServedWhileResultsAreStored) {
  const std::string hash = client().upload_fake({{"frames", 20}});
  const std::int64_t run = client().start_run(hash);
  std::atomic<bool> ended{false};
  std::atomic<int> answers{0}, failures{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 8; ++i) {
    readers.emplace_back([&] {
      Client mine(port());
      while (!ended) {
        for (const std::string& what : {std::string("/api/runs"), path(run) + "/results.json",
                                        path(run) + "/results.csv", std::string("/api/captures"), std::string("/")}) {
          const httplib::Result result = mine.http().Get(what);
          ++(result && result->status == 200 ? answers : failures);
        }
      }
    });
  }
  EXPECT_EQ(client().wait_for_end(run).at("status"), "done");
  ended = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(failures, 0);
  EXPECT_GT(answers, 40);
}

}  // namespace
}  // namespace subpixel::tests
