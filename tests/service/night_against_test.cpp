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

// As `subpixel diff --json` says it.
json a_difference(const json& changed, std::size_t gone) {
  json frame = {{"frame", 3},  {"draws_a", 50},         {"draws_b", 40},     {"equal", 30},
                {"added", {}}, {"gone", json::array()}, {"changed", changed}};
  frame["added"] = json::array();
  for (std::size_t i = 0; i < gone; ++i) frame["gone"].push_back({{"name", "gone " + std::to_string(i)}});
  return {{"same", false}, {"frames", {frame}}};
}

TEST(AgainstSummary, CountsWhatChanged) {
  const json changed = {{{"name", "wall"},
                         {"moved", {1, 0, 0}},
                         {"mesh", {"positions"}},
                         {"material", {{{"field", "roughness"}, {"a", 0}, {"b", 1}}}},
                         {"textures", {"albedo", "normal"}}},
                        {{"name", "door"},
                         {"moved", nullptr},
                         {"mesh", json::array()},
                         {"material", json::array()},
                         {"textures", json::array()}}};
  const json summary = server::against_summary(a_difference(changed, 45), "a", "b");
  EXPECT_EQ(
      summary.at("draws"),
      (json{{"before", 50}, {"after", 40}, {"equal", 30}, {"added", 0}, {"gone", 45}, {"changed", 2}, {"moved", 1}}));
  EXPECT_EQ(summary.at("meshes").at("changed"), 1);
  EXPECT_EQ(summary.at("materials").at("changed"), 1);
  EXPECT_EQ(summary.at("textures").at("changed"), 1) << "draws, not textures";
  EXPECT_EQ(summary.at("list").size(), 40u) << "a list for people";
  EXPECT_EQ(summary.at("unlisted"), 7);
  const json few = server::against_summary(a_difference(changed, 0), "a", "b").at("list");
  EXPECT_EQ(few.at(0).at("details"), "mesh: positions; material: roughness; textures: albedo, normal; moved");
  EXPECT_EQ(few.at(1).at("details"), "another name or order");
}

// Two days of one technique, whose numbers are `today` times yesterday's.
server::NightRecord two_days(double today) {
  server::NightRecord night;
  night.captures = {{"court", "", "", "", {}}, {"court, yesterday", "", "", "", {}}};
  for (std::uint32_t day = 0; day < 2; ++day) {
    server::NightCell cell;
    cell.capture = day;
    cell.technique = "noaa";
    cell.status = server::CellStatus::new_;
    const double factor = day == 0 ? today : 1;
    server::NightFrame frame;
    frame.result.memory.fitted_bytes_per_pixel = 10 * factor;
    frame.result.shading.executions = static_cast<std::uint64_t>(1000 * factor);
    frame.result.error.mse = 0.01 * factor;
    frame.result.counters["triangles"] = static_cast<std::uint64_t>(500 * factor);
    frame.result.images["image"] = day == 0 ? "now" : "then";
    if (day == 0) frame.difference = "between";
    cell.frames = {frame};
    night.cells.push_back(cell);
  }
  night.facts["against"]["court"] = server::against_summary(a_difference(json::array(), 0), "yesterday", "today");
  return night;
}

std::vector<std::string> failed_of(const server::NightCell& cell) {
  std::vector<std::string> failed;
  for (const server::GateResult& gate : cell.gates)
    if (gate.outcome == server::GateOutcome::failed) failed.push_back(gate.gate);
  return failed;
}

TEST(AgainstGates, EachNumberHasItsShare) {
  server::NightRecord night = two_days(1.05);
  judge_against(night, server::GateOptions{});
  EXPECT_TRUE(failed_of(night.cells[0]).empty());
  EXPECT_EQ(night.cells[0].status, server::CellStatus::passed) << "it was compared, so it is not new";
  EXPECT_EQ(night.cells[0].gates.size(), 6u);
  night = two_days(1.2);
  judge_against(night, server::GateOptions{});
  EXPECT_EQ(failed_of(night.cells[0]),
            (std::vector<std::string>{"against memory", "against executions", "against error", "against triangles"}));
  EXPECT_EQ(night.cells[0].status, server::CellStatus::failed);
  EXPECT_EQ(night.facts.at("against").at("court").at("triangles"), (json{{"before", 500}, {"after", 600}}));
  night = two_days(1);
  night.cells[0].frames[0].result.error.mse *= 1.2;
  judge_against(night, server::GateOptions{});
  EXPECT_EQ(failed_of(night.cells[0]), std::vector<std::string>{"against error"});
  // From nothing to something is more than any share.
  night = two_days(1.2);
  night.cells[1].frames[0].result.counters["triangles"] = 0;
  judge_against(night, server::GateOptions{});
  EXPECT_EQ(failed_of(night.cells[0]).back(), "against triangles");
}

TEST(AgainstComment, LinksPicturesAndSaysWhenNothingChanged) {
  server::NightRecord night = two_days(1.2);
  judge_against(night, server::GateOptions{});
  const std::string text = against_markdown(night, "http://x");
  EXPECT_NE(text.find("[difference](http://x/api/blobs/between)"), std::string::npos) << text;
  EXPECT_NE(text.find("[yesterday](http://x/api/blobs/then)"), std::string::npos) << text;
  EXPECT_EQ(against_markdown(night, "").find("/api/blobs/"), std::string::npos) << "no service has them";
  night.facts["against"]["court"]["list"] = {{{"frame", 0}, {"what", "gone"}, {"draw", "a|b"}, {"details", "*x*"}}};
  EXPECT_NE(against_markdown(night, "").find("| 0 | a\\|b | gone | \\*x\\* |"), std::string::npos);
  night.facts["against"]["court"]["same"] = true;
  EXPECT_NE(against_markdown(night, "").find("The same is drawn."), std::string::npos);
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
