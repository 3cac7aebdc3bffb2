// Numbers over nights: what moved, between which nights, and which commit moved it.
#include "server/nightly/trends.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "base/error.hpp"
#include "server/nightly/bisect.hpp"
#include "tests/service/nights_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::CellTrend;
using server::ChangePoint;

class Trends : public Nights {
 protected:
  CellTrend trend(const std::string& technique) const {
    server::Store store(data() / "subpixel.sqlite");
    return cell_trend(server::NightStore(store), "test", "one", technique, 100);
  }
  server::NightRecord commit_night(const std::string& commit) const {
    return night(config({{{"path", "one.spcap"}}}), commit);
  }
};

std::vector<ChangePoint> changes_of(const CellTrend& trend, const std::string& number) {
  std::vector<ChangePoint> changes = change_points(trend);
  std::erase_if(changes, [&](const ChangePoint& change) { return change.number != number; });
  return changes;
}

TEST_F(Trends, AnExactNumberMovesBetweenTwoNights) {
  a_capture();
  const std::int64_t first = commit_night("aaa").id;
  ASSERT_TRUE(approve(first));
  commit_night("aaa");
  tweak({{"technique", "msaa"}, {"executions", 7}});
  const std::int64_t moved = commit_night("bbb").id;
  commit_night("bbb");
  const CellTrend found = trend("msaa:samples=8");
  ASSERT_EQ(found.nights.size(), 4u);
  EXPECT_TRUE(found.nights[0].approved);
  EXPECT_FALSE(found.nights[1].approved);
  EXPECT_EQ(found.nights[2].commit, "bbb");
  EXPECT_EQ(found.nights[1].bands.at("executions").high, found.nights[0].values.at("executions"));
  EXPECT_EQ(found.nights[1].bands.count("error.flip_mean"), 0u) << "no gate is on it";
  EXPECT_NEAR(*found.nights[1].bands.at("error.mse").high, 1.01 * found.nights[0].values.at("error.mse"), 1e-12);
  const std::vector<ChangePoint> changes = change_points(found);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].number, "executions");
  EXPECT_EQ(found.nights[changes[0].after].id, moved);
  EXPECT_EQ(changes[0].to - changes[0].from, 14) << "seven in each of two frames";
  EXPECT_NE(change_text(found, changes[0]).find("between night 2 (aaa) and night 3 (bbb)"), std::string::npos)
      << change_text(found, changes[0]);
  EXPECT_TRUE(change_points(trend("msaa:samples=4")).size() == 1 && change_points(trend("noaa")).empty());

  start(options());
  const json document =
      client().get("/api/nights/trends?name=test&capture=one&technique=msaa%3Asamples%3D8").at("trends").at(0);
  EXPECT_EQ(document.at("changes").at(0).at("before"), 2);
  EXPECT_EQ(document.at("nights").at(3).at("values").at("executions"), found.nights[3].values.at("executions"));
  EXPECT_EQ(client().get("/api/nights/trends?name=test").at("trends").size(), 3u);
  client().get("/api/nights/trends?name=other", 404);
  client().get("/api/nights/trends", 400);
  client().get("/api/nights/trends?name=test&capture=one", 400);
  client().get("/api/nights/trends?name=test&limit=0", 400);
  const httplib::Result csv = client().http().Get("/api/nights/trends.csv?name=test");
  EXPECT_EQ(csv->get_header_value("Content-Type"), "text/csv; charset=utf-8");
  EXPECT_TRUE(csv->body.starts_with("night,started_utc,commit,"));
  EXPECT_NE(csv->body.find(",one,noaa,executions,"), std::string::npos);
  EXPECT_EQ(csv->body.find("night,started_utc", 1), std::string::npos) << "names stand once";
}

// Nights whose times are made up: medians of `first` nights around 1, of the others around `then`.
CellTrend made_up(std::size_t first, std::size_t others, double then) {
  CellTrend trend{"test", "one", "fxaa", {}};
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.02);
  for (std::size_t i = 0; i < first + others; ++i) {
    server::TrendNight night;
    night.id = static_cast<std::int64_t>(i + 1);
    night.values["time.msaa"] = (i < first ? 1 : then) * std::exp(noise(random));
    trend.nights.push_back(std::move(night));
  }
  return trend;
}

TEST(TrendsOfTimes, MoveWhereChanceDoesNotSayIt) {
  EXPECT_TRUE(change_points(made_up(16, 0, 1)).empty());
  const std::vector<ChangePoint> changes = change_points(made_up(8, 8, 1.1));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].after, 8u);
  EXPECT_LE(*changes[0].p, 0.01);
  EXPECT_NEAR(changes[0].to / changes[0].from, 1.1, 0.03);
  EXPECT_TRUE(change_points(made_up(2, 1, 1.5)).empty()) << "three nights say nothing";
  CellTrend failed = made_up(2, 1, 1.5);
  failed.nights[2].is_slower = true;
  EXPECT_EQ(change_points(failed).size(), 1u) << "but their gate does";
}

TEST_F(Trends, BisectFindsTheCommit) {
  a_capture();
  ASSERT_TRUE(approve(commit_night("").id));
  const std::filesystem::path repository = folder() / "game";
  const auto shell = [&](const std::string& words) {
    const std::string command = "cd '" + repository.string() + "' && (" + words + ") >/dev/null 2>&1";
    return std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe)
  };
  std::filesystem::create_directories(repository);
  ASSERT_EQ(shell("git init && git config user.name t && git config user.email t@localhost"), 0);
  std::vector<std::string> commits;
  for (int i = 0; i < 8; ++i) {
    // From the sixth on an execution more; the fourth can't be built,
    // and builds change a file that is under version control.
    std::ofstream(repository / "tweak.json") << json{{"technique", "msaa"}, {"executions", i < 5 ? 0 : 3}};
    std::ofstream(repository / "build.sh")
        << (i == 3 ? "exit 1\n" : "echo >>number && cp tweak.json \"$1\" && echo \"$2\"\n");
    std::ofstream(repository / "number") << i;
    ASSERT_EQ(shell("git add -A && git commit -m 'change " + std::to_string(i) + "'"), 0);
    ASSERT_EQ(shell("git rev-parse HEAD >.git/head"), 0);
    std::ifstream(repository / ".git/head") >> commits.emplace_back();
  }
  commit_night(commits.front());
  tweak({{"technique", "msaa"}, {"executions", 3}});
  commit_night(commits.back() + "-changed");
  const CellTrend found = trend("msaa:samples=8");
  const std::vector<ChangePoint> changes = changes_of(found, "executions");
  ASSERT_EQ(changes.size(), 1u);

  server::BisectRequest request;
  {
    server::Store store(data() / "subpixel.sqlite");
    request.night = server::NightStore(store).nights_of_cell("test", "one", "msaa:samples=8", 10).front();
  }
  // The fake worker reads the tweak where the capture says that it is.
  request.capture = "one";
  request.technique = "msaa:samples=8";
  request.number = "executions";
  request.from = changes[0].from;
  request.to = changes[0].to;
  request.good = commits.front();
  request.bad = commits.back() + "-changed";
  request.repository = repository;
  request.data = data();
  const std::filesystem::path work = folder() / "bisect";
  const std::filesystem::path tweaked = work / "data" / "cache" / "tweak.json";
  a_capture(json::object(), tweaked);
  request.command =
      "test \"$(git rev-parse HEAD)\" = {commit} && sh build.sh '" + tweaked.string() + "' '" SUBPIXEL_FAKE_WORKER "'";
  server::NightOptions options;
  options.worker = SUBPIXEL_FAKE_WORKER;
  const server::BisectResult result = bisect(request, work, options);
  EXPECT_EQ(result.first_bad, commits[5]);
  EXPECT_EQ(result.subject, "change 5");
  EXPECT_GE(result.steps.size(), 2u);
  EXPECT_TRUE(std::ranges::any_of(result.steps, [&](const server::BisectStep& step) {
    return step.commit == commits[3] && step.verdict.starts_with("skip: the command failed") && !step.value;
  }));
  EXPECT_LE(result.steps.size(), 5u);
  EXPECT_EQ(shell("test -z \"$(git status --porcelain)\" && test \"$(git rev-parse --abbrev-ref HEAD)\" != HEAD"), 0)
      << "the repository is as it was";

  request.command = "make";
  EXPECT_THROW(bisect(request, folder() / "other", options), UsageError);
  request.command = "true {commit}";
  request.bad = "no-such-commit";
  EXPECT_THROW(bisect(request, folder() / "other", options), InputError);
}

// A commit that is a folder of shaders, a number that is a time, a capture that was found by its tag.
TEST_F(Trends, BisectReplaysTheCellAndWhatItsTimeIsComparedWith) {
  const std::filesystem::path work = folder() / "bisect", cache = work / "data" / "cache";
  start(options());
  const std::string hash = client().upload_fake(
      {{"frames", 2}, {"tweak", (cache / "tweak.json").string()}, {"log", (cache / "log").string()}});
  ASSERT_EQ(
      client().http().Post("/api/captures/" + hash + "/tags", R"({"tags": ["court"]})", "application/json")->status,
      200);
  json document = config({{{"tag", "court"}}});
  document["techniques"] = "fxaa,msaa:samples=8,noaa,smaa";
  document["gates"]["time"] = false;
  server::BisectRequest request;
  request.night = night(document);
  const std::filesystem::path repository = folder() / "game";
  const auto shell = [&](const std::string& words) {
    const std::string command = "cd '" + repository.string() + "' && (" + words + ") 2>/dev/null";
    return std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe)
  };
  std::filesystem::create_directories(repository / "shaders");
  ASSERT_EQ(shell("git init -q && git config user.name t && git config user.email t@localhost"), 0);
  std::vector<std::string> commits;
  for (int i = 0; i < 3; ++i) {
    std::ofstream(repository / "tweak.json") << json{{"technique", "fxaa"}, {"slower", i == 2 ? 3.0 : 1.0}};
    std::ofstream(repository / "shaders" / "number") << i;
    ASSERT_EQ(shell("git add -A && git commit -qm 'change " + std::to_string(i) + "' && git rev-parse HEAD >.git/head"),
              0);
    std::ifstream(repository / ".git/head") >> commits.emplace_back();
  }
  request.capture = request.night.captures.front().name;
  request.technique = "fxaa";
  request.number = "time.msaa:samples=8";
  request.from = 1;
  request.to = 3;
  request.good = commits.front();
  request.bad = commits.back();
  request.repository = repository;
  request.data = data();
  // The command changes a file that is under version control, as builds do.
  request.command =
      "test {commit} = {commit} && cp tweak.json '" + cache.string() + "/' && echo >shaders/number && echo shaders";
  server::NightOptions options;
  options.worker = SUBPIXEL_FAKE_WORKER;
  const server::BisectResult result = bisect(request, work, options);
  EXPECT_EQ(result.first_bad, commits[2]);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_TRUE(result.steps[0].value) << result.steps[0].verdict;
  // NOLINTNEXTLINE(concurrency-mt-unsafe)
  EXPECT_EQ(std::getenv("SUBPIXEL_SHADERS"), std::filesystem::canonical(work / "clone" / "shaders").string());
  std::ifstream log(cache / "log");
  std::string line;
  while (std::getline(log, line))
    EXPECT_TRUE(line.ends_with("/0") || line.ends_with("/1") || line.ends_with("/2")) << line;

  // A program after a folder takes no shaders from elsewhere.
  request.command = "echo '" SUBPIXEL_FAKE_WORKER "' # {commit}";
  bisect(request, folder() / "program", options);
  EXPECT_EQ(std::getenv("SUBPIXEL_SHADERS"), nullptr);  // NOLINT(concurrency-mt-unsafe)
  request.number = "executions";
  request.technique = "smaa:strange";
  EXPECT_THROW(bisect(request, folder() / "other", options), InputError);
}

}  // namespace
}  // namespace subpixel::tests
