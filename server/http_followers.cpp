// Followers of topics: entries of the loop that get text whenever something happens.
#include <fmt/format.h>
#include <sys/epoll.h>

#include "server/http_connections.hpp"

namespace subpixel::server {
namespace {

// Sending to one follower takes the loop some time, so news for many come less often.
constexpr std::chrono::microseconds kTimePerFollower{200};
constexpr std::size_t kFewFollowers = 16;  // get news at once

}  // namespace

std::string HttpConnections::chunk(const std::string& text) {
  return text.empty() ? "" : fmt::format("{:x}\r\n{}\r\n", text.size(), text);
}

void HttpConnections::begin_following(Connection& connection) {
  connection.seen_version = 0;
  topics_[connection.following->topic].followers.insert(connection.id);
  set_state(connection, State::following, EPOLLOUT | EPOLLRDHUP);
}

void HttpConnections::stop_following(Connection& connection) {
  if (!connection.following) return;
  const auto topic = topics_.find(connection.following->topic);
  topic->second.followers.erase(connection.id);
  if (topic->second.followers.empty() && !topic->second.feeding) topics_.erase(topic);
  connection.following.reset();
}

void HttpConnections::changed(std::int64_t topic) {
  post([this, topic] {
    const auto found = topics_.find(topic);
    if (found == topics_.end()) return;
    ++found->second.version;
    feed(topic);
  });
}

// Has a worker make the news of all followers that lack some and have read what they got; so one that does not read
// costs no more than what he got last.
void HttpConnections::feed(std::int64_t number) {
  const auto found = topics_.find(number);
  if (found == topics_.end() || found->second.feeding || now_ < found->second.next_feed || stopping_) return;
  Topic& topic = found->second;
  std::map<Position, Portion> portions;
  std::vector<Id> followers;
  for (const Id id : topic.followers) {
    const Connection& connection = connections_.at(id);
    if (connection.seen_version == topic.version || !connection.outgoing.empty()) continue;
    portions[{connection.following->position, connection.following->chunked}];
    followers.push_back(id);
  }
  if (followers.empty()) return;
  topic.feeding = true;
  if (topic.followers.size() > kFewFollowers) topic.next_feed = now_ + kTimePerFollower * topic.followers.size();
  workers_->enqueue([this, number, version = topic.version, portions = std::move(portions),
                     followers = std::move(followers)]() mutable {
    for (auto& [position, portion] : portions) {
      portion.news = work_.news(number, position.first);
      if (!portion.news) continue;
      std::string& text = portion.news->text;
      if (position.second) text = chunk(text) + (portion.news->last ? "0\r\n\r\n" : "");
      portion.text = std::make_shared<const std::string>(std::move(text));
    }
    post([this, number, version, portions = std::move(portions), followers = std::move(followers)] {
      fed(number, version, portions, followers);
    });
  });
}

void HttpConnections::fed(std::int64_t number, std::uint64_t version, const std::map<Position, Portion>& portions,
                          const std::vector<Id>& followers) {
  for (const Id id : followers) {
    Connection* const connection = find(id);
    if (connection == nullptr) continue;
    const Portion& portion = portions.at({connection->following->position, connection->following->chunked});
    if (!portion.news) {  // they come back with what they have
      close(*connection);
      continue;
    }
    connection->outgoing.append(portion.text);
    connection->following->position = portion.news->position;
    connection->seen_version = portion.news->more ? 0 : version;
    if (portion.news->last) {
      stop_following(*connection);
      set_state(*connection, State::sending, EPOLLOUT);
    }
    flush(*connection);
  }
  const auto topic = topics_.find(number);  // stays while it is being fed
  topic->second.feeding = false;
  if (topic->second.followers.empty()) topics_.erase(topic);
  feed(number);
}

}  // namespace subpixel::server
