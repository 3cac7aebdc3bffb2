#include "server/http_exchange.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <strings.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <random>

#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

// The library hands a handler nothing of ours, but it calls it on the thread that it was called on.
thread_local Exchange* current_exchange = nullptr;

// Of no other request, also of an earlier process.
std::string new_id() {
  static const std::uint32_t process = std::random_device{}();
  static std::atomic<std::uint64_t> number{0};
  return fmt::format("{:08x}-{}", process, ++number);
}

// Takes the fields of that name out of a header and returns their values. A line ends where the library ends one, at
// its LF.
std::vector<std::string> take_fields(std::string& header, std::string_view name) {
  std::vector<std::string> values;
  std::size_t begin = header.find('\n') + 1;  // after the request's line
  while (begin > 0 && begin < header.size()) {
    const std::size_t end = header.find('\n', begin);
    const std::size_t colon = begin + name.size();
    if (end == std::string::npos) break;
    if (colon < end && header[colon] == ':' && ::strncasecmp(header.data() + begin, name.data(), name.size()) == 0) {
      const std::size_t value = std::min(header.find_first_not_of(" \t", colon + 1), end);
      values.push_back(header.substr(value, std::min(header.find('\r', value), end) - value));
      header.erase(begin, end + 1 - begin);
    } else {
      begin = end + 1;
    }
  }
  return values;
}

}  // namespace

Exchange::Exchange(std::string header, Peer peer, bool last_of_connection, const OpenBody& open_body,
                   const std::filesystem::path& spill_folder)
    : id_(new_id()),
      header_(std::move(header)),
      ranges_(take_fields(header_, "range")),
      peer_(std::move(peer)),
      last_of_connection_(last_of_connection),
      open_body_(open_body),
      spill_folder_(spill_folder),
      answer_(spill_folder_) {}

Exchange& Exchange::current() {
  return *current_exchange;
}

Upload& Exchange::body() {
  if (!body_) body_ = open_body_(body_length_);
  if (body_failure_) std::rethrow_exception(body_failure_);
  if (body_left() > 0) {
    waits_for_body_ = !body_ended_;  // then nobody gets this answer
    throw HttpError(400, "the request is incomplete",
                    fmt::format("{} of {} bytes arrived", body_->size_bytes(), body_length_), "body");
  }
  return *body_;
}

void Exchange::send_file(std::shared_ptr<const OpenFile> file, std::uint64_t first, std::uint64_t length) {
  answer_.append(std::move(file), first, length);
  continues_ = true;
}

void Exchange::follow(Following following) {
  following_ = std::move(following);
  continues_ = true;
}

void Exchange::run(const std::function<bool(bool, bool&)>& process) {
  read_bytes_ = 0;
  framed_ = waits_for_body_ = continues_ = false;
  answer_ = Outgoing(spill_folder_);
  bool closed = false, served = false;
  current_exchange = this;
  try {
    served = process(last_of_connection_, closed) || continues_;
  } catch (const std::exception& error) {  // outside of the handler, which has the library's own net
    spdlog::error("request: {}", error.what());
    answer_ = Outgoing(spill_folder_);
  }
  current_exchange = nullptr;
  // What is left of a header or body would be read as the next request.
  const bool all_read = framed_ && (body_length_ == 0 || body_has_come());
  keeps_connection_ = served && !closed && !last_ && !last_of_connection_ && all_read;
  if (!waits_for_body_) body_.reset();  // before the client can see the answer
}

void Exchange::frame(std::uint64_t body_length, bool expects_continue, bool last) {
  framed_ = true;
  body_length_ = body_length;
  expects_continue_ = expects_continue;
  last_ = last;
}

void Exchange::add_to_body(std::string_view bytes) {
  try {
    body_->append(bytes);
  } catch (const std::exception&) {
    body_failure_ = std::current_exception();
  }
}

// Only the header: bodies are not read through the library.
ssize_t Exchange::read(char* to, std::size_t size) {
  const std::size_t taken = std::min(size, header_.size() - read_bytes_);
  std::memcpy(to, header_.data() + read_bytes_, taken);
  read_bytes_ += taken;
  return static_cast<ssize_t>(taken);
}

ssize_t Exchange::write(const char* from, std::size_t size) {
  answer_.append(std::string_view(from, size));
  return static_cast<ssize_t>(size);
}

void Exchange::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip = peer_.ip;
  port = peer_.port;
}

}  // namespace subpixel::server
