// The service behind nginx with little more than its proxy_pass, as docs/operations.md says it may be, and behind nginx
// and Caddy as docs/proxies configures them.
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
#include <string>
#include <utility>
#include <vector>

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

// Where a program is that need not be in an ordinary user's PATH; empty when it is nowhere.
fs::path find_program(const std::string& name) {
  for (const char* const folder : {"/usr/sbin", "/usr/bin", "/usr/local/sbin", "/usr/local/bin"})
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  return {};
}

// A program in the foreground, its home in `folder`, ended with its object.
class Proxy {
 public:
  Proxy(std::vector<std::string> arguments, const fs::path& folder) {
    std::vector<char*> words;
    words.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {
      for (const char* const home : {"HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME"}) ::setenv(home, folder.c_str(), 1);
      ::execv(words[0], words.data());
      ::_exit(127);
    }
  }
  ~Proxy() {
    ::kill(process_, SIGTERM);
    int status = 0;
    ::waitpid(process_, &status, 0);
  }
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;
  bool runs() const {
    int status = 0;
    return ::waitpid(process_, &status, WNOHANG) == 0;
  }

 private:
  pid_t process_ = -1;
};

// The words that start nginx with these servers, all of its files in `folder`.
std::vector<std::string> nginx_with(const fs::path& program, const fs::path& folder, const std::string& servers) {
  fs::create_directories(folder);
  std::ofstream conf(folder / "nginx.conf");
  conf << fmt::format("daemon off; worker_processes 1; pid \"{0}/pid\"; error_log \"{0}/error.log\";\n",
                      folder.string())
       << "events { worker_connections 64; }\nhttp { access_log off; ";
  for (const char* const module : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
    conf << fmt::format("{0}_temp_path \"{1}/{0}\"; ", module, folder.string());
  conf << servers << " }\n";
  return {program.string(), "-e", (folder / "error.log").string(), "-c", (folder / "nginx.conf").string()};
}

// The text of docs/proxies/NAME with each first text of a pair made the second.
std::string documented(const std::string& name, const std::vector<std::pair<std::string, std::string>>& changes) {
  std::ifstream file(std::string(SUBPIXEL_SOURCE_DIR) + "/docs/proxies/" + name);
  std::string conf((std::istreambuf_iterator<char>(file)), {});
  for (const auto& [from, to] : changes) {
    const std::size_t at = conf.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) conf.replace(at, from.size(), to);
  }
  return conf;
}

TEST_F(ServiceTest, PageBehindAProxyCanChangeThings) {
  const fs::path program = find_program("nginx");
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
  const std::string servers =
      server_block(plain_port, "") + server_block(host_port, "proxy_set_header Host $http_host; ");
  const Proxy nginx(nginx_with(program, folder() / "nginx", servers), folder());
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
    EXPECT_TRUE(send(to, fmt::format("DELETE {} HTTP/1.1\r\n{}", path, own)).starts_with("HTTP/1.1 204"));
  }
  // With the Host handed on, a foreign name that was pointed at the proxy is seen.
  const std::string rebound = "GET /api/health HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
  EXPECT_TRUE(raw_exchange(host_port, rebound).starts_with("HTTP/1.1 421"));
}

class TlsProxy : public ServiceTest {
 protected:
  // A certificate of the test's own, a service that wants tokens, and a port for the proxy.
  void SetUp() override {
    if (std::system("openssl version >/dev/null 2>&1") != 0) GTEST_SKIP() << "openssl is not installed";
    key_ = (folder() / "key.pem").string();
    certificate_ = (folder() / "certificate.pem").string();
    ASSERT_EQ(
        std::system(fmt::format("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=perf.example -keyout {} "
                                "-out {} 2>/dev/null",
                                key_, certificate_)
                        .c_str()),
        0);
    server::ServiceOptions closed = options();
    closed.host_names = {"perf.example"};
    closed.require_token = true;
    start(closed);
    tls_port_ = free_port();
  }

  // TLS, and a token for everything, whatever a client says that a proxy should say.
  void serves_those_with_a_token_only(const Proxy& proxy, std::size_t request_id_bytes) {
    server::Store store(folder() / "data" / "subpixel.sqlite");
    const std::string token = server::TokenStore(store).add("browser", server::Right::submit, {}, {});
    httplib::SSLClient browser("perf.example", tls_port_);
    browser.set_hostname_addr_map({{"perf.example", "127.0.0.1"}});
    browser.enable_server_certificate_verification(false);
    const httplib::Headers own{{"Host", "perf.example"}, {"Origin", "https://perf.example"}};
    for (int i = 0; i < 500 && proxy.runs() && !browser.Get("/healthz", own); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ASSERT_TRUE(proxy.runs());
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
        browser.Post("/api/captures?name=a", with_cookie, fake_capture({{"frames", 1}}), "application/octet-stream");
    ASSERT_EQ(uploaded->status, 201) << uploaded->body;
    EXPECT_EQ(uploaded->get_header_value("X-Request-Id").size(), request_id_bytes) << "the proxy's own";
    const std::int64_t run = run_of(json::parse(uploaded->body).at("hash"), browser, with_cookie);
    const httplib::Result events = browser.Get("/api/runs/" + std::to_string(run) + "/events", with_cookie);
    ASSERT_TRUE(events);
    EXPECT_NE(events->body.find("event: end"), std::string::npos) << events->body;
    with_cookie.erase("Origin");
    with_cookie.emplace("Origin", "https://evil.example");
    error_of(browser.Post("/api/captures?name=a", with_cookie, "x", "application/octet-stream"), 403);
    httplib::Headers guess = own;
    guess.emplace("Authorization", "Bearer spx_1_guess");
    guess.emplace("X-Forwarded-For", "192.0.2.7");  // what clients say themselves does not count
    for (int i = 0; i < 10; ++i) error_of(browser.Get("/api/runs", guess), 401);
    error_of(browser.Get("/api/runs", guess), 429);
  }

  std::string key_, certificate_;
  int tls_port_ = 0;

 private:
  static std::int64_t run_of(const std::string& capture, httplib::SSLClient& browser, const httplib::Headers& headers) {
    const json body = {{"capture", capture}, {"techniques", {"noaa"}}, {"width", 32}, {"height", 18}};
    const httplib::Result begun = browser.Post("/api/runs", headers, body.dump(), "application/json");
    EXPECT_EQ(begun->status, 201) << begun->body;
    return json::parse(begun->body).at("id");
  }
};

// The documented configurations as they stand, but for ports and paths.
TEST_F(TlsProxy, DocumentedNginx) {
  const fs::path program = find_program("nginx");
  if (program.empty()) GTEST_SKIP() << "nginx is not installed";
  const std::string conf = documented("nginx.conf", {{"443", fmt::format("127.0.0.1:{}", tls_port_)},
                                                     {"/etc/ssl/perf.example.pem", certificate_},
                                                     {"/etc/ssl/private/perf.example.key", key_},
                                                     {"127.0.0.1:8080", fmt::format("127.0.0.1:{}", port())}});
  serves_those_with_a_token_only(Proxy(nginx_with(program, folder() / "nginx", "\n" + conf), folder()), 32);
}

// It would get its certificate itself, from a name's real owner's authority: here it is given one.
TEST_F(TlsProxy, DocumentedCaddy) {
  const fs::path program = find_program("caddy");
  if (program.empty()) GTEST_SKIP() << "caddy is not installed";
  const std::string conf = documented(
      "Caddyfile",
      {{"perf.example {", fmt::format("https://perf.example:{} {{\n\ttls {} {}", tls_port_, certificate_, key_)},
       {"127.0.0.1:8080", fmt::format("127.0.0.1:{}", port())}});
  const std::string file = (folder() / "Caddyfile").string();
  std::ofstream(file) << "{\n\tadmin off\n\tauto_https disable_redirects\n\tdefault_sni perf.example\n}\n" << conf;
  serves_those_with_a_token_only(Proxy({program.string(), "run", "--adapter", "caddyfile", "--config", file}, folder()),
                                 36);
}

}  // namespace
}  // namespace subpixel::tests
