// Workers that go wrong in every way: the run ends with a reason, its results stay, the service goes on.
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
  EXPECT_EQ(run.at("stored_results"), GetParam().how == "no_done" ? 6 : 2);

  const std::string good = client().upload_fake({{"frames", 1}});
  EXPECT_EQ(client().wait_for_end(client().start_run(good)).at("status"), "done");
}

std::vector<Failure> failures() {
  std::vector<Failure> all{
      {"kill", "signal 9"},
      {"exit", "exit code 4; its last words: the driver lost the device"},
      {"error", "feature shaderInt64"},
      {"internal", "internal error: no such shader: please report it"},
      {"hang", "said nothing for 1500 ms"},
      {"chatter", "longer than 3 s"},
      {"garbage", "line 7 is no valid message"},
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

TEST_F(Worker, SeveralRunAtATimeWhenAskedFor) {
  server::ServiceOptions wide = options();
  wide.worker.count = 3;
  start(wide);
  const std::string hash = client().upload_fake({{"frames", 100}, {"result_ms", 50}});
  std::vector<std::int64_t> runs;
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
