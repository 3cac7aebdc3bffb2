// The service's door without sockets: what a client sends goes the way it goes in a connection, through the scan for
// the header's end, the library, the routes and the store, on the calling thread. For fuzzers and tests.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::server {

class HttpDoor {
 public:
  // Makes a data folder of its own at `folder`, with a capture, a run with results, a night and a baseline. No job is
  // worked on. With `require_token` callers must have one; kDoorToken is stored with all rights.
  HttpDoor(const std::filesystem::path& folder, bool require_token);
  ~HttpDoor();

  struct Taken {
    std::vector<int> statuses;  // of the answers, in order
    std::string wrong;          // with an answer; empty: nothing
  };
  // Answers the requests in `bytes`, as long as the connection would be kept.
  Taken take(std::string_view bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// A well-formed request of each of the service's routes; bodies that are JSON are right, or nearly.
std::vector<std::string> example_requests();

// `message`, requests one after another, changed as such: methods, paths, headers, bodies with their lengths. Never
// longer than `most`.
std::string mutated_requests(std::string_view message, std::size_t most, unsigned int seed);

}  // namespace subpixel::server
