// Yesterday's capture of a tag against today's, in a night.
#include "server/nightly/against.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "server/nightly/summaries.hpp"
#include "tests/service/nights_fixture.hpp"

namespace subpixel::tests {
namespace {

class Against : public Nights {
 protected:
  void upload(const json& behaviour) {
    const std::string hash = client().upload_fake(behaviour);
    const httplib::Result set = client().http().Post("/api/captures/" + hash + "/tags",
                                                     json{{"tags", {"courtyard"}}}.dump(), "application/json");
    ASSERT_EQ(set->status, 200);
  }
  server::NightRecord days_night(const json& gates = json::object()) const {
    json document = config({{{"tag", "courtyard"}, {"against", "yesterday"}}});
    document["gates"]["against"] = gates;
    return night(document);
  }
  static std::string gate(const server::NightCell& cell, const std::string& name) {
    for (const server::GateResult& result : cell.gates)
      if (result.gate == "against " + name) return std::string(to_text(result.outcome));
    return "none";
  }
};

TEST_F(Against, DrawsAndNumbersAreComparedWithTheDayBefore) {
  start(options());
  upload({{"frames", 2}, {"draws", 4}});
  const server::NightRecord alone = days_night();
  EXPECT_EQ(alone.status, server::NightStatus::passed);
  EXPECT_EQ(gate(alone.cells.at(0), "draws"), "skipped");

  upload({{"frames", 2}, {"draws", 6}});
  const server::NightRecord both = days_night();
  ASSERT_EQ(both.captures.size(), 2u);
  EXPECT_EQ(both.captures[0].name, "courtyard");
  EXPECT_EQ(both.captures[1].name, "courtyard, yesterday");
  EXPECT_EQ(both.captures[1].hash, alone.captures[0].hash);
  const json& summary = both.facts.at("against").at("courtyard");
  EXPECT_EQ(summary.at("draws").at("added"), 2);
  EXPECT_EQ(summary.at("draws").at("before"), 4);
  EXPECT_EQ(summary.at("materials").at("changed"), 1);
  EXPECT_EQ(summary.at("list").size(), 3u);
  EXPECT_EQ(summary.at("techniques").size(), 3u);
  EXPECT_EQ(both.status, server::NightStatus::failed);
  EXPECT_EQ(gate(both.cells.at(0), "draws"), "failed") << "half more";
  EXPECT_EQ(gate(both.cells.at(0), "materials"), "failed");
  EXPECT_EQ(gate(both.cells.at(0), "memory"), "passed");
  EXPECT_EQ(gate(both.cells.at(0), "executions"), "passed");
  EXPECT_EQ(both.cells.at(1).status, server::CellStatus::passed);
  const server::NightRecord allowed = days_night({{"draws", 0.5}, {"materials", 0.25}});
  EXPECT_EQ(allowed.status, server::NightStatus::passed);

  const std::string comment = to_comment(both, "http://localhost:1");
  EXPECT_NE(comment.find("draws 4 to 6"), std::string::npos) << comment;
  EXPECT_NE(comment.find("| 0 | \\<b>new\\</b> tree | added |"), std::string::npos) << comment;
  EXPECT_NE(comment.find("http://localhost:1/#/nights/2"), std::string::npos) << comment;
  const json served = client().get("/api/nights/" + std::to_string(both.id));
  EXPECT_EQ(served.at("facts").at("against").at("courtyard").at("draws").at("added"), 2);
}

TEST_F(Against, AChangedImageHasItsDifference) {
  start(options());
  upload({{"frames", 1}, {"draws", 4}, {"width", 64}, {"tweak", tweak_file().string()}});
  upload({{"frames", 1}, {"draws", 4}, {"width", 64}, {"title", "another"}, {"how", "diff_kill"}});
  json document = config({{{"tag", "courtyard"}, {"against", "yesterday"}}});
  document["frames"] = {0, 0};
  std::filesystem::create_directories(tweak_file().parent_path());
  tweak({{"technique", "noaa"}, {"pixel", 40}});
  const server::NightRecord killed = night(document);
  EXPECT_NE(killed.facts.at("against").at("courtyard").at("problem").get<std::string>().find("signal"),
            std::string::npos)
      << killed.facts;
  EXPECT_EQ(gate(killed.cells.at(0), "draws"), "skipped");
  upload({{"frames", 1}, {"draws", 4}, {"width", 64}, {"title", "a third"}, {"tweak", tweak_file().string()}});
  const server::NightRecord changed = night(document);
  const json& frame = changed.facts.at("against").at("courtyard").at("techniques").at(0).at("frames").at(0);
  EXPECT_NE(frame.at("today"), frame.at("yesterday"));
  ASSERT_TRUE(frame.at("difference").is_string());
  EXPECT_EQ(client().http().Get("/api/blobs/" + frame.at("difference").get<std::string>())->status, 200);
}

TEST(AgainstSummary, AnotherFormIsRefused) {
  EXPECT_THROW(server::against_summary(json::object(), "a", "b"), InputError);
  EXPECT_THROW(server::against_summary({{"same", 1}, {"frames", json::array()}}, "a", "b"), Error);
  EXPECT_THROW(server::against_summary({{"same", true}, {"frames", 3}}, "a", "b"), InputError);
}

TEST(AgainstConfig, IsOfATag) {
  const auto parse = [](const json& capture) {
    return server::parse_nightly_config(json{{"name", "a"}, {"techniques", "noaa"}, {"captures", {capture}}}.dump(),
                                        "/tmp");
  };
  EXPECT_TRUE(parse({{"tag", "x"}, {"against", "yesterday"}}).captures[0].against_yesterday);
  EXPECT_THROW(parse({{"path", "x"}, {"against", "yesterday"}}), InputError);
  EXPECT_THROW(parse({{"tag", "x"}, {"against", "last week"}}), InputError);
}

}  // namespace
}  // namespace subpixel::tests
