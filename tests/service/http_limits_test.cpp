// What hostile or broken clients send, byte by byte, and what keeps other sites' pages out.
#include "base/error.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

using Http = ServiceTest;

std::string status_line(const std::string& answer) {
  return answer.substr(0, answer.find("\r\n"));
}

std::string with_header(const std::string& header) {
  return "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + header + "\r\n\r\n";
}

TEST_F(Http, LongHeaderLineIsRefusedAtItsLimit) {
  client();
  EXPECT_EQ(status_line(raw_exchange(port(), with_header("X-Long: " + std::string(4086, 'a')))), "HTTP/1.1 200 OK");
  const std::string refused = raw_exchange(port(), with_header("X-Long: " + std::string(4087, 'a')));
  EXPECT_TRUE(refused.starts_with("HTTP/1.1 431")) << refused;
  EXPECT_NE(refused.find("more than 4096 bytes"), std::string::npos);
}

// An endless line must not be collected before it is refused.
TEST_F(Http, EndlessHeaderLineAndEndlessUrlAreCutOff) {
  client();
  const std::string endless(50'000'000, 'a');
  const std::string line = raw_exchange(port(), "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + endless);
  EXPECT_TRUE(line.starts_with("HTTP/1.1 431")) << status_line(line);
  const std::string url = raw_exchange(port(), "GET /" + endless);
  EXPECT_TRUE(url.starts_with("HTTP/1.1 431")) << status_line(url);
}

TEST_F(Http, ManyHeadersAreRefused) {
  client();
  std::string headers;
  for (int i = 0; i < 100'000; ++i) headers += "X-" + std::to_string(i) + ": 1\r\n";
  const std::string answer = raw_exchange(port(), with_header(headers + "X: 1"));
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 431")) << status_line(answer);
}

TEST_F(Http, SlowHeaderIsRefused) {
  server::ServiceOptions slow = options();
  slow.http.header_time = std::chrono::milliseconds(200);
  start(slow);
  const std::string answer = raw_exchange(port(), "GET / HTTP/1.1\r\nHost: 127");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 408")) << status_line(answer);
}

TEST_F(Http, SilentConnectionIsClosed) {
  server::ServiceOptions slow = options();
  slow.http.idle_time = std::chrono::milliseconds(200);
  start(slow);
  EXPECT_EQ(raw_exchange(port(), ""), "");
}

TEST_F(Http, GarbageGetsAnErrorDocumentOrTheEndOfTheConnection) {
  client();
  for (const std::string& garbage :
       {std::string("\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("\0\0\0\0\r\n\r\n", 8),
        std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 15), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("GET http:// HTTP/1.1\r\n\r\n"), std::string("DELETE * HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")}) {
    const std::string answer = raw_exchange(port(), garbage, true);
    EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 4")) << answer;
  }
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
}

TEST_F(Http, RangesAreIgnoredHoweverMany) {
  client();
  std::string ranges = "Range: bytes=0-0";
  for (int i = 0; i < 700; ++i) ranges += ",0-0";
  const std::string answer = raw_exchange(port(), with_header(ranges));
  EXPECT_EQ(status_line(answer), "HTTP/1.1 200 OK");
  EXPECT_NE(answer.find("\"status\":\"ok\""), std::string::npos);
}

TEST_F(Http, BodiesWithoutKnownLengthAreRefused) {
  client();
  const std::string chunked = "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n";
  EXPECT_TRUE(raw_exchange(port(), chunked + "5\r\nFAKE \r\n0\r\n\r\n").starts_with("HTTP/1.1 411"));
  for (const char* length : {"-1", "12abc", "0x10", "99999999999999999999999", ""}) {
    const std::string answer = raw_exchange(
        port(),
        "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: " + std::string(length) + "\r\n\r\nFAKE {}");
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 4")) << length << ": " << answer;
  }
}

// Two lengths are how one request is smuggled inside another.
TEST_F(Http, SeveralLengthsAreRefusedAndTheRestIsNoSecondRequest) {
  client();
  const std::string hidden = "DELETE /api/runs/1 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  const std::string answer =
      raw_exchange(port(), "POST /api/runs HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\nContent-Length: " +
                               std::to_string(hidden.size()) + "\r\n\r\n" + hidden);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 400")) << answer;
  EXPECT_EQ(answer.find("HTTP/1.1", 8), std::string::npos) << "one answer only";
}

TEST_F(Http, BodyOfARefusedRequestIsNoSecondRequest) {
  client();
  const std::string hidden = "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  for (const char* path : {"/api/nothing", "/api/runs/1/cancel", "/api/runs"}) {
    const std::string answer =
        raw_exchange(port(), "POST " + std::string(path) + " HTTP/1.1\r\nHost: 127.0.0.1\r\n" +
                                 "Content-Length: " + std::to_string(hidden.size()) + "\r\n\r\n" + hidden);
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 4")) << answer;
    EXPECT_EQ(answer.find("HTTP/1.1", 8), std::string::npos) << path << ": one answer only";
  }
}

TEST_F(Http, RequestsOneAfterTheOtherShareAConnection) {
  client();
  const std::string one = "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  const std::string answer = raw_exchange(port(), one + one + one, true);
  std::size_t answers = 0;
  for (std::size_t at = 0; (at = answer.find("HTTP/1.1 200", at)) != std::string::npos; ++at) ++answers;
  EXPECT_EQ(answers, 3u);
}

TEST_F(Http, LargeBodiesAreOnlyTakenForCaptures) {
  const std::string large(3 << 20, '[');
  error_of(client().http().Post("/api/runs", large, "application/json"), 413);
  error_of(client().http().Post("/api/nothing", large, "application/json"), 413);
}

TEST_F(Http, UnknownPathsAndMethodsAreErrors) {
  error_of(client().http().Get("/api/nothing"), 404);
  error_of(client().http().Get("/../../etc/passwd"), 404);
  error_of(client().http().Get("/%2e%2e/%2e%2e/etc/passwd"), 404);
  error_of(client().http().Get("/api/captures/nothex"), 404);
  error_of(client().http().Get("/api/captures/" + std::string(32, '0')), 404);
  error_of(client().http().Get("/api/runs/999999999999999999"), 404);
  error_of(client().http().Put("/api/runs", "{}", "application/json"), 405);
  error_of(client().http().Patch("/api/runs", "{}", "application/json"), 405);
  error_of(client().http().Post("/", "{}", "application/json"), 404);
}

// DNS rebinding: a page's own name is pointed at this machine, so that its requests count as from the same site.
TEST_F(Http, OnlyNamesOfThisServiceAreAnswered) {
  server::ServiceOptions named = options();
  named.host_names = {"measure.example"};
  start(named);
  const auto status_for = [&](const std::string& host) {
    return status_line(raw_exchange(port(), "GET /api/health HTTP/1.1\r\n" + host + "Connection: close\r\n\r\n"));
  };
  for (const char* good : {"Host: 127.0.0.1\r\n", "Host: localhost:8080\r\n", "Host: [::1]:8080\r\n",
                           "Host: 192.0.2.7\r\n", "Host: measure.example:80\r\n"}) {
    EXPECT_EQ(status_for(good), "HTTP/1.1 200 OK") << good;
  }
  for (const char* bad :
       {"", "Host: evil.example\r\n", "Host: localhost.evil.example\r\n", "Host: 127.0.0.1.evil.example\r\n",
        "Host: \r\n", "Host: 127.0.0.1\r\nHost: evil.example\r\n"}) {
    EXPECT_TRUE(status_for(bad).starts_with("HTTP/1.1 421")) << bad;
  }
}

TEST_F(Http, OtherSitesPagesCanNotChangeAnything) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::string own = "http://127.0.0.1:" + std::to_string(port());
  for (const httplib::Headers& headers :
       {httplib::Headers{{"Origin", "http://evil.example"}}, httplib::Headers{{"Origin", "null"}},
        httplib::Headers{{"Origin", own + "1"}}, httplib::Headers{{"Sec-Fetch-Site", "cross-site"}},
        httplib::Headers{{"Sec-Fetch-Site", "same-site"}}}) {
    error_of(client().http().Post("/api/captures", headers, fake_capture({{"frames", 2}}), "text/plain"), 403);
    error_of(client().http().Delete("/api/captures/" + hash, headers), 403);
  }
  EXPECT_EQ(
      client().http().Delete("/api/captures/" + hash, {{"Origin", own}, {"Sec-Fetch-Site", "same-origin"}})->status,
      204);
}

TEST_F(Http, AnswersForbidWhatTheViewerDoesNotNeed) {
  const httplib::Result page = client().http().Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_NE(page->get_header_value("Content-Security-Policy").find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_FALSE(page->has_header("Access-Control-Allow-Origin"));
  const httplib::Result again = client().http().Get("/", {{"If-None-Match", page->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
}

TEST(Address, TakenPortIsAnError) {
  const TemporaryFolder folder;
  const RunningService first(test_options(folder.path() / "first"));
  server::ServiceOptions second = test_options(folder.path() / "second");
  second.port = first.port();
  EXPECT_THROW(server::Service{second}, UsageError);
}

TEST(DataFolder, HasOneServiceAtATime) {
  const TemporaryFolder folder;
  const RunningService first(test_options(folder.path() / "data"));
  EXPECT_THROW(server::Service{test_options(folder.path() / "data")}, InputError);
}

}  // namespace
}  // namespace subpixel::tests
