// The configuration of a night: what it may say, and that every mistake is named by its place.
#include "server/nightly/config.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "replay/techniques/registry.hpp"
#include "server/nightly/night.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

json minimal() {
  return {{"name", "test"}, {"techniques", "noaa,msaa:samples=4|8"}, {"captures", {{{"scene", "cube"}}}}};
}

NightlyConfig parse(const json& document) {
  return parse_nightly_config(document.dump(), "/configs");
}

// The message of the refusal; empty when there was none.
std::string refusal(const std::string& text) {
  try {
    parse_nightly_config(text, "/configs");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string refusal_with(const json& patch) {
  json document = minimal();
  document.merge_patch(patch);
  return refusal(document.dump());
}

TEST(NightlyConfig, SweepsBecomeTechniquesWithAllParameters) {
  const NightlyConfig config = parse(minimal());
  ASSERT_EQ(config.captures.size(), 1U);
  const CaptureSource& cube = config.captures[0];
  ASSERT_EQ(cube.options.techniques.size(), 3U);
  EXPECT_EQ(technique_key(cube.options.techniques[1].technique, cube.options.techniques[1].parameters),
            "msaa:samples=4");
  EXPECT_EQ(cube.options.techniques[2].parameters.at("shading"), "ggx") << "defaults are filled in";
  EXPECT_EQ(config.baseline, "test") << "without one of its own it is named like the configuration";
  EXPECT_EQ(cube.generate.frames, 1U);
}

TEST(NightlyConfig, CapturesInheritAndOverride) {
  json document = minimal();
  document["size"] = {320, 180};
  document["repeat"] = 5;
  document["captures"] = {
      {{"path", "park.spcap"}, {"frames", {2, 4}}},
      {{"scene", "grass"}, {"name", "meadow"}, {"seed", 7}, {"size", {64, 32}}, {"techniques", {"noaa", "fxaa"}}},
      {{"tag", "nightly"}, {"also", "msaa:shading=blinn_phong"}}};
  const NightlyConfig config = parse(document);
  ASSERT_EQ(config.captures.size(), 3U);
  EXPECT_EQ(config.captures[0].path, "/configs/park.spcap");
  EXPECT_EQ(config.captures[0].name, "park");
  EXPECT_EQ(config.captures[0].options.frames.value().second, 4U);
  EXPECT_EQ(config.captures[0].options.width, 320U);
  EXPECT_EQ(config.captures[1].generate.seed, 7U);
  EXPECT_EQ(config.captures[1].generate.width, 64U);
  EXPECT_EQ(config.captures[1].options.techniques.size(), 2U);
  EXPECT_EQ(config.captures[1].options.repeat, 5U);
  EXPECT_EQ(config.captures[2].options.techniques.size(), 4U);
  EXPECT_FALSE(config.captures[2].options.frames.has_value()) << "all frames";
}

TEST(NightlyConfig, AllIsTheWholeRegistry) {
  json document = minimal();
  document["techniques"] = {"all", "msaa:samples=4"};
  EXPECT_EQ(parse(document).captures[0].options.techniques.size(), replay::techniques().size() + 1);
  document["techniques"] = {"all", "noaa"};
  EXPECT_THROW(parse(document), InputError) << "noaa twice";
}

TEST(NightlyConfig, AStarNamesAllScenesThatBeginSo) {
  json document = minimal();
  document["captures"] = {{{"scene", "streaming_*"}, {"size", {64, 48}}}, {{"scene", "cube"}}};
  const NightlyConfig config = parse(document);
  ASSERT_EQ(config.captures.size(), 5U);
  EXPECT_EQ(config.captures[0].name, "streaming_normals");
  EXPECT_EQ(config.captures[3].scene, "streaming_angle");
  EXPECT_EQ(config.captures[3].generate.width, 64U);
  document["captures"] = {{{"scene", "streaming_*"}, {"name", "one"}}};
  EXPECT_THROW(parse(document), InputError);
  document["captures"] = {{{"scene", "nothing_*"}}};
  EXPECT_THROW(parse(document), InputError);
}

TEST(NightlyConfig, GatesAreRead) {
  json document = minimal();
  document["gates"] = {{"images", false},
                       {"error", {{"mse", {{"limit", 0.1}, {"relative", 0.02}}}}},
                       {"time", {{"slower", 0.25}, {"rounds", 20}, {"alarm", 0.05}}},
                       {"across", {{"relative", 0.05}}}};
  const GateOptions gates = parse(document).gates;
  EXPECT_TRUE(gates.memory);
  EXPECT_FALSE(gates.images);
  EXPECT_EQ(gates.error.at("mse").limit, 0.1);
  EXPECT_EQ(gates.error.at("mse").absolute, 0);
  EXPECT_EQ(gates.time_slower, 0.25);
  EXPECT_EQ(gates.time_rounds, 20u);
  EXPECT_EQ(gates.time_alarm, 0.05);
  for (const json& wrong : {json{{"alarm", 0}}, json{{"alarm", 0.6}}, json{{"rounds", 2}}, json{{"confirm", 1}}}) {
    document["gates"] = {{"time", wrong}};
    EXPECT_THROW(parse(document), InputError) << wrong;
  }
  EXPECT_EQ(gates.across_relative, 0.05);
  document["gates"] = {{"time", false}};
  EXPECT_FALSE(parse(document).gates.time);
}

TEST(NightlyConfig, MistakesAreNamedByTheirPlace) {
  EXPECT_NE(refusal("{\n  \"name\": oops\n}").find("line 2, column 11"), std::string::npos);
  const auto names = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
  };
  names(refusal("{}"), "missing field: name");
  names(refusal_with({{"techniqes", "noaa"}}), "unknown field techniqes");
  names(refusal_with({{"techniques", "msaa:samples=5"}}), "samples = 5 is not one of 4, 8");
  names(refusal_with({{"techniques", {"noaa", "msaaa"}}}), "techniques[1]");
  names(refusal_with({{"techniques", "noaa,noaa"}}), "asked for twice");
  names(refusal_with({{"techniques", nullptr}}), "captures[0].techniques");
  names(refusal_with({{"captures", json::array()}}), "expected at least one capture: captures");
  names(refusal_with({{"captures", {{{"scene", "cube"}, {"path", "x"}}}}}), "captures[0]");
  names(refusal_with({{"captures", {{{"scene", "cubes"}}}}}), "captures[0].scene");
  names(refusal_with({{"captures", {{{"path", "x"}, {"seed", 1}}}}}), "captures[0].seed");
  names(refusal_with({{"captures", {{{"scene", "cube"}}, {{"scene", "cube"}}}}}), "captures[1]");
  names(refusal_with({{"size", {0, 5}}}), "size.width");
  names(refusal_with({{"frames", {3, 1}}}), "[first, last]: frames");
  names(refusal_with({{"repeat", -1}}), "from 1 to 1000: repeat");
  names(refusal_with({{"gates", {{"error", {{"speed", json::object()}}}}}}), "unknown metric speed");
  names(refusal_with({{"gates", {{"error", {{"mse", {{"limit", -1}}}}}}}}), "gates.error.mse.limit");
  names(refusal_with({{"gates", {{"memory", 1}}}}), "gates.memory");
}

TEST(NightlyConfig, ShippedOnesAreValid) {
  const std::filesystem::path root = SUBPIXEL_SOURCE_DIR;
  for (const char* file : {"nightly/quick.json", "nightly/full.json", "tests/nightly/mutations.json"}) {
    EXPECT_NO_THROW(read_nightly_config(root / file)) << file;
  }
  EXPECT_THROW(read_nightly_config(root / "nightly"), InputError);
}

TEST(TechniqueKey, NamesWhatIsNotTheDefault) {
  EXPECT_EQ(technique_key("noaa", {{"samples", 1}}), "noaa");
  EXPECT_EQ(technique_key("msaa", {{"samples", 8}, {"shading", "ggx"}}), "msaa:samples=8");
  EXPECT_EQ(technique_key("msaa", {{"samples", 8}, {"shading", "blinn_phong"}}), "msaa:samples=8:shading=blinn_phong");
  EXPECT_THROW(technique_key("none", {}), UsageError);
}

}  // namespace
}  // namespace subpixel::server
