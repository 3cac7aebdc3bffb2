// `subpixel submit` against a service: what it prints, and which run it takes.
#include <fstream>

#include "replay/measure/maps.hpp"
#include "replay/results/limits.hpp"
#include "replay/results/results.hpp"
#include "tests/service/service_fixture.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

class Submit : public ServiceTest {
 protected:
  // Submits a capture of `behaviour`; `more` are further options.
  Finished submit(const json& behaviour, const std::string& more) {
    client();
    std::ofstream(folder() / "fake.spcap", std::ios::binary) << fake_capture(behaviour);
    return run_binary("submit fake.spcap --server http://127.0.0.1:" + std::to_string(port()) + " --techniques " +
                          "noaa,msaa:samples=4 --size 32x18 " + more,
                      folder());
  }
  static std::int64_t run_in(const std::string& out) {
    const std::size_t at = out.find("#/runs/");
    return at == std::string::npos ? -1 : std::stoll(out.substr(at + 7));
  }
};

TEST_F(Submit, WaitPrintsTheTableThatReplayPrints) {
  const Finished finished = submit({{"frames", 2}}, "--repeat 5 --reference-samples 64 --wait");
  ASSERT_EQ(finished.code, 0) << finished.error;
  const json document = client().get("/api/runs/" + std::to_string(run_in(finished.out)) + "/results.json");
  const replay::Results results = replay::results_from_json(document);
  ASSERT_EQ(results.results.size(), 4u);
  EXPECT_EQ(results.head.repeat, 5u);
  EXPECT_NE(finished.out.find(replay::to_table(results)), std::string::npos) << finished.out;
  EXPECT_NE(finished.error.find("(0/4)"), std::string::npos) << "progress counts the run's results: " << finished.error;
}

TEST_F(Submit, OnceTakesTheEqualRunThatIsThere) {
  const std::int64_t first = run_in(submit({{"frames", 1}}, "").out);
  const Finished again = submit({{"frames", 1}}, "--once --wait");
  EXPECT_EQ(run_in(again.out), first);
  EXPECT_NE(again.out.find("msaa"), std::string::npos) << "with its table: " << again.out;
  EXPECT_EQ(run_in(submit({{"frames", 1}}, "--once").out), first) << "also when it is done";
  EXPECT_NE(run_in(submit({{"frames", 1}}, "--once --repeat 7").out), first) << "another request";
  EXPECT_NE(run_in(submit({{"frames", 2}}, "--once").out), first) << "another capture";
  EXPECT_NE(run_in(submit({{"frames", 1}}, "").out), first) << "it was not asked for";
  EXPECT_EQ(client().get("/api/runs").at("runs").size(), 4u);
}

TEST_F(Submit, OnceDoesNotTakeWhatEndedBadly) {
  const json broken = {{"frames", 1}, {"fail_at", 0}, {"how", "error"}};
  const Finished first = submit(broken, "--wait");
  EXPECT_EQ(first.code, 3);
  EXPECT_NE(first.error.find("feature shaderInt64"), std::string::npos) << first.error;
  EXPECT_NE(run_in(submit(broken, "--once").out), run_in(first.out));
}

TEST_F(Submit, WrongRequestIsSaidBeforeTheCaptureIsSent) {
  EXPECT_EQ(submit({{"frames", 1}}, "--frames 1..2").code, 2);
  EXPECT_EQ(client().get("/api/captures").at("total"), 0);
}

TEST_F(Submit, AnswerOfAnotherProgramIsNoMistakeOfOurs) {
  httplib::Server other;
  other.Get(".*", [](const httplib::Request&, httplib::Response& response) { response.status = 404; });
  other.Post(".*", [](const httplib::Request&, httplib::Response& response) {
    response.set_content("[1, 2]", "application/json");
  });
  const int other_port = other.bind_to_any_port("127.0.0.1");
  std::thread thread([&] { other.listen_after_bind(); });
  std::ofstream(folder() / "fake.spcap") << fake_capture({{"frames", 1}});
  const Finished finished =
      run_binary("submit fake.spcap --server http://127.0.0.1:" + std::to_string(other_port), folder());
  other.stop();
  thread.join();
  EXPECT_EQ(finished.code, 3) << finished.error;
  EXPECT_NE(finished.error.find("not of this service's kind"), std::string::npos) << finished.error;
}

TEST_F(Submit, LimitsAreServed) {
  EXPECT_EQ(client().get("/api/limits").at("limits"), replay::limits_json());
}

TEST_F(Submit, PalettesAreServed) {
  EXPECT_EQ(client().get("/api/palettes").at("palettes"), replay::palettes_json());
}

}  // namespace
}  // namespace subpixel::tests
