// The loop and the life of a connection. What followers get is in http_followers.cpp.
#include "server/http_connections.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <system_error>
#include <tuple>
#include <utility>

namespace subpixel::server {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kListener = 0, kWakeUp = 1;
constexpr milliseconds kSweepStep{100};    // how late a limit on time is noticed
constexpr milliseconds kLingerTime{2000};  // see linger()
constexpr milliseconds kStopTime{5000};    // for answers to be read when the service ends
constexpr milliseconds kHeartbeat{10'000};
constexpr std::size_t kRequestsPerConnection = 1000;
constexpr std::size_t kHeaderReadBytes = 16384;  // what is left of it after the header is the body's beginning
constexpr int kAcceptsPerTurn = 64;
constexpr int kUnsentBytes = 1 << 17;  // in the kernel for a client that does not read
// Descriptors for what is neither a connection nor its file: SQLite, worker processes' pipes, files that handlers read.
constexpr std::size_t kReservedDescriptors = 256;

// How many connections there can be. Each may have a file besides, the body that comes or the answer that goes.
std::size_t affordable_connections(std::size_t wanted) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  const rlim_t needed = 2 * wanted + kReservedDescriptors;
  if (limit.rlim_cur < needed) {
    limit.rlim_cur = std::min(needed, limit.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &limit);
    ::getrlimit(RLIMIT_NOFILE, &limit);
  }
  const std::size_t all = std::min<std::size_t>(limit.rlim_cur, needed);
  return std::max<std::size_t>(all > kReservedDescriptors ? (all - kReservedDescriptors) / 2 : 0, 8);
}

Exchange::Peer peer_of(const sockaddr_storage& address, socklen_t length) {
  Exchange::Peer peer;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (::getnameinfo(reinterpret_cast<const sockaddr*>(&address), length, host.data(), host.size(), service.data(),
                    service.size(), NI_NUMERICHOST | NI_NUMERICSERV) == 0) {
    peer.ip = host.data();
    std::from_chars(service.data(), service.data() + std::strlen(service.data()), peer.port);
  }
  return peer;
}

int or_throw(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

// Nothing more will be read: the client has closed its side, or the connection is broken.
bool ended(ssize_t received) {
  return received == 0 || (received < 0 && errno != EAGAIN && errno != EINTR);
}

}  // namespace

HttpConnections::HttpConnections(const HttpLimits& limits, std::filesystem::path spill_folder)
    : limits_(limits),
      spill_folder_(std::move(spill_folder)),
      epoll_(or_throw(::epoll_create1(EPOLL_CLOEXEC), "epoll")),
      wake_(or_throw(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")) {}

HttpConnections::~HttpConnections() {
  ::close(epoll_);
  ::close(wake_);
}

// ---- The loop ---------------------------------------------------------------------------------

void HttpConnections::run(int listener, Work work) {
  work_ = std::move(work);
  listener_ = listener;
  workers_ = std::make_unique<httplib::ThreadPool>(limits_.threads);
  body_workers_ = std::make_unique<httplib::ThreadPool>(limits_.body_threads);
  most_connections_ = affordable_connections(limits_.connections);
  ::listen(listener_, SOMAXCONN);  // the library's 5 make many clients at once wait for a second and more
  const int flags = 1;
  ::ioctl(listener_, FIONBIO, &flags);
  epoll_event wake{EPOLLIN, {.u64 = kWakeUp}}, listening{0, {.u64 = kListener}};
  ::epoll_ctl(epoll_, EPOLL_CTL_ADD, wake_, &wake);
  ::epoll_ctl(epoll_, EPOLL_CTL_ADD, listener_, &listening);
  listen_for_more(true);

  Clock::time_point next_sweep = Clock::now();
  std::array<epoll_event, 256> events;
  while (!stopping_ || !connections_.empty()) {
    const bool nothing_to_watch = connections_.empty() && listening_;
    const int count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()),
                                   nothing_to_watch ? -1 : static_cast<int>(kSweepStep.count()));
    now_ = Clock::now();
    bool someone_comes = false;
    for (std::size_t i = 0; count > 0 && i < static_cast<std::size_t>(count); ++i) {
      if (events[i].data.u64 == kListener) {
        someone_comes = true;
      } else {
        on_event(events[i].data.u64, events[i].events);
      }
    }
    if (someone_comes) accept_some();  // after the others, since it may close idle ones
    run_posted();
    if (stop_requested_ && !stopping_) begin_stop();
    if (now_ >= next_sweep) {
      next_sweep = now_ + kSweepStep;
      sweep();
    }
    forget_closed();
  }
  // Connections that broke off may have left requests.
  workers_->shutdown();
  body_workers_->shutdown();
}

void HttpConnections::stop() {
  stop_requested_ = true;
  post([] {});
}

void HttpConnections::post(std::function<void()> task) {
  {
    const std::lock_guard lock(posted_mutex_);
    posted_.push_back(std::move(task));
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t woken = ::write(wake_, &one, sizeof(one));
}

void HttpConnections::run_posted() {
  std::vector<std::function<void()>> tasks;
  {
    const std::lock_guard lock(posted_mutex_);
    tasks.swap(posted_);
  }
  for (const std::function<void()>& task : tasks) task();
}

void HttpConnections::on_event(Id id, std::uint32_t events) {
  if (id == kWakeUp) {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = ::read(wake_, &count, sizeof(count));
    return;  // run_posted() comes next
  }
  Connection* const connection = find(id);
  if (connection == nullptr) return;  // closed in this turn
  const bool broken = (events & (EPOLLERR | EPOLLHUP)) != 0;
  switch (connection->state) {
    case State::reading_header:
      return read_header(*connection);
    case State::reading_body:
      return read_body(*connection);
    case State::lingering:
      return drop_input(*connection);
    case State::sending:
      return broken ? close(*connection) : flush(*connection);
    case State::following:  // half closed is gone: there is nobody to follow for
      return broken || (events & EPOLLRDHUP) != 0 ? close(*connection) : flush(*connection);
    case State::working:
    case State::closed:
      return broken ? close(*connection) : watch(*connection, 0);
  }
}

void HttpConnections::sweep() {
  for (auto& [id, connection] : connections_) check_time(connection);
  std::vector<std::int64_t> topics;  // feed() may end one
  for (const auto& [topic, state] : topics_) topics.push_back(topic);
  for (const std::int64_t topic : topics) feed(topic);
  listen_for_more(!stopping_);
}

void HttpConnections::check_time(Connection& connection) {
  const auto silent = now_ - connection.progress;
  switch (connection.state) {
    case State::reading_header:
      if (connection.input.empty()) {
        if (silent > limits_.idle_time) close(connection);
      } else if (now_ > connection.header_deadline) {
        refuse(connection, 408, fmt::format("it took more than {} ms", limits_.header_time.count()));
      }
      return;
    case State::reading_body:
      if (silent <= limits_.idle_time) return;
      connection.exchange->end_body();
      return submit(connection);
    case State::lingering:
      if (silent > kLingerTime) close(connection);
      return;
    case State::sending:
      if (silent > limits_.idle_time || (stopping_ && now_ > stop_deadline_)) close(connection);
      return;
    case State::following:
      if (!connection.outgoing.empty()) {
        if (silent > limits_.idle_time) close(connection);
      } else if (silent > kHeartbeat) {
        connection.outgoing.append(
            std::string_view(connection.following->chunked ? chunk(work_.heartbeat) : work_.heartbeat));
        flush(connection);
      }
      return;
    case State::working:
    case State::closed:
      return;
  }
}

// Whoever has a request under way gets his answer; for followers and all others this is the end.
void HttpConnections::begin_stop() {
  stopping_ = true;
  stop_deadline_ = now_ + kStopTime;
  listen_for_more(false);
  for (auto& [id, connection] : connections_) {
    if (connection.state != State::working && connection.state != State::sending) close(connection);
  }
}

HttpConnections::Connection* HttpConnections::find(Id id) {
  const auto found = connections_.find(id);
  return found == connections_.end() || found->second.state == State::closed ? nullptr : &found->second;
}

void HttpConnections::watch(Connection& connection, std::uint32_t events) {
  if (connection.watched == events) return;
  connection.watched = events;
  epoll_event event{events, {.u64 = connection.id}};
  ::epoll_ctl(epoll_, EPOLL_CTL_MOD, connection.socket, &event);
}

void HttpConnections::set_state(Connection& connection, State state, std::uint32_t events) {
  connection.state = state;
  connection.progress = now_;
  watch(connection, events);
}

// The descriptor is free at once, the rest at the turn's end: callers still hold the connection.
void HttpConnections::close(Connection& connection) {
  if (connection.state == State::closed) return;
  stop_following(connection);
  connection.state = State::closed;
  ::close(connection.socket);
  if (--by_address_[connection.peer.ip] == 0) by_address_.erase(connection.peer.ip);
  connection.outgoing = Outgoing(spill_folder_);
  // An upload's file may be large, and its end slow.
  if (connection.exchange)
    workers_->enqueue([exchange = std::move(connection.exchange)]() mutable { exchange.reset(); });
  connection.exchange.reset();
  closed_.push_back(connection.id);
}

void HttpConnections::forget_closed() {
  for (const Id id : closed_) connections_.erase(id);
  closed_.clear();
}

// ---- Accepting --------------------------------------------------------------------------------

void HttpConnections::accept_some() {
  for (int i = 0; i < kAcceptsPerTurn; ++i) {
    const bool full = open_connections() >= most_connections_;
    if (full && i > 0) return;  // those who have come may have sent something, and are no idle ones then
    if (full && !make_room()) return listen_for_more(false);  // until the next sweep
    sockaddr_storage address{};
    socklen_t length = sizeof(address);
    const int socket =
        ::accept4(listener_, reinterpret_cast<sockaddr*>(&address), &length, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket >= 0) {
      add(socket, peer_of(address, length));
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      make_room();
      return listen_for_more(false);
    } else {
      return;
    }
  }
}

void HttpConnections::add(int socket, Exchange::Peer peer) {
  ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes, sizeof(kUnsentBytes));
  const Id id = next_id_++;
  ++by_address_[peer.ip];
  Connection& connection = connections_.try_emplace(id, spill_folder_).first->second;
  connection.id = id;
  connection.socket = socket;
  connection.peer = std::move(peer);
  connection.progress = now_;
  connection.watched = EPOLLIN;
  epoll_event event{EPOLLIN, {.u64 = id}};
  if (::epoll_ctl(epoll_, EPOLL_CTL_ADD, socket, &event) != 0) close(connection);
}

// Closes one connection of the address that has most, the idlest first. False when all are at work.
bool HttpConnections::make_room() {
  if (by_address_.empty()) return false;
  const auto most = std::ranges::max_element(by_address_, {}, [](const auto& entry) { return entry.second; });
  Connection* victim = nullptr;
  const auto rank = [](const Connection& connection) {
    return std::tuple(connection.state, !connection.input.empty(), connection.progress, connection.id);
  };
  for (auto& [id, connection] : connections_) {
    if (connection.state == State::closed || connection.state == State::working) continue;
    if (connection.peer.ip != most->first) continue;
    if (victim == nullptr || rank(connection) < rank(*victim)) victim = &connection;
  }
  if (victim != nullptr) close(*victim);
  return victim != nullptr;
}

void HttpConnections::listen_for_more(bool yes) {
  if (listening_ == yes) return;
  listening_ = yes;
  epoll_event event{yes ? static_cast<std::uint32_t>(EPOLLIN) : 0, {.u64 = kListener}};
  ::epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_, &event);
}

// ---- A connection's way -----------------------------------------------------------------------

void HttpConnections::read_header(Connection& connection) {
  const ssize_t got = ::recv(connection.socket, scratch_.data(), kHeaderReadBytes, 0);
  if (ended(got)) return close(connection);
  if (got < 0) return;
  connection.progress = now_;
  if (connection.input.empty()) connection.header_deadline = now_ + limits_.header_time;
  connection.input.append(scratch_.data(), static_cast<std::size_t>(got));
  look_for_header(connection);
}

void HttpConnections::next_request(Connection& connection) {
  connection.header = {};
  connection.header_deadline = now_ + limits_.header_time;
  set_state(connection, State::reading_header, EPOLLIN);
  if (!connection.input.empty()) look_for_header(connection);
}

void HttpConnections::look_for_header(Connection& connection) {
  switch (connection.header.scan(connection.input, limits_)) {
    case HeaderScan::Found::nothing_yet:
      return;
    case HeaderScan::Found::long_line:
      return refuse(connection, 431, fmt::format("a line has more than {} bytes", limits_.header_line_bytes));
    case HeaderScan::Found::long_header:
      return refuse(connection, 431, fmt::format("it has more than {} bytes", limits_.header_bytes));
    case HeaderScan::Found::end:
      break;
  }
  const std::size_t end = connection.header.header_bytes();
  connection.exchange =
      std::make_shared<Exchange>(connection.input.substr(0, end), connection.peer,
                                 ++connection.requests >= kRequestsPerConnection, work_.open_body, spill_folder_);
  connection.input.erase(0, end);
  connection.input.shrink_to_fit();
  submit(connection);
}

// Answers a request whose header broke a limit.
void HttpConnections::refuse(Connection& connection, int status, const std::string& why) {
  const std::string body =
      fmt::format(R"({{"error":{{"status":{},"what":"the request's header is refused","why":"{}","where":"header"}}}})",
                  status, why);
  connection.outgoing.append(
      fmt::format("HTTP/1.1 {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
                  status == 408 ? "408 Request Timeout" : "431 Request Header Fields Too Large", body.size(), body));
  connection.keep = false;
  set_state(connection, State::sending, EPOLLOUT);
  flush(connection);
}

// Hands the request to a worker: at first its header, and, where the handler asks for the body, again with that.
void HttpConnections::submit(Connection& connection) {
  set_state(connection, State::working, 0);
  httplib::ThreadPool& pool = connection.exchange->waits_for_body() ? *body_workers_ : *workers_;
  pool.enqueue([this, id = connection.id, exchange = connection.exchange] {
    work_.answer(*exchange);
    post([this, id] { answered(id); });
  });
}

void HttpConnections::answered(Id id) {
  Connection* const connection = find(id);
  if (connection == nullptr) return;
  Exchange& exchange = *connection->exchange;
  std::optional<Following> following = exchange.take_following();
  if (stopping_ && (exchange.waits_for_body() || following)) return close(*connection);
  if (exchange.waits_for_body()) {
    constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    if (exchange.expects_continue() && connection->input.empty()) {
      ::send(connection->socket, kContinue.data(), kContinue.size(), MSG_NOSIGNAL);
    }
    set_state(*connection, State::reading_body, 0);
    return take_body(*connection);
  }
  connection->outgoing = exchange.take_answer();
  connection->keep = exchange.keeps_connection();
  connection->following = std::move(following);
  connection->exchange.reset();
  if (connection->following) {
    begin_following(*connection);
  } else {
    set_state(*connection, State::sending, EPOLLOUT);
  }
  flush(*connection);
}

void HttpConnections::take_body(Connection& connection) {
  if (connection.exchange->body_failed() || connection.exchange->body_left() == 0) return submit(connection);
  if (connection.input.empty()) return watch(connection, EPOLLIN);
  const auto size =
      static_cast<std::size_t>(std::min<std::uint64_t>(connection.input.size(), connection.exchange->body_left()));
  std::string bytes = connection.input.substr(0, size);
  connection.input.erase(0, size);
  store_body(connection, std::move(bytes));
}

void HttpConnections::read_body(Connection& connection) {
  const auto size =
      static_cast<std::size_t>(std::min<std::uint64_t>(scratch_.size(), connection.exchange->body_left()));
  const ssize_t got = ::recv(connection.socket, scratch_.data(), size, 0);
  if (ended(got)) {
    connection.exchange->end_body();
    submit(connection);
  } else if (got > 0) {
    store_body(connection, std::string(scratch_.data(), static_cast<std::size_t>(got)));
  }
}

// By a worker: a full disk takes its time.
void HttpConnections::store_body(Connection& connection, std::string bytes) {
  set_state(connection, State::working, 0);
  workers_->enqueue([this, id = connection.id, exchange = connection.exchange, bytes = std::move(bytes)] {
    exchange->add_to_body(bytes);
    post([this, id] {
      Connection* const found = find(id);
      if (found == nullptr) return;
      if (stopping_) return close(*found);
      set_state(*found, State::reading_body, 0);
      take_body(*found);
    });
  });
}

void HttpConnections::flush(Connection& connection) {
  const std::uint64_t before = connection.outgoing.sent_bytes();
  const Outgoing::Sent sent = connection.outgoing.send_to(connection.socket);
  if (connection.outgoing.sent_bytes() > before) connection.progress = now_;
  switch (sent) {
    case Outgoing::Sent::failed:
      return close(connection);
    case Outgoing::Sent::some:
      return watch(connection, connection.state == State::following ? EPOLLOUT | EPOLLRDHUP : EPOLLOUT);
    case Outgoing::Sent::all:
      return all_sent(connection);
  }
}

void HttpConnections::all_sent(Connection& connection) {
  if (connection.state == State::following) {
    watch(connection, EPOLLRDHUP);
    return feed(connection.following->topic);
  }
  if (connection.keep && !stopping_) return next_request(connection);
  linger(connection);
}

// Closing a socket with unread input resets the connection, and the answer is lost before the client has read it. So
// say that nothing more will come, and read and drop for a while.
void HttpConnections::linger(Connection& connection) {
  ::shutdown(connection.socket, SHUT_WR);
  if (stopping_) return close(connection);
  connection.input = {};
  set_state(connection, State::lingering, EPOLLIN);
}

void HttpConnections::drop_input(Connection& connection) {
  const ssize_t got = ::recv(connection.socket, scratch_.data(), scratch_.size(), 0);
  if (ended(got)) close(connection);
}

}  // namespace subpixel::server
