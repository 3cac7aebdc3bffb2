#include "replay/results/parameters.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

const Parameters declared = {
    {.name = "samples",
     .kind = ParameterKind::integer,
     .doc = "",
     .unit = "samples",
     .minimum = 1,
     .maximum = 64,
     .allowed = {4, 8, 16},
     .choices = {},
     .default_value = 8},
    {.name = "surfaces",
     .kind = ParameterKind::integer,
     .doc = "",
     .unit = "",
     .minimum = 1,
     .maximum = 4,
     .allowed = {},
     .choices = {},
     .default_value = 3},
    {.name = "normal_angle",
     .kind = ParameterKind::number,
     .doc = "",
     .unit = "radians",
     .minimum = 0,
     .maximum = 3.15,
     .allowed = {},
     .choices = {},
     .default_value = 0.785},
    {.name = "merge_weight",
     .kind = ParameterKind::choice,
     .doc = "",
     .unit = "",
     .minimum = 0,
     .maximum = 0,
     .allowed = {},
     .choices = {"equal", "coverage"},
     .default_value = "equal"},
    {.name = "depth_test",
     .kind = ParameterKind::boolean,
     .doc = "",
     .unit = "",
     .minimum = 0,
     .maximum = 0,
     .allowed = {},
     .choices = {},
     .default_value = true},
};

std::string refusal(const ParameterValues& given) {
  try {
    check_parameters("streaming", declared, given);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

std::string list_refusal(std::string_view text) {
  try {
    parse_technique_list(text);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Parameters, DefaultsFillWhatIsNotGiven) {
  const ParameterValues values = check_parameters("streaming", declared, {});
  EXPECT_EQ(values.size(), declared.size());
  EXPECT_EQ(values.at("samples"), 8);
  EXPECT_EQ(values.at("merge_weight"), "equal");
  EXPECT_EQ(values.at("depth_test"), true);
}

TEST(Parameters, ScalarsAndTextAreTakenAlike) {
  const ParameterValues from_json = check_parameters(
      "streaming", declared,
      {{"samples", 16}, {"normal_angle", 1}, {"merge_weight", "coverage"}, {"depth_test", false}, {"surfaces", 2.0}});
  const ParameterValues from_text = check_parameters("streaming", declared,
                                                     {{"samples", "16"},
                                                      {"normal_angle", "1"},
                                                      {"merge_weight", "coverage"},
                                                      {"depth_test", "false"},
                                                      {"surfaces", "2"}});
  EXPECT_EQ(from_json, from_text);
  EXPECT_TRUE(from_json.at("surfaces").is_number_integer());
  EXPECT_TRUE(from_json.at("normal_angle").is_number_float());
}

TEST(Parameters, RefusalsNameWhatIsValid) {
  EXPECT_EQ(refusal({{"surface", 2}}),
            "technique streaming: unknown parameter surface (valid: samples, surfaces, normal_angle, merge_weight, "
            "depth_test): parameter surface");
  EXPECT_EQ(refusal({{"surfaces", 5}}), "technique streaming: surfaces = 5 is not in 1 to 4: parameter surfaces");
  EXPECT_EQ(refusal({{"surfaces", 1.5}}),
            "technique streaming: surfaces = 1.5 is not a whole number: parameter surfaces");
  EXPECT_EQ(refusal({{"surfaces", "many"}}),
            "technique streaming: surfaces = many is not a whole number: parameter surfaces");
  EXPECT_EQ(refusal({{"surfaces", nullptr}}),
            "technique streaming: surfaces = null is not a whole number: parameter surfaces");
  EXPECT_EQ(refusal({{"samples", 12}}), "technique streaming: samples = 12 is not one of 4, 8, 16: parameter samples");
  EXPECT_EQ(refusal({{"merge_weight", "none"}}),
            "technique streaming: merge_weight = none is not one of equal, coverage: parameter merge_weight");
  EXPECT_EQ(refusal({{"depth_test", 3}}),
            "technique streaming: depth_test = 3 is not true or false: parameter depth_test");
  EXPECT_EQ(refusal({{"normal_angle", "nan"}}),
            "technique streaming: normal_angle = nan is not a number: parameter normal_angle");
}

TEST(TechniqueList, NamesParametersAndTypes) {
  const auto requests =
      parse_technique_list("noaa,msaa:samples=8,streaming:surfaces=3:angle=0.5:merge=off:weight=false");
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_EQ(requests[0].technique, "noaa");
  EXPECT_TRUE(requests[0].parameters.empty());
  EXPECT_EQ(requests[1].parameters.at("samples"), 8);
  EXPECT_EQ(requests[2].parameters.at("angle"), 0.5);
  EXPECT_EQ(requests[2].parameters.at("merge"), "off");
  EXPECT_EQ(requests[2].parameters.at("weight"), false);
}

TEST(TechniqueList, SweepsAreProducts) {
  const auto requests = parse_technique_list("streaming:surfaces=1..3:samples=4|8,noaa");
  ASSERT_EQ(requests.size(), 7U);
  EXPECT_EQ(requests[0].parameters.at("surfaces"), 1);
  EXPECT_EQ(requests[0].parameters.at("samples"), 4);
  EXPECT_EQ(requests[1].parameters.at("samples"), 8);
  EXPECT_EQ(requests[5].parameters.at("surfaces"), 3);
  EXPECT_EQ(requests[6].technique, "noaa");
}

TEST(TechniqueList, RefusalsNameThePosition) {
  EXPECT_EQ(list_refusal(""), "technique list: a technique name is missing: character 1");
  EXPECT_EQ(list_refusal("noaa,"), "technique list: a technique name is missing: character 6");
  EXPECT_EQ(list_refusal("noaa,,msaa"), "technique list: a technique name is missing: character 6");
  EXPECT_EQ(list_refusal("samples=8"),
            "technique list: a technique name comes first, then :parameter=value: character 8");
  EXPECT_EQ(list_refusal("msaa:"), "technique list: expected parameter=value after ':': character 6");
  EXPECT_EQ(list_refusal("msaa:samples"), "technique list: expected parameter=value after ':': character 6");
  EXPECT_EQ(list_refusal("msaa:samples="),
            "technique list: parameter samples needs a value, first..last or a|b|c: character 14");
  EXPECT_EQ(list_refusal("msaa:samples=8..4"),
            "technique list: parameter samples needs a value, first..last or a|b|c: character 14");
  EXPECT_EQ(list_refusal("msaa:samples=4|"),
            "technique list: parameter samples needs a value, first..last or a|b|c: character 14");
  EXPECT_EQ(list_refusal("msaa:a=1:a=2"), "technique list: parameter a is given twice: character 10");
  EXPECT_EQ(list_refusal("a:b=1..1000:c=1..1000"), "technique list: the sweep has more than 1024 points: character 15");
}

}  // namespace
}  // namespace subpixel::replay
