// One request on its way through the library, and its answer. The library reads and writes as if it were a client's
// socket, but never waits: the header has come, and the answer is collected, for the connection to send.
#pragma once

#include <httplib.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/outgoing.hpp"
#include "server/upload.hpp"

namespace subpixel::server {

// An answer that goes on with what happens to a topic.
struct Following {
  std::int64_t topic = 0;
  std::int64_t position = 0;          // what the client has
  bool chunked = true;                // the client knows chunks (HTTP/1.1)
  std::shared_ptr<const void> place;  // given back when the client has gone
};

// Makes the file for a body of that length. Throws HttpError where there is no room.
using OpenBody = std::function<std::unique_ptr<Upload>(std::uint64_t length)>;

class Exchange final : public httplib::Stream {
 public:
  struct Peer {
    std::string ip;
    int port = 0;
  };
  // `open_body` and `spill_folder` outlive the exchange.
  Exchange(std::string header, Peer peer, bool last_of_connection, const OpenBody& open_body,
           const std::filesystem::path& spill_folder);

  // For handlers, on the thread that runs them. ------------------------------------------------
  static Exchange& current();
  // The request's body. Throws HttpError when it ended early. As long as it has still to come, this ends the handler:
  // it is called once more when the body is there, and must not have changed anything before.
  Upload& body();
  // Tells it from others in the log and in the answer.
  const std::string& id() const { return id_; }
  std::uint64_t body_bytes() const { return body_length_; }
  // What the header's Range fields say.
  const std::vector<std::string>& ranges() const { return ranges_; }
  // What follows the answer's header. To be called by a content provider, which returns false then: so the library's
  // part has ended.
  void send_file(std::shared_ptr<const OpenFile> file, std::uint64_t first, std::uint64_t length);
  void follow(Following following);

  // For the server. ---------------------------------------------------------------------------
  // Runs `process`, the library, over the request, from its beginning.
  void run(const std::function<bool(bool last_of_connection, bool& closed)>& process);
  // The one a proxy gave it.
  void set_id(std::string id) { id_ = std::move(id); }
  // The library has read the header: what it says.
  void frame(std::uint64_t body_length, bool expects_continue, bool last);
  bool body_has_come() const { return body_ && body_->size_bytes() == body_length_; }

  // For the connection. -----------------------------------------------------------------------
  bool waits_for_body() const { return waits_for_body_; }
  bool expects_continue() const { return expects_continue_; }
  std::uint64_t body_left() const { return body_length_ - body_->size_bytes(); }
  void add_to_body(std::string_view bytes);
  bool body_failed() const { return body_failure_ != nullptr; }
  void end_body() { body_ended_ = true; }  // no more of it will come
  Outgoing take_answer() { return std::move(answer_); }
  std::optional<Following> take_following() { return std::exchange(following_, std::nullopt); }
  bool keeps_connection() const { return keeps_connection_; }

  // httplib::Stream
  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string&, int&) const override {}  // nothing asks
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  std::string id_;
  std::string header_;               // without Range fields: to those the library has answers of its own
  std::vector<std::string> ranges_;  // their values
  Peer peer_;
  bool last_of_connection_;
  const OpenBody& open_body_;
  const std::filesystem::path& spill_folder_;

  std::size_t read_bytes_ = 0;  // of the header
  bool framed_ = false, waits_for_body_ = false, expects_continue_ = false, last_ = false;
  std::uint64_t body_length_ = 0;
  std::unique_ptr<Upload> body_;
  std::exception_ptr body_failure_;
  bool body_ended_ = false;

  Outgoing answer_;
  bool continues_ = false;  // after what the library wrote
  std::optional<Following> following_;
  bool keeps_connection_ = false;
};

}  // namespace subpixel::server
