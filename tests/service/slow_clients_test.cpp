// Clients that send and read slowly or not at all: they get what they came for, and nobody else waits for them. The
// full number of them is scripts/slow_clients.py's.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "base/hash.hpp"
#include "server/header_scan.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// A connection that does nothing by itself.
class RawClient {
 public:
  explicit RawClient(int port, const std::string& first_words = "") : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval timeout{20, 0};
    const int small = 4096, yes = 1;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &small, sizeof(small));
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    send(first_words);
  }
  ~RawClient() { ::close(socket_); }
  RawClient(RawClient&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  RawClient& operator=(RawClient&&) = delete;

  void send(const std::string& bytes) {
    if (!bytes.empty()) ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  // What comes until the other side closes, or until `stop` has come.
  std::string receive(const std::string& stop = "") {
    std::string answer;
    char block[65536];
    while (stop.empty() || answer.find(stop) == std::string::npos) {
      const ssize_t got = ::recv(socket_, block, sizeof(block), 0);
      if (got <= 0) break;
      answer.append(block, static_cast<std::size_t>(got));
    }
    return answer;
  }

 private:
  int socket_;
};

using RawClients = std::vector<RawClient>;

std::string get_request(const std::string& path) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n";
}

std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

std::vector<double> answer_times(int port, int rounds) {
  std::vector<double> seconds;
  for (int i = 0; i < rounds; ++i) {
    for (const char* const path : {"/api/health", "/api/runs"}) {
      const auto start = Clock::now();
      const std::string answer = raw_exchange(port, get_request(path));
      seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
      EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << path << ": " << answer;
    }
  }
  std::ranges::sort(seconds);
  return seconds;
}

double resident_megabytes(int process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  return 1e9;
}

std::size_t descriptors(int process) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator("/proc/" + std::to_string(process) + "/fd"), fs::directory_iterator()));
}

// A capture of some megabytes, so that its file fills the sockets of one who does not read.
std::string large_capture() {
  return fake_capture({{"frames", 1}}) + std::string(6'000'000, 'x');
}

TEST(SlowClients, NobodyWaitsForThem) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_max < 4096) GTEST_SKIP() << "too few descriptors are allowed here";
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  const TemporaryFolder folder;
  const ServiceProcess service(folder.path() / "data");
  const int port = service.port();
  const std::string capture = large_capture();
  const std::string hash = Client(port).upload_fake({{"frames", 1}});
  const httplib::Result large = Client(port).upload(capture);
  ASSERT_EQ(large->status, 201) << large->body;
  const std::string file = "/api/captures/" + json::parse(large->body).at("hash").get<std::string>() + "/file";
  const std::string small_capture = fake_capture({{"frames", 3}});
  const std::string upload =
      "POST /api/captures?name=a HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n"
      "Content-Length: " +
      std::to_string(small_capture.size()) + "\r\n\r\n";

  RawClients idle, headers, uploads, readers;
  for (int i = 0; i < 300; ++i) idle.emplace_back(port);
  for (int i = 0; i < 100; ++i) uploads.emplace_back(port, upload + small_capture.substr(0, 4));
  for (int i = 0; i < 100; ++i) readers.emplace_back(port, get_request(file));
  for (int i = 0; i < 300; ++i) headers.emplace_back(port, get_request("/api/health").substr(0, 30));

  const std::vector<double> seconds = answer_times(port, 20);
  EXPECT_LT(seconds[seconds.size() / 2], 1.0);
  EXPECT_LT(seconds.back(), 5.0);
  EXPECT_LT(resident_megabytes(service.id()), 300.0);
  EXPECT_GT(descriptors(service.id()), 800u) << "all of them are connected";
  EXPECT_LT(descriptors(service.id()), 800u + 200u + 256u);

  // And each still gets what it came for.
  headers.front().send(get_request("/api/health").substr(30));
  EXPECT_TRUE(headers.front().receive().starts_with("HTTP/1.1 200"));
  for (const char byte : small_capture.substr(4)) uploads.front().send(std::string(1, byte));
  const std::string uploaded = uploads.front().receive();
  EXPECT_TRUE(uploaded.starts_with("HTTP/1.1 201")) << uploaded;
  EXPECT_TRUE(body_of(readers.front().receive()) == capture);
  idle.front().send(get_request("/api/captures/" + hash));
  EXPECT_TRUE(idle.front().receive().starts_with("HTTP/1.1 200"));
}

using SlowClient = ServiceTest;

TEST_F(SlowClient, ByteByByteIsUnderstood) {
  client();
  RawClient slow(port());
  const std::string body = R"({"capture": "x"})";
  const std::string requests =
      "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
      "POST /api/runs HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
      "Content-Length: " +
      std::to_string(body.size()) + "\r\n\r\n" + body + get_request("/api/limits");
  for (const char byte : requests) slow.send(std::string(1, byte));
  const std::string answer = slow.receive();
  const std::size_t second = answer.find("HTTP/1.1 400"), third = answer.find("HTTP/1.1 200", 8);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << answer;
  EXPECT_NE(answer.find("\"limits\""), std::string::npos);
  EXPECT_LT(second, third) << answer;
}

TEST_F(SlowClient, BodyThatWaitsToBeAskedForIsAskedForUnlessRefused) {
  client();
  const std::string capture = fake_capture({{"frames", 2}});
  const auto expecting = [&](std::size_t length, const std::string& more = "") {
    return "POST /api/captures?name=a HTTP/1.1\r\nHost: 127.0.0.1\r\nExpect: 100-continue\r\nConnection: close\r\n" +
           more + "Content-Length: " + std::to_string(length) + "\r\n\r\n";
  };
  RawClient polite(port(), expecting(capture.size()));
  EXPECT_EQ(polite.receive("\r\n\r\n"), "HTTP/1.1 100 Continue\r\n\r\n");
  polite.send(capture);
  EXPECT_TRUE(polite.receive().starts_with("HTTP/1.1 201"));
  EXPECT_TRUE(RawClient(port(), expecting(1u << 30)).receive().starts_with("HTTP/1.1 413"));
  EXPECT_TRUE(RawClient(port(), expecting(9, "Origin: http://evil.example\r\n")).receive().starts_with("HTTP/1.1 403"));
}

TEST_F(SlowClient, BodyThatStopsIsToldSo) {
  server::ServiceOptions slow = options();
  slow.http.idle_time = std::chrono::milliseconds(300);
  start(slow);
  RawClient stopping(port(), "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000\r\n\r\nFAKE");
  const std::string answer = stopping.receive();
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 400")) << answer;
  EXPECT_NE(answer.find("4 of 1000 bytes"), std::string::npos) << answer;
}

TEST_F(SlowClient, WhoDoesNotReadIsLeft) {
  server::ServiceOptions slow = options();
  slow.http.idle_time = std::chrono::milliseconds(300);
  slow.upload_limit_bytes = 1u << 24;
  start(slow);
  const std::string capture = large_capture();
  const std::string hash = json::parse(client().upload(capture)->body).at("hash");
  RawClient deaf(port(), get_request("/api/captures/" + hash + "/file"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_LT(deaf.receive().size(), capture.size());
}

// Images are larger than what is held in memory, so their way leads through a file.
TEST_F(SlowClient, LargeAnswersAreWhole) {
  const std::int64_t run = json::parse(client()
                                           .post_run({{"capture", client().upload_fake({{"frames", 1}})},
                                                      {"techniques", {{{"technique", "noaa"}}}},
                                                      {"width", 1280},
                                                      {"height", 720}})
                                           ->body)
                               .at("id");
  client().wait_for_end(run);
  const json results = client().get("/api/runs/" + std::to_string(run) + "/results.json").at("results");
  std::size_t largest = 0;
  for (const auto& [role, hash] : results.at(0).at("images").items()) {
    const std::string bytes =
        body_of(RawClient(port(), get_request("/api/blobs/" + hash.get<std::string>())).receive());
    EXPECT_EQ(content_hash_hex(std::as_bytes(std::span(bytes))), hash) << role;
    largest = std::max(largest, bytes.size());
  }
  EXPECT_GT(largest, std::size_t{1} << 19) << "more than is written at once";
}

TEST_F(SlowClient, IdleOnesGiveWayWhenThereAreTooMany) {
  server::ServiceOptions few = options();
  few.http.connections = 20;
  few.http.idle_time = std::chrono::seconds(20);
  few.upload_limit_bytes = 1u << 24;
  start(few);
  const std::string capture = large_capture();
  const std::string hash = json::parse(client().upload(capture)->body).at("hash");
  RawClient reader(port(), get_request("/api/captures/" + hash + "/file"));
  RawClients idle;
  for (int i = 0; i < 60; ++i) idle.emplace_back(port());
  EXPECT_LT(answer_times(port(), 2).back(), 5.0);
  const auto start = Clock::now();
  EXPECT_EQ(idle.front().receive(), "");
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(5)) << "the oldest was closed before its time";
  idle.back().send(get_request("/api/health"));
  EXPECT_TRUE(idle.back().receive().starts_with("HTTP/1.1 200"));
  EXPECT_TRUE(body_of(reader.receive()) == capture) << "one that gets an answer is no idle one";
}

// With two threads for all of them.
TEST_F(SlowClient, FollowersNeedNoThreads) {
  server::ServiceOptions few = options();
  few.http.threads = 2;
  start(few);
  const std::string hash = client().upload_fake({{"frames", 40}, {"result_ms", 10}});
  const std::string run = "/api/runs/" + std::to_string(client().start_run(hash));
  RawClients followers;
  for (int i = 0; i < 300; ++i) followers.emplace_back(port(), get_request(run + "/events"));
  EXPECT_LT(answer_times(port(), 5).back(), 5.0);
  const std::string first = followers.front().receive();
  EXPECT_EQ(first.substr(first.size() - 7), "\r\n0\r\n\r\n") << "the last chunk";
  for (int i = 1; i <= 80; ++i) {
    const std::size_t at = first.find("id: " + std::to_string(i) + "\n");
    EXPECT_NE(at, std::string::npos) << i;
    EXPECT_EQ(first.find("id: " + std::to_string(i) + "\n", at + 1), std::string::npos) << i << " came twice";
  }
  for (std::size_t i = 1; i < followers.size(); ++i) {
    EXPECT_NE(followers[i].receive().find("\nevent: end\n"), std::string::npos) << i;
  }
}

TEST_F(SlowClient, AnswersUnderWayAreFinishedAtTheEnd) {
  server::ServiceOptions large = options();
  large.upload_limit_bytes = 1u << 24;
  start(large);
  const std::string capture = large_capture();
  const std::string hash = json::parse(client().upload(capture)->body).at("hash");
  RawClient reader(port(), get_request("/api/captures/" + hash + "/file"));
  const std::string begin = reader.receive("\r\n\r\n");
  std::thread ending([&] { stop(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(body_of(begin + reader.receive()) == capture);
  ending.join();
}

TEST(HeaderScan, EndsWhereTheLibraryEndsIt) {
  using server::HeaderScan;
  const server::HttpLimits limits{.header_line_bytes = 10, .header_bytes = 30};
  const auto all_at_once = [&](const std::string& text) { return HeaderScan().scan(text, limits); };
  for (const auto& [text, end] : std::map<std::string, std::size_t>{{"GET /\r\n\r\nrest", 9},
                                                                    {"\r\n\r\nrest", 4},
                                                                    {"a\n\n\r\n", 5},
                                                                    {"a\r\nb: c\r\n\r\n\r\n", 11},
                                                                    {"a\r\n\n\n\r\n", 7}}) {
    HeaderScan scan, slow;
    EXPECT_EQ(scan.scan(text, limits), HeaderScan::Found::end) << text;
    EXPECT_EQ(scan.header_bytes(), end) << text;
    std::size_t come = 0;
    while (slow.scan(text.substr(0, ++come), limits) == HeaderScan::Found::nothing_yet) ASSERT_LT(come, text.size());
    EXPECT_EQ(come, end) << text;
  }
  EXPECT_EQ(all_at_once("\r\n"), HeaderScan::Found::nothing_yet);
  EXPECT_EQ(all_at_once("a\n\n\n"), HeaderScan::Found::nothing_yet) << "bare line feeds end nothing";
  EXPECT_EQ(all_at_once("12345678\r\n\r\n"), HeaderScan::Found::end);
  EXPECT_EQ(all_at_once("123456789\r\n\r\n"), HeaderScan::Found::long_line);
  EXPECT_EQ(all_at_once("12345678901"), HeaderScan::Found::long_line);
  EXPECT_EQ(all_at_once("1234567\r\n1234567\r\n1234567\r\n\r\n"), HeaderScan::Found::end);
  EXPECT_EQ(all_at_once("1234567\r\n1234567\r\n12345678\r\n\r\n"), HeaderScan::Found::end);
  EXPECT_EQ(all_at_once("1234567\r\n1234567\r\n12345678\r\n1\r\n\r\n"), HeaderScan::Found::long_header);
}

}  // namespace
}  // namespace subpixel::tests
