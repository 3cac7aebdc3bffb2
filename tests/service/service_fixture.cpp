#include "tests/service/service_fixture.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <utility>

namespace subpixel::tests {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "subpixel-service-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

server::ServiceOptions test_options(const fs::path& data) {
  server::ServiceOptions options;
  options.data = data;
  options.port = 0;
  options.upload_limit_bytes = 1 << 20;
  options.worker.program = SUBPIXEL_FAKE_WORKER;
  options.http.idle_time = std::chrono::seconds(2);
  options.worker.limits.silence = std::chrono::seconds(20);
  options.worker.limits.line_bytes = 1 << 20;
  return options;
}

std::string fake_capture(const json& behaviour) {
  return "FAKE " + behaviour.dump() + "\n";
}

Client::Client(int port) : http_("127.0.0.1", port) {
  http_.set_read_timeout(std::chrono::seconds(30));
}

httplib::Result Client::upload(const std::string& bytes, const std::string& name) {
  return http_.Post("/api/captures?name=" + name, bytes, "application/octet-stream");
}

std::string Client::upload_fake(const json& behaviour) {
  const httplib::Result result = upload(fake_capture(behaviour));
  EXPECT_TRUE(result);
  if (!result) return "";
  EXPECT_TRUE(result->status == 201 || result->status == 200) << result->body;
  return json::parse(result->body).value("hash", "");
}

httplib::Result Client::post_run(const json& body) {
  return http_.Post("/api/runs", body.dump(), "application/json");
}

std::int64_t Client::start_run(const std::string& capture) {
  const httplib::Result result = post_run({{"capture", capture},
                                           {"techniques", {{{"technique", "noaa"}}, {{"technique", "msaa"}}}},
                                           {"width", 32},
                                           {"height", 18}});
  EXPECT_TRUE(result);
  if (!result) return -1;
  EXPECT_EQ(result->status, 201) << result->body;
  return json::parse(result->body).value("id", -1);
}

json Client::get(const std::string& path, int expected_status) {
  const httplib::Result result = http_.Get(path);
  EXPECT_TRUE(result) << path;
  if (!result) return {};
  EXPECT_EQ(result->status, expected_status) << path << ": " << result->body;
  return json::parse(result->body, nullptr, false);
}

json Client::wait_for_end(std::int64_t run, std::chrono::seconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    json document = get("/api/runs/" + std::to_string(run));
    const std::string status = document.value("status", "");
    if (status != "queued" && status != "running") return document;
    if (std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "run " << run << " did not end: " << document.dump();
      return document;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

RunningService::RunningService(server::ServiceOptions options)
    : service_(std::move(options)), thread_([this] { service_.run(); }) {
  // Connections wait in the socket's backlog from its binding on, so no start has to be waited for.
}

RunningService::~RunningService() {
  service_.stop();
  thread_.join();
}

ServiceProcess::ServiceProcess(const fs::path& data, const std::vector<std::string>& options) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  std::vector<std::string> words{SUBPIXEL_BINARY,     "serve", "--data", data.string(), "--worker-program",
                                 SUBPIXEL_FAKE_WORKER};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(ends[1], 1);
    ::execv(SUBPIXEL_BINARY, arguments.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  std::string line;
  for (char c; line.find('\n') == std::string::npos && ::read(ends[0], &c, 1) == 1;) line += c;
  ::close(ends[0]);
  const std::size_t colon = line.rfind(':');
  if (colon != std::string::npos) port_ = std::atoi(line.c_str() + colon + 1);
}

ServiceProcess::~ServiceProcess() {
  end(SIGKILL);
}

int ServiceProcess::end(int signal) {
  if (pid_ <= 0) return -1;
  ::kill(pid_, signal);
  int status = 0;
  ::waitpid(std::exchange(pid_, -1), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int ServiceProcess::kill_children() const {
  int killed = 0;
  std::error_code gone;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid_) + "/task", gone)) {
    std::ifstream children(thread.path() / "children");
    for (pid_t child = 0; children >> child;) killed += ::kill(child, SIGKILL) == 0 ? 1 : 0;
  }
  return killed;
}

void ServiceTest::start(const server::ServiceOptions& options) {
  client_.reset();
  service_.reset();  // the data folder's lock
  service_ = std::make_unique<RunningService>(options);
  client_ = std::make_unique<Client>(service_->port());
}

Client& ServiceTest::client() {
  if (!service_) start(options());
  return *client_;
}

std::string raw_exchange(int port, const std::string& bytes, bool finish_sending) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval timeout{20, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
  std::string answer;
  if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t step = ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (step <= 0) break;  // the other side has heard enough
      sent += static_cast<std::size_t>(step);
    }
    if (finish_sending) ::shutdown(socket, SHUT_WR);
    char block[4096];
    for (ssize_t got; (got = ::recv(socket, block, sizeof(block), 0)) > 0;)
      answer.append(block, static_cast<std::size_t>(got));
  }
  ::close(socket);
  return answer;
}

json error_of(const httplib::Result& result, int expected_status) {
  EXPECT_TRUE(result);
  if (!result) return json::object();
  EXPECT_EQ(result->status, expected_status) << result->body;
  EXPECT_EQ(result->get_header_value("Content-Type"), "application/json");
  const json document = json::parse(result->body, nullptr, false);
  if (!document.is_object() || !document.contains("error")) {
    ADD_FAILURE() << "no error document: " << result->body;
    return json::object();
  }
  EXPECT_EQ(document["error"]["status"], expected_status);
  for (const char* field : {"what", "why", "where"}) EXPECT_TRUE(document["error"][field].is_string()) << field;
  return document["error"];
}

}  // namespace subpixel::tests
