// Parameters as fields of a struct: what their table describes, and what it makes of checked values.
#include "replay/frame/parameter_fields.hpp"

#include <gtest/gtest.h>

#include "replay/frame/common_parameters.hpp"

namespace subpixel::replay {
namespace {

enum class Shape { round, square };

struct MadeUpParameters : CommonParameters {
  std::uint32_t surfaces = 3;
  double angle = 0.5, weight = 2;
  bool merge = true;
  Shape shape = Shape::square;

  MadeUpParameters() { samples = 16; }
};

Fields<MadeUpParameters> made_up() {
  return {field::integer("surfaces", &MadeUpParameters::surfaces, {1, 4}, "kept", "surfaces"),
          field::samples({4, 16}),
          field::angle("angle", &MadeUpParameters::angle, "between normals"),
          field::number("weight", &MadeUpParameters::weight, {0, 10}, "of a merge"),
          field::condition("merge", &MadeUpParameters::merge, "merges"),
          field::choice("shape", &MadeUpParameters::shape, "of a surface",
                        {{"round", Shape::round}, {"square", Shape::square}}),
          field::alpha()};
}

MadeUpParameters read(const ParameterValues& given) {
  return made_up().read(check_parameters("made_up", made_up().description(), given));
}

TEST(ParameterFields, DescribeWhatTheTableSays) {
  const Parameters described = made_up().description();
  ASSERT_EQ(described.size(), 7U);
  EXPECT_EQ(described[0].name, "surfaces");
  EXPECT_EQ(described[0].kind, ParameterKind::integer);
  EXPECT_EQ(described[0].unit, "surfaces");
  EXPECT_EQ(described[0].maximum, 4);
  EXPECT_EQ(described[1].allowed, (std::vector<double>{4, 16}));
  EXPECT_EQ(described[1].minimum, 4);
  EXPECT_EQ(described[2].unit, "radians");
  EXPECT_EQ(described[5].choices, (std::vector<std::string_view>{"round", "square"}));
}

TEST(ParameterFields, DefaultsAreTheStructs) {
  const Parameters described = made_up().description();
  EXPECT_EQ(described[0].default_value, 3);
  EXPECT_EQ(described[1].default_value, 16) << "of the struct, not of the one that declares the field";
  EXPECT_EQ(described[3].default_value.dump(), "2.0") << "numbers are floats";
  EXPECT_EQ(described[4].default_value, true);
  EXPECT_EQ(described[5].default_value, "square");
  EXPECT_EQ(described[6].default_value, "to_coverage");
  const MadeUpParameters values = read({});
  EXPECT_EQ(values.surfaces, 3U);
  EXPECT_EQ(values.samples, 16U);
  EXPECT_EQ(values.weight, 2);
  EXPECT_EQ(values.shape, Shape::square);
}

TEST(ParameterFields, EveryMemberIsRead) {
  const MadeUpParameters values = read({{"surfaces", "2"},
                                        {"samples", 4},
                                        {"angle", 1},
                                        {"weight", 0.25},
                                        {"merge", "off"},
                                        {"shape", "round"},
                                        {"alpha", "per_sample"}});
  EXPECT_EQ(values.surfaces, 2U);
  EXPECT_EQ(values.samples, 4U);
  EXPECT_EQ(values.angle, 1);
  EXPECT_EQ(values.weight, 0.25);
  EXPECT_FALSE(values.merge);
  EXPECT_EQ(values.shape, Shape::round);
  EXPECT_EQ(values.alpha, AlphaDecision::per_sample);
}

}  // namespace
}  // namespace subpixel::replay
