// The service behind nginx with little more than its proxy_pass, as docs/operations.md says it may be.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "server/store/tokens.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;

// A port of the loopback address that is free now.
int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  const bool bound = ::bind(socket, reinterpret_cast<sockaddr*>(&address), length) == 0 &&
                     ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0;
  ::close(socket);
  return bound ? ntohs(address.sin_port) : 0;
}

fs::path find_nginx() {
  for (const char* const path : {"/usr/sbin/nginx", "/usr/bin/nginx", "/usr/local/sbin/nginx"})
    if (fs::exists(path)) return path;
  return {};
}

// nginx in the foreground, all of its files in `folder`, ended with its object.
class Nginx {
 public:
  Nginx(const fs::path& program, const fs::path& folder, const std::string& servers) {
    fs::create_directories(folder);
    std::ofstream conf_file(folder / "nginx.conf");
    conf_file << fmt::format("daemon off; worker_processes 1; pid \"{0}/pid\"; error_log \"{0}/error.log\";\n",
                             folder.string())
              << "events { worker_connections 64; }\nhttp { access_log off; ";
    for (const char* const module : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
      conf_file << fmt::format("{0}_temp_path \"{1}/{0}\"; ", module, folder.string());
    conf_file << servers << " }\n";
    conf_file.close();
    const std::string conf = (folder / "nginx.conf").string(), log = (folder / "error.log").string();
    process_ = ::fork();
    if (process_ == 0) {
      ::execl(program.c_str(), program.c_str(), "-e", log.c_str(), "-c", conf.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
  }
  ~Nginx() {
    ::kill(process_, SIGTERM);
    int status = 0;
    ::waitpid(process_, &status, 0);
  }
  Nginx(const Nginx&) = delete;
  Nginx& operator=(const Nginx&) = delete;
  bool runs() const {
    int status = 0;
    return ::waitpid(process_, &status, WNOHANG) == 0;
  }

 private:
  pid_t process_ = -1;
};

TEST_F(ServiceTest, PageBehindAProxyCanChangeThings) {
  const fs::path program = find_nginx();
  if (program.empty()) GTEST_SKIP() << "nginx is not installed";
  const int plain_port = free_port(), host_port = free_port();
  ASSERT_NE(plain_port, host_port);
  server::ServiceOptions named = options();
  named.host_names = {"perf.example"};
  start(named);
  const auto server_block = [&](int listen, const std::string& more) {
    return fmt::format(
        "server {{ listen 127.0.0.1:{}; client_max_body_size 5g; location / {{ proxy_pass http://127.0.0.1:{}; {} }} "
        "}} ",
        listen, port(), more);
  };
  const Nginx nginx(program, folder() / "nginx",
                    server_block(plain_port, "") + server_block(host_port, "proxy_set_header Host $http_host; "));
  // Reached by the public name, as a browser that resolves it would.
  const auto send = [&](int to, const std::string& head, const std::string& body = "") {
    return raw_exchange(to, fmt::format("{}Host: perf.example\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{}",
                                        head, body.size(), body));
  };
  const auto ready = [&] {
    return send(plain_port, "GET /api/health HTTP/1.1\r\n").starts_with("HTTP/1.1 200") &&
           send(host_port, "GET /api/health HTTP/1.1\r\n").starts_with("HTTP/1.1 200");
  };
  for (int i = 0; i < 500 && nginx.runs() && !ready(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_TRUE(ready());

  int frames = 0;
  for (const int to : {plain_port, host_port}) {
    SCOPED_TRACE(to == plain_port ? "proxy_pass alone" : "with the Host handed on");
    const std::string own = "Origin: http://perf.example\r\nSec-Fetch-Site: same-origin\r\n";
    const std::string capture = fake_capture({{"frames", ++frames}});
    const std::string uploaded = send(to, "POST /api/captures?name=a HTTP/1.1\r\n" + own, capture);
    EXPECT_TRUE(uploaded.starts_with("HTTP/1.1 201")) << uploaded;
    const std::string hash = json::parse(uploaded.substr(uploaded.find("\r\n\r\n") + 4)).value("hash", "");
    for (const char* const other : {"Origin: http://evil.example\r\n", "Origin: http://perf.example:8080\r\n",
                                    "Origin: null\r\n", "Sec-Fetch-Site: cross-site\r\n"}) {
      EXPECT_TRUE(send(to, "DELETE /api/captures/" + hash + " HTTP/1.1\r\n" + other).starts_with("HTTP/1.1 403"))
          << other;
    }
    const std::int64_t run = client().start_run(hash);
    const std::string path = "/api/runs/" + std::to_string(run);
    const std::string events = send(to, "GET " + path + "/events HTTP/1.1\r\n");
    EXPECT_NE(events.find("event: end"), std::string::npos) << events;
    EXPECT_TRUE(send(to, "DELETE " + path + " HTTP/1.1\r\n" + own).starts_with("HTTP/1.1 204"));
  }
  // With the Host handed on, a foreign name that was pointed at the proxy is seen.
  const std::string rebound = "GET /api/health HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
  EXPECT_TRUE(raw_exchange(host_port, rebound).starts_with("HTTP/1.1 421"));
}

// docs/proxies/nginx.conf as it stands, but for ports and paths, with a certificate of the test's own.
TEST_F(ServiceTest, DocumentedNginxServesTlsToThoseWithATokenOnly) {
  const fs::path program = find_nginx();
  if (program.empty() || std::system("openssl version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "nginx or openssl is not installed";
  }
  const std::string key = (folder() / "key.pem").string(), certificate = (folder() / "certificate.pem").string();
  ASSERT_EQ(
      std::system(fmt::format("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=perf.example -keyout {} "
                              "-out {} 2>/dev/null",
                              key, certificate)
                      .c_str()),
      0);
  server::ServiceOptions closed = options();
  closed.host_names = {"perf.example"};
  closed.require_token = true;
  start(closed);
  server::Store store(folder() / "data" / "subpixel.sqlite");
  const std::string token = server::TokenStore(store).add("browser", server::Right::submit, {}, {});

  std::ifstream file(std::string(SUBPIXEL_SOURCE_DIR) + "/docs/proxies/nginx.conf");
  std::string conf((std::istreambuf_iterator<char>(file)), {});
  const int tls_port = free_port();
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"443", "127.0.0.1:" + std::to_string(tls_port)},
                                 {"/etc/ssl/perf.example.pem", certificate},
                                 {"/etc/ssl/private/perf.example.key", key},
                                 {"127.0.0.1:8080", "127.0.0.1:" + std::to_string(port())}}) {
    const std::size_t at = conf.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    conf.replace(at, from.size(), to);
  }
  const Nginx nginx(program, folder() / "nginx", "\n" + conf);
  httplib::SSLClient browser("127.0.0.1", tls_port);
  browser.enable_server_certificate_verification(false);
  const httplib::Headers own{{"Host", "perf.example"}, {"Origin", "https://perf.example"}};
  for (int i = 0; i < 500 && nginx.runs() && !browser.Get("/healthz", own); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(nginx.runs());
  error_of(browser.Get("/api/runs", own), 401);
  const httplib::Result signed_in =
      browser.Post("/api/sign-in", own, json{{"token", token}}.dump(), "application/json");
  ASSERT_TRUE(signed_in);
  ASSERT_EQ(signed_in->status, 200) << signed_in->body;
  const std::string cookie = signed_in->get_header_value("Set-Cookie");
  EXPECT_NE(cookie.find("; Secure"), std::string::npos) << cookie;
  EXPECT_TRUE(signed_in->has_header("Strict-Transport-Security"));
  httplib::Headers with_cookie = own;
  with_cookie.emplace("Cookie", cookie.substr(0, cookie.find(';')));
  const httplib::Result uploaded =
      browser.Post("/api/captures?name=a", with_cookie, fake_capture({{"frames", 0}}), "application/octet-stream");
  ASSERT_EQ(uploaded->status, 201) << uploaded->body;
  EXPECT_EQ(uploaded->get_header_value("X-Request-Id").size(), 32u) << "nginx's own";
  with_cookie.erase("Origin");
  with_cookie.emplace("Origin", "https://evil.example");
  error_of(browser.Post("/api/captures?name=a", with_cookie, "x", "application/octet-stream"), 403);
  httplib::Headers guess = own;
  guess.emplace("Authorization", "Bearer spx_1_guess");
  guess.emplace("X-Forwarded-For", "192.0.2.7");  // what clients say themselves does not count
  for (int i = 0; i < 10; ++i) error_of(browser.Get("/api/runs", guess), 401);
  error_of(browser.Get("/api/runs", guess), 429);
}

}  // namespace
}  // namespace subpixel::tests
