// Workers that go wrong in every way: the run ends with a reason, its results stay, the service goes on.
#include <map>

#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

// The sanitizers use most of the address space themselves, and take signals of bad accesses.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

struct Failure {
  std::string how;
  std::string reason;  // a part of the run's reason
};

void PrintTo(const Failure& failure, std::ostream* out) {
  *out << failure.how;
}

class WorkerFailure : public ServiceTest, public testing::WithParamInterface<Failure> {};

TEST_P(WorkerFailure, EndsTheRunWithAReason) {
  server::ServiceOptions strict = options();
  strict.worker.limits.silence = std::chrono::milliseconds(1500);
  strict.worker.limits.duration = std::chrono::milliseconds(3000);
  if (!kSanitized) strict.worker.limits.address_space_bytes = std::uint64_t{8} << 30;
  start(strict);
  const std::string hash = client().upload_fake({{"frames", 3}, {"fail_at", 2}, {"how", GetParam().how}});
  const json run = client().wait_for_end(client().start_run(hash));
  EXPECT_EQ(run.at("status"), "failed") << run;
  EXPECT_NE(run.at("reason").get<std::string>().find(GetParam().reason), std::string::npos) << run.at("reason");
  const bool tried_again = run.at("reason").get<std::string>().find("given up after 3 starts") != std::string::npos;
  EXPECT_EQ(tried_again, GetParam().reason.starts_with("signal ")) << run.at("reason");
  EXPECT_EQ(run.at("stored_results"), GetParam().how == "no_done" ? 6 : 2);

  const std::string good = client().upload_fake({{"frames", 1}});
  EXPECT_EQ(client().wait_for_end(client().start_run(good)).at("status"), "done");
}

std::vector<Failure> failures() {
  std::vector<Failure> all{
      {"kill", "signal 9"},
      {"ill", "signal 4 (Illegal instruction); it was at \"replay: frame 1 noaa\" on no device at all, 1.0; try "},
      {"exit", "exit code 4; its last words: the driver lost the device"},
      {"error", "feature shaderInt64"},
      {"internal", "internal error: no such shader: please report it"},
      {"hang", "said nothing for 1500 ms"},
      {"chatter", "longer than 3 s"},
      {"garbage", "line 9 was refused: worker message: the line is no valid JSON"},
      {"long_line", "a line of more than 1048576 bytes"},
      {"quit", "without saying that it was done"},
      {"no_done", "without saying that it was done"},
      {"escape", "not a plain file name"},
      {"foreign", "outside of the run"},
  };
  if (!kSanitized) {
    all.push_back({"segv", "signal 11"});
    all.push_back({"memory", "signal 6"});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, WorkerFailure, testing::ValuesIn(failures()),
                         [](const auto& failure) { return failure.param.how; });

using Worker = ServiceTest;

TEST_F(Worker, MissingProgramIsAReason) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  server::ServiceOptions without = options();
  without.worker.program = "/nonexistent/subpixel";
  start(without);
  const json run = client().wait_for_end(client().start_run(hash));
  EXPECT_EQ(run.at("status"), "failed");
  EXPECT_NE(run.at("reason").get<std::string>().find("can't be executed"), std::string::npos) << run;
}

TEST_F(Worker, OneThatDiesNowAndThenIsStartedAgain) {
  const json dies = {{"frames", 2}, {"fail_at", 2}, {"how", "kill"}, {"times", 3}};
  const std::string hash = client().upload_fake(dies);
  const auto run_with = [&](int retries) {
    const httplib::Result started = client().post_run(
        {{"capture", hash}, {"techniques", {"noaa", "msaa"}}, {"width", 32}, {"height", 18}, {"retries", retries}});
    EXPECT_TRUE(started && started->status == 201) << started->body;
    return client().wait_for_end(json::parse(started->body).at("id").get<std::int64_t>());
  };
  // The first start has results; the one after it has none.
  const json given_up = run_with(1);
  EXPECT_EQ(given_up.at("status"), "failed");
  EXPECT_NE(given_up.at("reason").get<std::string>().find("signal 9"), std::string::npos) << given_up;
  EXPECT_NE(given_up.at("reason").get<std::string>().find("given up after 2 starts"), std::string::npos) << given_up;
  std::filesystem::remove(folder() / "data" / "cache" / "times");
  const json went_on = run_with(3);
  EXPECT_EQ(went_on.at("status"), "done") << went_on;
  EXPECT_EQ(went_on.at("reason"), "");
  EXPECT_EQ(went_on.at("stored_results"), 4);
  for (const json& wrong : {json(-1), json(1001), json("2"), json(0.5)}) {
    const httplib::Result refused =
        client().post_run({{"capture", hash}, {"techniques", {"noaa"}}, {"retries", wrong}});
    error_of(refused, 400);
  }
}

TEST_F(Worker, PriorityComesFirstAndSubmittersTakeTurns) {
  const std::string slow = client().upload_fake({{"frames", 1}, {"result_ms", 400}});
  const std::string quick = client().upload_fake({{"frames", 1}});
  const auto submit = [&](const std::string& capture, const std::string& address, int priority) {
    Client from(port());
    from.http().set_interface(address);
    const httplib::Result started = from.post_run(
        {{"capture", capture}, {"techniques", {"noaa"}}, {"width", 32}, {"height", 18}, {"priority", priority}});
    EXPECT_TRUE(started && started->status == 201) << address;
    const json run = json::parse(started->body);
    EXPECT_EQ(run.at("submitter"), address);
    EXPECT_EQ(run.at("priority"), priority);
    return run.at("id").get<std::int64_t>();
  };
  std::vector<std::pair<std::int64_t, std::string>> runs;
  runs.emplace_back(submit(slow, "127.0.0.1", 5), "first of 1");
  while (client().get("/api/runs/" + std::to_string(runs[0].first)).at("status") == "queued") {
  }
  for (const char* const name : {"second of 1", "third of 1"}) runs.emplace_back(submit(quick, "127.0.0.1", 5), name);
  runs.emplace_back(submit(quick, "127.0.0.1", 4), "low of 1");
  for (const char* const name : {"first of 2", "second of 2"}) runs.emplace_back(submit(quick, "127.0.0.2", 5), name);
  runs.emplace_back(submit(quick, "127.0.0.3", 9), "high of 3");
  std::map<std::string, std::string> order;
  for (const auto& [id, name] : runs) order[client().wait_for_end(id).at("started_utc")] = name;
  std::vector<std::string> names;
  names.reserve(order.size());
  for (const auto& [started, name] : order) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"first of 1", "high of 3", "first of 2", "second of 1", "second of 2",
                                             "third of 1", "low of 1"}));
}

TEST_F(Worker, SeveralRunAtATimeWhenAskedFor) {
  server::ServiceOptions wide = options();
  wide.worker.count = 3;
  start(wide);
  const std::string hash = client().upload_fake({{"frames", 100}, {"result_ms", 50}});
  std::vector<std::int64_t> runs;
  runs.reserve(4);
  for (int i = 0; i < 4; ++i) runs.push_back(client().start_run(hash));
  int most = 0;
  for (int i = 0; i < 200 && most < 3; ++i) {
    most = std::max(most, client().get("/api/health").at("running").get<int>());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(most, 3);
  for (const std::int64_t run : runs)
    client().http().Post("/api/runs/" + std::to_string(run) + "/cancel", "", "application/json");
  for (const std::int64_t run : runs) EXPECT_EQ(client().wait_for_end(run).at("status"), "cancelled");
}

}  // namespace
}  // namespace subpixel::tests
