// Nights over the store and HTTP, replayed by the fake worker.
#include "base/error.hpp"
#include "tests/service/nights_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::CellStatus;
using server::DataFolder;
using server::NightCell;
using server::NightRecord;
using server::NightStatus;
using server::NightStore;
using server::Store;

TEST_F(Nights, FirstIsNewThenEqualNightsPass) {
  a_capture();
  const NightRecord first = one_capture_night();
  EXPECT_EQ(first.status, NightStatus::passed);
  ASSERT_EQ(first.cells.size(), 3u);
  for (const NightCell& each : first.cells) EXPECT_EQ(each.status, CellStatus::new_);
  EXPECT_EQ(cell(first, "msaa:samples=8").frames.size(), 2u);
  EXPECT_FALSE(first.baseline_night);
  ASSERT_TRUE(approve(first.id));
  const NightRecord second = one_capture_night();
  EXPECT_EQ(second.status, NightStatus::passed);
  EXPECT_EQ(second.baseline_night, first.id);
  for (const NightCell& each : second.cells) EXPECT_EQ(each.status, CellStatus::passed) << each.technique;
  const server::Connection connection(data() / "subpixel.sqlite");
  server::Statement blobs(connection, "SELECT count(*) FROM blobs");
  blobs.step();
  server::Statement images(connection, "SELECT count(DISTINCT blob), count(*) FROM night_images");
  images.step();
  EXPECT_EQ(blobs.integer(), images.integer());
  EXPECT_EQ(images.integer(), 2 * 3 * 2 * 9) << "each image of both nights, but only one copy of it";
}

TEST_F(Nights, AChangedPixelFailsItsCellWithItsDifference) {
  a_capture();
  ASSERT_TRUE(approve(one_capture_night().id));
  tweak({{"technique", "noaa"}, {"pixel", 40}});
  const NightRecord changed = one_capture_night();
  EXPECT_EQ(changed.status, NightStatus::failed);
  EXPECT_EQ(failed_gates(cell(changed, "noaa")), std::vector<std::string>{"images"});
  EXPECT_EQ(cell(changed, "msaa:samples=4").status, CellStatus::passed);
  ASSERT_FALSE(cell(changed, "noaa").frames[0].difference.empty());
  EXPECT_NE(cell(changed, "noaa").gates.at(4).detail.find("1 pixels differ"), std::string::npos)
      << cell(changed, "noaa").gates.at(4).detail;

  start(options());
  const std::string path = "/api/nights/" + std::to_string(changed.id);
  const json document = client().get(path);
  EXPECT_EQ(document.at("counts").at("failed"), 1);
  const json opened = client().get(path + "/cells/" + std::to_string(cell(changed, "noaa").id));
  ASSERT_EQ(opened.at("frames").size(), 2u);
  const json& frame = opened.at("frames").at(0);
  EXPECT_NE(frame.at("tonight").at("images").at("image"), frame.at("baseline").at("images").at("image"));
  const std::string difference = frame.at("difference");
  const httplib::Result png = client().http().Get("/api/blobs/" + difference);
  EXPECT_EQ(png->get_header_value("Content-Type"), "image/png");
  client().get(path + "/cells/999999", 404);
  client().get("/api/nights/99", 404);
}

TEST_F(Nights, MemoryShadingAndMetricsAreExact) {
  a_capture();
  ASSERT_TRUE(approve(one_capture_night().id));
  tweak({{"technique", "msaa"}, {"executions", 1}});
  EXPECT_EQ(failed_gates(cell(one_capture_night(), "msaa:samples=8")), std::vector<std::string>{"shading"});
  tweak({{"technique", "msaa"}, {"mse", 0.9}});
  EXPECT_EQ(failed_gates(cell(one_capture_night(), "msaa:samples=8")), std::vector<std::string>{"metrics"});
}

TEST_F(Nights, ASlowerTechniqueIsMeasuredAgainBeforeItFails) {
  a_capture();
  ASSERT_TRUE(approve(one_capture_night().id));
  tweak({{"technique", "noaa"}, {"slower", 4.0}});
  const NightRecord slow = one_capture_night();
  EXPECT_EQ(failed_gates(cell(slow, "noaa")), std::vector<std::string>{"time"});
  EXPECT_EQ(std::ranges::count_if(progress_, [](const std::string& line) { return line.find("again") != line.npos; }),
            1);
  EXPECT_EQ(cell(slow, "noaa").time.rounds.size(), 48u);
  EXPECT_EQ(cell(slow, "msaa:samples=8").time.rounds.size(), 3u) << "what is as fast as it was is not measured again";
  EXPECT_EQ(slow.facts.at("noise"), 0.0);
}

TEST_F(Nights, ACrashFailsItsCaptureAndTheNightGoesOn) {
  a_capture();
  std::ofstream(folder() / "crash.spcap") << fake_capture({{"frames", 2}, {"fail_at", 4}, {"how", "segv"}});
  const NightRecord night_ =
      night(config({{{"path", "crash.spcap"}}, {{"path", "gone.spcap"}}, {{"path", "one.spcap"}}}));
  EXPECT_EQ(night_.status, NightStatus::failed);
  EXPECT_NE(night_.captures[0].problem.find("signal"), std::string::npos) << night_.captures[0].problem;
  EXPECT_FALSE(night_.captures[1].problem.empty());
  EXPECT_TRUE(night_.captures[2].problem.empty());
  EXPECT_EQ(night_.cells.at(0).status, CellStatus::failed);
  EXPECT_EQ(night_.cells.at(0).frames.size(), 2u) << "what was measured before the crash is kept";
  EXPECT_EQ(night_.cells.at(8).status, CellStatus::new_) << json(failed_gates(night_.cells.at(8)));
}

TEST_F(Nights, TaggedCapturesAreReplayed) {
  start(options());
  const std::string hash = client().upload_fake({{"frames", 2}});
  const httplib::Result set = client().http().Post("/api/captures/" + hash + "/tags",
                                                   json{{"tags", {"nightly", "big"}}}.dump(), "application/json");
  EXPECT_EQ(json::parse(set->body).at("tags"), json({"big", "nightly"}));
  EXPECT_EQ(client().get("/api/captures/" + hash).at("tags").size(), 2u);
  error_of(client().http().Post("/api/captures/" + hash + "/tags", json{{"tags", {""}}}.dump(), "application/json"),
           400);
  error_of(client().http().Post("/api/captures/" + hash + "/tags", json{{"tag", {"x"}}}.dump(), "application/json"),
           400);
  error_of(client().http().Post("/api/captures/" + std::string(32, 'a') + "/tags", json{{"tags", json::array()}}.dump(),
                                "application/json"),
           404);
  // A night runs beside the service.
  const NightRecord tagged = night(config({{{"tag", "nightly"}}, {{"tag", "none"}}}));
  EXPECT_EQ(tagged.captures.at(0).hash, hash);
  EXPECT_EQ(tagged.cells.at(0).frames.size(), 2u);
  EXPECT_NE(tagged.captures.at(1).problem.find("no stored capture has the tag none"), std::string::npos);
  EXPECT_EQ(client().get("/api/nights").at("nights").size(), 1u);
}

TEST_F(Nights, ListBaselinesAndSummariesOverHttp) {
  a_capture();
  const std::int64_t id = one_capture_night().id;
  start(options());
  const auto approve_over_http = [&](const json& body) {
    return client().http().Post("/api/baselines", body.dump(), "application/json");
  };
  EXPECT_EQ(client().get("/api/baselines").at("baselines").size(), 0u);
  EXPECT_EQ(approve_over_http({{"name", "test"}, {"night", id}})->status, 200);
  error_of(approve_over_http({{"name", "test"}, {"night", 77}}), 404);
  error_of(approve_over_http({{"name", ""}, {"night", id}}), 400);
  error_of(client().http().Post("/api/baselines", "{}", "text/plain"), 415);
  EXPECT_EQ(client().get("/api/baselines").at("baselines").at(0).at("night"), id);
  one_capture_night();
  const json list = client().get("/api/nights?limit=1");
  ASSERT_EQ(list.at("nights").size(), 1u);
  EXPECT_EQ(list.at("nights").at(0).at("baseline_night"), id);
  EXPECT_EQ(list.at("next_before"), id + 1);
  EXPECT_EQ(client().get("/api/nights?name=other").at("nights").size(), 0u);
  const std::string path = "/api/nights/" + std::to_string(id + 1);
  EXPECT_NE(client().http().Get(path + "/summary.md")->body.find("| technique | one |"), std::string::npos);
  EXPECT_TRUE(client().http().Get(path + "/summary.xml")->body.starts_with("<?xml"));
}

TEST_F(Nights, OldNightsGoButNotBaselines) {
  a_capture();
  json document = config({{{"path", "one.spcap"}}});
  document["keep"] = 2;
  const std::int64_t first = night(document).id;
  ASSERT_TRUE(approve(first));
  for (int i = 0; i < 3; ++i) night(document);
  Store store(data() / "subpixel.sqlite");
  std::vector<std::int64_t> ids;
  for (const NightRecord& each : NightStore(store).nights(10, 0, "")) ids.push_back(each.id);
  EXPECT_EQ(ids, (std::vector<std::int64_t>{first + 3, first + 2, first}));
}

TEST_F(Nights, ANightThatBrokeOffIsSaidSoAndIsNoBaseline) {
  {
    const DataFolder claimed(data(), DataFolder::Claim::night);
    Store store(claimed.store());
    NightRecord broken;
    broken.name = "test";
    broken.config = json::object();
    NightStore(store).add(broken);
    EXPECT_THROW(DataFolder(data(), DataFolder::Claim::night), InputError) << "one night at a time";
  }
  a_capture();
  one_capture_night();
  Store store(data() / "subpixel.sqlite");
  EXPECT_EQ(NightStore(store).night(1, false)->status, NightStatus::interrupted);
  EXPECT_FALSE(approve(1));
  EXPECT_THROW(DataFolder(folder() / "nowhere", DataFolder::Claim::reader), InputError);
}

TEST_F(Nights, RunsTakeSweepsAndGivePlotsAndAdvice) {
  start(options());
  const std::string hash = client().upload_fake({{"frames", 1}});
  const httplib::Result started =
      client().post_run({{"capture", hash},
                         {"width", 32},
                         {"height", 18},
                         {"techniques", {"noaa,msaa:samples=4|8", {{"technique", "fxaa"}}}}});
  ASSERT_EQ(started->status, 201) << started->body;
  const std::string path = "/api/runs/" + std::to_string(json::parse(started->body).at("id").get<int>());
  EXPECT_EQ(json::parse(started->body).at("request").at("techniques").size(), 4u);
  client().wait_for_end(json::parse(started->body).at("id"));
  const httplib::Result svg = client().http().Get(path + "/plot.svg?cost=ratio&error=mse");
  EXPECT_EQ(svg->get_header_value("Content-Type"), "image/svg+xml");
  EXPECT_NE(svg->body.find("msaa 4x"), std::string::npos);
  EXPECT_NE(client().http().Get(path + "/points.md")->body.find("| `msaa 8x` |"), std::string::npos);
  EXPECT_TRUE(client().http().Get(path + "/points.csv")->body.starts_with("setting,"));
  error_of(client().http().Get(path + "/plot.svg?cost=money"), 400);
  const json advice = client().get(path + "/advice?max_mse=3e-4");
  EXPECT_EQ(advice.at("within"), 2);
  EXPECT_EQ(advice.at("choices").at(0).at("best").at("samples"), 4);
  EXPECT_FALSE(advice.at("choices").at(0).at("reason").get<std::string>().empty());
  error_of(client().http().Get(path + "/advice"), 400);
  error_of(client().http().Get(path + "/advice?max_mse=-1"), 400);
  error_of(client().post_run({{"capture", hash}, {"techniques", {"msaa:samples=4..6"}}}), 400);
  error_of(client().post_run({{"capture", hash}, {"techniques", {"noaa,noaa"}}}), 400);
}

}  // namespace
}  // namespace subpixel::tests
