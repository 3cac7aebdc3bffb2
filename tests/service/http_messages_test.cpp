// Forms of requests that are seldom and right: no length, whole addresses as targets, any case, HEAD, ranges.
#include <fmt/format.h>

#include <map>

#include "base/error.hpp"
#include "server/own_names.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

struct Answer {
  std::string status_line, body;
  std::multimap<std::string, std::string> headers;

  std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? "" : found->second;
  }
  bool is(int status) const { return status_line.starts_with("HTTP/1.1 " + std::to_string(status)); }
};

Answer parse(const std::string& text) {
  Answer answer;
  const std::size_t end = text.find("\r\n\r\n");
  if (end == std::string::npos) return answer;
  answer.body = text.substr(end + 4);
  std::istringstream lines(text.substr(0, end));
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    const std::size_t colon = line.find(": ");
    if (answer.status_line.empty()) {
      answer.status_line = line;
    } else if (colon != std::string::npos && !line.starts_with("X-Request-Id: ")) {  // which no two answers share
      answer.headers.emplace(line.substr(0, colon), line.substr(colon + 2));
    }
  }
  return answer;
}

class HttpMessages : public ServiceTest {
 protected:
  // `head` without Host and Connection, which are added.
  Answer ask(const std::string& head, const std::string& host = "127.0.0.1") {
    client();
    return parse(raw_exchange(port(), head + "Host: " + host + "\r\nConnection: close\r\n\r\n"));
  }
  Answer get(const std::string& path, const std::string& headers = "") {
    return ask("GET " + path + " HTTP/1.1\r\n" + headers);
  }
};

TEST_F(HttpMessages, PostWithoutLengthHasNoBody) {
  const std::string hash = client().upload_fake({{"frames", 1}, {"fail_at", 0}, {"how", "hang"}});
  const std::string path = "/api/runs/" + std::to_string(client().start_run(hash)) + "/cancel";
  const Answer cancelled = ask("POST " + path + " HTTP/1.1\r\n");
  EXPECT_TRUE(cancelled.is(202)) << cancelled.status_line << cancelled.body;
  EXPECT_TRUE(ask("POST /api/captures?name=a HTTP/1.1\r\n").is(422));
  EXPECT_TRUE(ask("POST /api/runs HTTP/1.1\r\nContent-Type: application/json\r\n").is(400));
  // What follows its header is the next request.
  const std::string both = raw_exchange(port(), "POST " + path +
                                                    " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\nGET /api/health HTTP/1.1\r\n"
                                                    "Host: 127.0.0.1\r\nConnection: close\r\n\r\n");
  EXPECT_NE(both.find("HTTP/1.1 200"), std::string::npos) << both;
}

TEST_F(HttpMessages, HeadSaysWhatGetSays) {
  const std::string hash = client().upload_fake({{"frames", 2}});
  const std::int64_t run = client().start_run(hash);
  client().wait_for_end(run);
  const std::string of_run = "/api/runs/" + std::to_string(run);
  const json results = client().get(of_run + "/results.json");
  const std::string blob = results["results"][0]["images"]["image"];
  for (const std::string& path :
       {std::string("/"), std::string("/api/techniques"), "/api/captures/" + hash, "/api/captures/" + hash + "/file",
        "/api/blobs/" + blob, of_run, of_run + "/results.csv", of_run + "/plot.svg", std::string("/api/nothing"),
        std::string("/api/runs/x")}) {
    const Answer whole = get(path), head = ask("HEAD " + path + " HTTP/1.1\r\n");
    EXPECT_EQ(head.status_line, whole.status_line) << path;
    EXPECT_EQ(head.headers, whole.headers) << path;
    EXPECT_EQ(head.header("Content-Length"), std::to_string(whole.body.size())) << path;
    EXPECT_EQ(head.body, "") << path;
  }
}

// Both were found by server/fuzz.
TEST_F(HttpMessages, MalformedRangesAreIgnored) {
  for (const char* const range : {"bytes=-1,2-,5-4", "bytes=", "bytes=x-", "parts=0-1", "bytes=5-4"}) {
    const Answer answer = get("/api/health", fmt::format("rAnge: {}\r\n", range));
    EXPECT_TRUE(answer.is(200)) << range << answer.status_line;
    EXPECT_TRUE(json::accept(answer.body)) << range << answer.body;
  }
  // After a line that ends in LF alone, which the library drops.
  const Answer after = get("/api/health", "C\nRange: bytes=0-3\r\n");
  EXPECT_TRUE(after.is(200) && json::accept(after.body)) << after.body;
}

TEST_F(HttpMessages, RefusalsBeforeTheBodySayTheirLength) {
  const Answer answer = ask("OPTIONS /api/runs HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 258\r\n");
  EXPECT_TRUE(answer.is(405)) << answer.status_line;
  EXPECT_EQ(answer.header("Content-Length"), std::to_string(answer.body.size()));
}

TEST_F(HttpMessages, HostInAnyCaseAndForm) {
  for (const char* const good : {"LOCALHOST", "LocalHost:8080", "localhost.", "[::1]", "[::1]:80", "[2001:DB8::1]:443",
                                 "127.0.0.1:", "10.0.0.1:65535"}) {
    EXPECT_TRUE(ask("GET /api/health HTTP/1.1\r\n", good).is(200)) << good;
  }
  for (const char* const bad : {"[::1", "[::1]x", "[localhost]", "::1", "127.0.0.1:8080:1", "127.0.0.1:x",
                                "a@127.0.0.1", "localhost:123456", "local host", "."}) {
    EXPECT_TRUE(ask("GET /api/health HTTP/1.1\r\n", bad).is(421)) << bad;
  }
}

TEST_F(HttpMessages, WholeAddressesAreTargets) {
  for (const char* const target : {"http://127.0.0.1:8080/api/health", "HTTP://localhost/api/health",
                                   "http://127.0.0.1/api/health?x=1", "http://[::1]:1/api/health"}) {
    const Answer answer = ask(std::string("GET ") + target + " HTTP/1.1\r\n");
    EXPECT_TRUE(answer.is(200)) << target;
    EXPECT_NE(answer.body.find("\"status\":\"ok\""), std::string::npos) << target;
  }
  EXPECT_NE(ask("GET http://127.0.0.1 HTTP/1.1\r\n").body.find("<html"), std::string::npos);
  EXPECT_NE(ask("GET http://127.0.0.1?a=b HTTP/1.1\r\n").body.find("<html"), std::string::npos);
  EXPECT_EQ(json::parse(ask("GET http://127.0.0.1/api/runs?limit=0 HTTP/1.1\r\n").body)["error"]["where"], "limit");
  // The target's name counts, not the Host's, and Host must be there all the same.
  for (const char* const evil : {"http://evil.example/api/health", "http://user@127.0.0.1/api/health", "http://",
                                 "http:///api/health", "http://127.0.0.1:8080:1/api/health"}) {
    EXPECT_TRUE(ask(std::string("GET ") + evil + " HTTP/1.1\r\n").is(421)) << evil;
  }
  EXPECT_TRUE(ask("GET http://127.0.0.1/api/health HTTP/1.1\r\n", "evil.example").is(200));
  EXPECT_TRUE(parse(raw_exchange(port(), "GET http://127.0.0.1/api/health HTTP/1.1\r\n\r\n", true)).is(421));
  EXPECT_TRUE(ask("GET http://127.0.0.1/api/health HTTP/1.1\r\nHost: localhost\r\n").is(421));
  EXPECT_TRUE(ask("GET https://127.0.0.1/api/health HTTP/1.1\r\n").is(404));
  // Its pages' origin is that of the target's name.
  const std::string post = "POST http://127.0.0.1/api/runs/1/cancel HTTP/1.1\r\nOrigin: http://";
  EXPECT_TRUE(ask(post + "127.0.0.1\r\n").is(404));
  EXPECT_TRUE(ask(post + "localhost\r\n", "localhost").is(403));
}

TEST_F(HttpMessages, PartsOfCapturesAndBlobs) {
  const std::string bytes = fake_capture({{"frames", 1}});
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::int64_t run = client().start_run(hash);
  client().wait_for_end(run);
  const json results = client().get("/api/runs/" + std::to_string(run) + "/results.json");
  const std::string blob = "/api/blobs/" + results["results"][0]["images"]["image"].get<std::string>();
  for (const std::string& path : {"/api/captures/" + hash + "/file", blob}) {
    SCOPED_TRACE(path);
    const Answer whole = get(path);
    ASSERT_TRUE(whole.is(200));
    EXPECT_EQ(whole.header("Accept-Ranges"), "bytes");
    const std::string size = std::to_string(whole.body.size()), last = std::to_string(whole.body.size() - 1);
    const auto expect_part = [&](const std::string& range, std::size_t first, std::size_t end) {
      const Answer part = get(path, "Range: bytes=" + range + "\r\n");
      EXPECT_TRUE(part.is(206)) << range << part.status_line;
      EXPECT_EQ(part.body, whole.body.substr(first, end - first)) << range;
      EXPECT_EQ(part.header("Content-Length"), std::to_string(end - first)) << range;
      EXPECT_EQ(part.header("Content-Range"),
                "bytes " + std::to_string(first) + "-" + std::to_string(end - 1) + "/" + size)
          << range;
      EXPECT_EQ(part.header("ETag"), whole.header("ETag"));
    };
    expect_part("0-0", 0, 1);
    expect_part("3-5", 3, 6);
    expect_part("4-", 4, whole.body.size());
    expect_part("-4", whole.body.size() - 4, whole.body.size());
    expect_part("-99999", 0, whole.body.size());
    expect_part("1-99999", 1, whole.body.size());
    expect_part(fmt::format("{0}-{0}", last), whole.body.size() - 1, whole.body.size());
    for (const std::string& beyond :
         {fmt::format("{}-", size), fmt::format("{0}-{0}", size), std::string("-0"), std::string("99999-")}) {
      const Answer refused = get(path, "Range: bytes=" + beyond + "\r\n");
      EXPECT_TRUE(refused.is(416)) << beyond << refused.status_line;
      EXPECT_EQ(refused.header("Content-Range"), "bytes */" + size) << beyond;
    }
    // Several at once, and what is meant for another version, are answered with the whole.
    const std::string tag = whole.header("ETag");
    EXPECT_EQ(get(path, "Range: bytes=0-0,2-3\r\n").body, whole.body);
    EXPECT_EQ(get(path, "Range: bytes=0-0\r\nRange: bytes=1-1\r\n").body, whole.body);
    EXPECT_EQ(get(path, "Range: bytes=0-0\r\nIf-Range: \"other\"\r\n").body, whole.body);
    EXPECT_EQ(get(path, "Range: bytes=0-0\r\nIf-Range: W/" + tag + "\r\n").body, whole.body);
    EXPECT_EQ(get(path, "Range: bytes=0-0\r\nIf-Range: " + tag + "\r\n").body, whole.body.substr(0, 1));
    EXPECT_TRUE(get(path, "If-None-Match: " + tag + "\r\n").is(304));
    // A HEAD has no range.
    const Answer head = ask("HEAD " + path + " HTTP/1.1\r\nRange: bytes=0-0\r\n");
    EXPECT_TRUE(head.is(200));
    EXPECT_EQ(head.headers, whole.headers);
  }
  EXPECT_EQ(get("/api/captures/" + hash + "/file").body, bytes);
  EXPECT_EQ(get("/api/health", "Range: bytes=0-0\r\n").header("Accept-Ranges"), "none");
}

TEST_F(HttpMessages, EventsOfAnOldClientEndWithTheConnection) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::int64_t run = client().start_run(hash);
  client().wait_for_end(run);
  const Answer answer = parse(raw_exchange(port(), "GET /api/runs/" + std::to_string(run) +
                                                       "/events HTTP/1.0\r\nHost: 127.0.0.1\r\n"
                                                       "Connection: Keep-Alive\r\n\r\n"));
  EXPECT_TRUE(answer.is(200));
  EXPECT_EQ(answer.header("Transfer-Encoding"), "");
  EXPECT_EQ(answer.header("X-Accel-Buffering"), "no");
  EXPECT_TRUE(answer.body.starts_with("id: 1\nevent: result\n")) << answer.body.substr(0, 100);
  EXPECT_NE(answer.body.find("\nevent: end\n"), std::string::npos);
}

TEST(OwnNames, AProxysNameIsAnOrigin) {
  const server::OwnNames names("0.0.0.0", {"Perf.Example", "other.example:8443"});
  const std::string upstream = "127.0.0.1:18090";
  for (const char* const good : {"http://perf.example", "https://perf.example", "HTTP://PERF.example:80",
                                 "https://perf.example:443", "https://other.example:8443", "http://127.0.0.1:18090"}) {
    EXPECT_TRUE(names.is_own_origin(good, upstream)) << good;
  }
  for (const char* const bad :
       {"http://perf.example:8080", "http://perf.example:443", "http://perf.example.evil.example",
        "http://xperf.example", "http://evil.example", "https://other.example", "http://other.example:80",
        "http://127.0.0.1", "null", "", "ftp://perf.example", "http://perf.example/",
        "http://perf.example@evil.example", "http://perf.example, x"}) {
    EXPECT_FALSE(names.is_own_origin(bad, upstream)) << bad;
  }
  EXPECT_TRUE(names.is_own_host("PERF.example:9"));
  EXPECT_FALSE(names.is_own_host("perf.example.evil.example"));
  EXPECT_THROW(server::OwnNames("127.0.0.1", {"perf example"}), UsageError);
  EXPECT_THROW(server::OwnNames("127.0.0.1", {"http://perf.example"}), UsageError);
}

}  // namespace
}  // namespace subpixel::tests
