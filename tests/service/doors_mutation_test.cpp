// Short forms of the fuzzers of server/fuzz: what clients, workers and configurations say, changed as such. Every
// answer has a status that is not our mistake, its length and its JSON; every document is taken or refused.
#include <fmt/format.h>

#include <array>
#include <map>
#include <random>

#include "base/fuzz/json_mutator.hpp"
#include "server/fuzz/http_door.hpp"
#include "server/fuzz/json_doors.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::HttpDoor;
using server::JsonDoors;

class DoorsMutation : public ServiceTest {};

TEST_F(DoorsMutation, TheExamplesAreAnsweredAsTheyShould) {
  for (const bool require_token : {false, true}) {
    HttpDoor door(folder() / fmt::format("door{}", require_token), require_token);
    for (const std::string& request : server::example_requests()) {
      const HttpDoor::Taken taken = door.take(request);
      EXPECT_EQ(taken.wrong, "");
      ASSERT_EQ(taken.statuses.size(), 1U) << request;
      const bool refused = request.starts_with("POST /api/captures?") || request.starts_with("DELETE /api/runs/3") ||
                           request.starts_with("POST /api/sign-in");
      EXPECT_EQ(taken.statuses[0] >= 400, refused) << request << taken.statuses[0];
    }
    const std::string nameless = "GET /api/runs HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    EXPECT_EQ(door.take(nameless).statuses, std::vector{require_token ? 401 : 200});
    EXPECT_EQ(door.take(nameless + nameless).statuses.size(), 2U) << "a connection is kept";
  }
}

TEST_F(DoorsMutation, EveryAnswerIsWhole) {
  HttpDoor open(folder() / "open", false), guarded(folder() / "guarded", true);
  const std::vector<std::string> examples = server::example_requests();
  std::map<int, int> statuses;
  std::string message;
  for (unsigned int i = 0; i < 4000; ++i) {
    if (i % 8 == 0) message = examples[i / 8 % examples.size()];
    message = server::mutated_requests(message, 8192, i);
    const HttpDoor::Taken taken = (i % 3 == 0 ? guarded : open).take(message);
    ASSERT_EQ(taken.wrong, "") << "message " << i;
    for (const int status : taken.statuses) ++statuses[status];
  }
  for (const int status : {200, 201, 400, 401, 404, 405, 411, 413, 415, 421, 422})
    EXPECT_GT(statuses[status], 0) << status << " was never answered";
}

TEST_F(DoorsMutation, EveryDocumentIsTakenOrRefused) {
  constexpr std::array<std::string_view, 4> kWords{"", "noaa", "all", ".."};
  JsonDoors doors(folder() / "json");
  std::minstd_rand random(1);
  for (std::size_t door = 0; door < JsonDoors::examples().size(); ++door) {
    std::map<JsonDoors::Outcome, int> outcomes;
    for (const std::string& example : JsonDoors::examples()[door]) {
      EXPECT_EQ(doors.take(door, example), JsonDoors::Outcome::taken) << example;
      for (int i = 0; i < 1000; ++i) {
        const std::string made = mutated_json(example, kWords, random);
        ASSERT_NO_THROW(++outcomes[doors.take(door, made)]) << door << ": " << made;
      }
    }
    EXPECT_GT(outcomes[JsonDoors::Outcome::refused], 100) << door;
    EXPECT_GT(outcomes[JsonDoors::Outcome::taken], 10) << door;
  }
}

TEST_F(DoorsMutation, NumbersBeyondAllBoundsAreRefused) {
  JsonDoors doors(folder() / "json");
  for (std::size_t door = 0; door < JsonDoors::examples().size(); ++door) {
    std::string text = JsonDoors::examples()[door][0];
    EXPECT_EQ(doors.take(door, text.insert(1, "\"x\":1e999,")), JsonDoors::Outcome::refused) << door;
  }
  HttpDoor open(folder() / "open", false);
  const std::string body = R"({"capture":1e999})";
  const HttpDoor::Taken taken =
      open.take(fmt::format("POST /api/runs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                            "Content-Length: {}\r\n\r\n{}",
                            body.size(), body));
  EXPECT_EQ(taken.statuses, std::vector{400}) << taken.wrong;
}

TEST_F(DoorsMutation, NoDepthOfADocumentIsTooMuch) {
  JsonDoors doors(folder() / "json");
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  for (std::size_t door = 0; door < JsonDoors::examples().size(); ++door) {
    EXPECT_EQ(doors.take(door, deep), JsonDoors::Outcome::refused) << door;
    std::string within = JsonDoors::examples()[door][0];
    within.insert(1, "\"x\":" + deep + ",");
    EXPECT_EQ(doors.take(door, within), JsonDoors::Outcome::refused) << door;
  }
}

}  // namespace
}  // namespace subpixel::tests
