// All clients' connections, on one thread that never waits for one of them: it takes in headers and bodies as they
// come, hands whole requests to worker threads and sends answers as they are read. So a slow client costs a descriptor
// and little memory, but no thread.
#pragma once

#include <httplib.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/header_scan.hpp"
#include "server/http_exchange.hpp"
#include "server/http_limits.hpp"
#include "server/outgoing.hpp"

namespace subpixel::server {

// What a follower of a topic gets next.
struct News {
  std::string text;
  std::int64_t position = 0;  // what he has then
  bool more = false;          // there is more already
  bool last = false;          // nothing will follow
};

class HttpConnections {
 public:
  struct Work {
    std::function<void(Exchange&)> answer;  // on several threads at a time, as the next
    // What followers at `position` have not got yet; nothing ends their connections.
    std::function<std::optional<News>(std::int64_t topic, std::int64_t position)> news;
    OpenBody open_body;
    std::string heartbeat;  // what a follower gets when nothing happens
  };
  // `spill_folder` takes answers that are too large for memory.
  HttpConnections(const HttpLimits& limits, std::filesystem::path spill_folder);
  ~HttpConnections();
  HttpConnections(const HttpConnections&) = delete;
  HttpConnections& operator=(const HttpConnections&) = delete;

  // Serves those who connect to the listening socket until stop(); answers that are under way are finished.
  void run(int listener, Work work);
  // From any thread, also before run().
  void stop();
  // Something happened to a topic. From any thread.
  void changed(std::int64_t topic);

 private:
  using Clock = std::chrono::steady_clock;
  using Id = std::uint64_t;
  // In the order in which connections are given up when there are too many; `working` ones are not.
  enum class State { closed, lingering, reading_header, reading_body, sending, following, working };

  struct Connection {
    explicit Connection(const std::filesystem::path& spill_folder) : outgoing(spill_folder) {}
    Id id = 0;
    int socket = -1;
    Exchange::Peer peer;
    State state = State::reading_header;
    std::uint32_t watched = 0;          // epoll's events
    Clock::time_point progress;         // when a byte came or went, or the state began
    Clock::time_point header_deadline;  // while there is a part of a header
    std::string input;                  // came and was not used yet
    HeaderScan header;
    std::size_t requests = 0;
    std::shared_ptr<Exchange> exchange;  // the worker's alone in the state `working`
    Outgoing outgoing;
    bool keep = false;  // goes on after the answer
    std::optional<Following> following;
    std::uint64_t seen_version = 0;  // of the topic
  };
  // Those who follow the same thing get the same text, which is made once.
  struct Topic {
    std::uint64_t version = 1;
    bool feeding = false;  // a worker looks for news
    Clock::time_point next_feed;
    std::set<Id> followers;
  };
  using Position = std::pair<std::int64_t, bool>;  // and whether in chunks
  struct Portion {
    std::optional<News> news;
    std::shared_ptr<const std::string> text;
  };

  // The loop.
  void post(std::function<void()> task);
  void run_posted();
  void on_event(Id id, std::uint32_t events);
  void sweep();
  void check_time(Connection& connection);
  void begin_stop();
  Connection* find(Id id);
  void watch(Connection& connection, std::uint32_t events);
  void set_state(Connection& connection, State state, std::uint32_t events);
  void close(Connection& connection);
  void forget_closed();
  // Accepting.
  std::size_t open_connections() const { return connections_.size() - closed_.size(); }
  void accept_some();
  void add(int socket, Exchange::Peer peer);
  bool make_room();
  void listen_for_more(bool yes);
  // A connection's way.
  void read_header(Connection& connection);
  void next_request(Connection& connection);
  void look_for_header(Connection& connection);
  void refuse(Connection& connection, int status, const std::string& why);
  void submit(Connection& connection);
  void answered(Id id);
  void take_body(Connection& connection);
  void read_body(Connection& connection);
  void store_body(Connection& connection, std::string bytes);
  void flush(Connection& connection);
  void all_sent(Connection& connection);
  void linger(Connection& connection);
  void drop_input(Connection& connection);
  // Followers.
  static std::string chunk(const std::string& text);
  void begin_following(Connection& connection);
  void stop_following(Connection& connection);
  void feed(std::int64_t topic);
  void fed(std::int64_t topic, std::uint64_t version, const std::map<Position, Portion>& portions,
           const std::vector<Id>& followers);

  const HttpLimits limits_;
  const std::filesystem::path spill_folder_;
  Work work_;
  std::unique_ptr<httplib::ThreadPool> workers_, body_workers_;

  int epoll_, wake_, listener_ = -1;
  std::size_t most_connections_ = 0;
  Id next_id_ = 2;  // 0 and 1 are the listener and the wake-up
  std::unordered_map<Id, Connection> connections_;
  std::unordered_map<std::string, std::size_t> by_address_;
  std::vector<Id> closed_;  // since the last turn
  std::map<std::int64_t, Topic> topics_;
  Clock::time_point now_, stop_deadline_;
  bool listening_ = false, stopping_ = false;
  std::array<char, 1 << 18> scratch_;

  std::atomic<bool> stop_requested_{false};
  std::mutex posted_mutex_;
  std::vector<std::function<void()>> posted_;  // for the loop's thread
};

}  // namespace subpixel::server
