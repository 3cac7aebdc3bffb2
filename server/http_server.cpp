#include "server/http_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/numbers.hpp"

namespace subpixel::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kPollStep{200};     // how late a shutdown is noticed
constexpr milliseconds kLingerTime{2000};  // see linger()
constexpr std::size_t kRequestsPerConnection = 1000;
// An answer to a larger body may come before it was read, which ends the connection, so its header says so beforehand.
constexpr std::uint64_t kSmallBodyBytes = 65536;

void address_of(socket_t socket, bool remote, std::string& ip, int& port) {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if ((remote ? ::getpeername(socket, generic, &length) : ::getsockname(socket, generic, &length)) != 0) return;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (::getnameinfo(generic, length, host.data(), host.size(), service.data(), service.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return;
  }
  ip = host.data();
  std::from_chars(service.data(), service.data() + std::strlen(service.data()), port);
}

// A socket with a read buffer (the library reads headers byte by byte) and limits on the header of each request.
class LimitedStream final : public httplib::Stream {
 public:
  LimitedStream(socket_t socket, const HttpLimits& limits, const std::atomic<bool>& shutting_down)
      : socket_(socket), limits_(limits), shutting_down_(shutting_down) {}

  enum class Overrun { none, line, header, time };

  // Waits for the first byte of the next request.
  bool wait_for_request() {
    if (begin_ < end_) return true;
    return fill(Clock::now() + limits_.idle_time);
  }

  void begin_header() {
    in_header_ = true;
    header_bytes_ = line_bytes_ = 0;
    body_left_ = 0;
    overrun_ = Overrun::none;
    header_deadline_ = Clock::now() + limits_.header_time;
  }

  // What follows is a body of `length` bytes; reading stops there, so that no body runs into the next request.
  void begin_body(std::uint64_t length) {
    in_header_ = false;
    body_left_ = length;
  }

  bool header_complete() const { return !in_header_; }
  std::uint64_t body_left() const { return body_left_; }
  Overrun overrun() const { return overrun_; }

  bool is_readable() const override { return begin_ < end_ || poll_for(POLLIN, milliseconds(0)); }

  // Also false when the other side has gone, which is how an event stream without events notices.
  bool is_writable() const override {
    pollfd wait{socket_, POLLOUT | POLLRDHUP, 0};
    return ::poll(&wait, 1, 0) > 0 && (wait.revents & (POLLRDHUP | POLLHUP | POLLERR)) == 0;
  }

  ssize_t read(char* to, std::size_t size) override {
    if (overrun_ != Overrun::none) return -1;
    if (in_header_) return read_header(to, size);
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size, body_left_));
    if (wanted == 0) return 0;
    if (begin_ == end_ && !fill(Clock::now() + limits_.idle_time)) return at_end_ ? 0 : -1;
    const std::size_t taken = take(to, wanted);
    body_left_ -= taken;
    return static_cast<ssize_t>(taken);
  }

  ssize_t write(const char* from, std::size_t size) override {
    if (overrun_ != Overrun::none) return -1;  // refuse() answers instead
    const Clock::time_point deadline = Clock::now() + limits_.idle_time;
    while (true) {
      const ssize_t sent = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent >= 0) return sent;
      if (errno != EAGAIN && errno != EINTR) return -1;
      if (Clock::now() > deadline) return -1;
      poll_for(POLLOUT, kPollStep);
    }
  }

  // Answers a request whose header broke a limit.
  void refuse() {
    const bool slow = overrun_ == Overrun::time;
    const std::string why = overrun_ == Overrun::line
                                ? fmt::format("a line has more than {} bytes", limits_.header_line_bytes)
                            : slow ? fmt::format("it took more than {} ms", limits_.header_time.count())
                                   : fmt::format("it has more than {} bytes", limits_.header_bytes);
    const std::string body = fmt::format(
        R"({{"error":{{"status":{},"what":"the request's header is refused","why":"{}","where":"header"}}}})",
        slow ? 408 : 431, why);
    const std::string response = fmt::format(
        "HTTP/1.1 {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
        slow ? "408 Request Timeout" : "431 Request Header Fields Too Large", body.size(), body);
    ::send(socket_, response.data(), response.size(), MSG_NOSIGNAL);
  }

  // Closing a socket with unread input resets the connection, and the answer is lost before the client has read it. So
  // say that nothing more will come, and read and drop for a while.
  void linger() {
    ::shutdown(socket_, SHUT_WR);
    const Clock::time_point deadline = Clock::now() + kLingerTime;
    do {
      begin_ = end_ = 0;
    } while (fill(deadline));
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override { address_of(socket_, true, ip, port); }
  void get_local_ip_and_port(std::string& ip, int& port) const override { address_of(socket_, false, ip, port); }
  socket_t socket() const override { return socket_; }

 private:
  bool poll_for(short events, milliseconds timeout) const {
    pollfd wait{socket_, events, 0};
    return ::poll(&wait, 1, static_cast<int>(timeout.count())) > 0;
  }

  std::size_t take(char* to, std::size_t size) {
    const std::size_t taken = std::min(size, end_ - begin_);
    std::memcpy(to, buffer_.data() + begin_, taken);
    begin_ += taken;
    return taken;
  }

  // At least one byte into the empty buffer. False at the end of input, at the deadline and at shutdown.
  bool fill(Clock::time_point deadline) {
    while (!shutting_down_) {
      const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
      if (left.count() <= 0) return false;
      if (!poll_for(POLLIN, std::min(left + milliseconds(1), kPollStep))) continue;
      const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
      if (got > 0) {
        begin_ = 0;
        end_ = static_cast<std::size_t>(got);
        return true;
      }
      if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      at_end_ = true;
      return false;
    }
    return false;
  }

  ssize_t read_header(char* to, std::size_t size) {
    if (begin_ == end_ && !fill(header_deadline_)) {
      if (!at_end_ && !shutting_down_ && header_bytes_ > 0) overrun_ = Overrun::time;
      return at_end_ ? 0 : -1;
    }
    // Up to the line's end only: the library must not get a byte of the body before begin_body().
    const char* const start = buffer_.data() + begin_;
    const std::size_t available = std::min(size, end_ - begin_);
    const void* const newline = std::memchr(start, '\n', available);
    const std::size_t line_part =
        newline == nullptr ? available : static_cast<std::size_t>(static_cast<const char*>(newline) - start) + 1;
    header_bytes_ += line_part;
    line_bytes_ += line_part;
    if (line_bytes_ > limits_.header_line_bytes) overrun_ = Overrun::line;
    if (header_bytes_ > limits_.header_bytes) overrun_ = Overrun::header;
    if (Clock::now() > header_deadline_) overrun_ = Overrun::time;
    if (overrun_ != Overrun::none) return -1;
    if (newline != nullptr) line_bytes_ = 0;
    return static_cast<ssize_t>(take(to, line_part));
  }

  socket_t socket_;
  const HttpLimits& limits_;
  const std::atomic<bool>& shutting_down_;
  std::array<char, 65536> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  bool in_header_ = true, at_end_ = false;
  std::size_t header_bytes_ = 0, line_bytes_ = 0;
  std::uint64_t body_left_ = 0;
  Overrun overrun_ = Overrun::none;
  Clock::time_point header_deadline_;
};

// The length of the body that follows a header, 0 without one; nothing when it can't be told. What follows such a
// header must not be read, neither as a body nor as the next request.
std::optional<std::uint64_t> declared_length(const httplib::Request& request) {
  if (request.has_header("Transfer-Encoding")) return std::nullopt;
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  if (lengths != 1) return lengths == 0 ? std::optional<std::uint64_t>(0) : std::nullopt;
  return parse_number<std::uint64_t>(request.get_header_value("Content-Length"));
}

// A target that is a whole address (RFC 9112, section 3.2.2) becomes its path, and its authority the Host, whatever
// that was: what is checked is what was asked for. Such a request too must have said one Host.
void take_absolute_form(httplib::Request& request) {
  constexpr std::string_view kScheme = "http://";
  const std::string& target = request.target;
  if (target.size() < kScheme.size() || ::strncasecmp(target.data(), kScheme.data(), kScheme.size()) != 0) return;
  const std::size_t end = std::min(target.find_first_of("/?", kScheme.size()), target.size());
  if (request.get_header_value_count("Host") == 1) {
    request.headers.erase("Host");
    request.headers.emplace("Host", target.substr(kScheme.size(), end - kScheme.size()));
  }
  const bool rooted = end < target.size() && target[end] == '/';
  const std::string rest = std::string(rooted ? "" : "/").append(target, end);
  request.path = httplib::detail::decode_url(rest.substr(0, rest.find('?')), false);
  request.target = rest;
}

}  // namespace

HttpServer::HttpServer(const HttpLimits& limits) : limits_(limits) {
  new_task_queue = [count = limits.connections] { return new httplib::ThreadPool(count); };
  set_tcp_nodelay(true);
  // The library's default is SO_REUSEPORT, with which two servers share a port in silence.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
}

void HttpServer::shut_down() {
  shutting_down_ = true;
  stop();
}

bool HttpServer::process_and_close_socket(socket_t socket) {
  const auto stream = std::make_unique<LimitedStream>(socket, limits_, shutting_down_);
  bool served = false;
  for (std::size_t request = 1; request <= kRequestsPerConnection && stream->wait_for_request(); ++request) {
    stream->begin_header();
    bool closed = false, last = false;
    served = process_request(*stream, request == kRequestsPerConnection, closed, [&](httplib::Request& parsed) {
      const std::optional<std::uint64_t> length = declared_length(parsed);
      stream->begin_body(length.value_or(0));
      parsed.ranges.clear();  // the library's own are not bounded in number; choose_bytes() reads the header itself
      take_absolute_form(parsed);
      last = !length || *length > kSmallBodyBytes || parsed.version == "HTTP/1.0";
      if (last) {
        parsed.headers.erase("Connection");
        parsed.set_header("Connection", "close");
      }
    });
    if (stream->overrun() != LimitedStream::Overrun::none) stream->refuse();
    // What is left of a header or body would be read as the next request.
    if (!served || closed || last || !stream->header_complete() || stream->body_left() > 0) break;
  }
  stream->linger();
  ::close(socket);
  return served;
}

}  // namespace subpixel::server
