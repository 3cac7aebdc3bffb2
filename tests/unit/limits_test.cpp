// One table of limits, walked through every door: what is just within it is taken at each, what is just outside is
// refused at each, with the same words.
#include "replay/limits.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "capture_format/error.hpp"
#include "replay/replay.hpp"
#include "replay/techniques/technique.hpp"
#include "server/nightly/config.hpp"
#include "server/run_request.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

// As many different settings as asked for, as text of the command line.
std::vector<std::string> settings(std::size_t count) {
  for (const Technique* technique : techniques()) {
    for (const Parameter& parameter : technique->parameters) {
      if (parameter.kind != ParameterKind::number || !parameter.allowed.empty()) continue;
      std::vector<std::string> texts;
      for (std::size_t i = 0; i < count; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(count);
        const double value = parameter.minimum + share * (parameter.maximum - parameter.minimum);
        texts.push_back(std::string(technique->name) + ":" + std::string(parameter.name) + "=" + json(value).dump());
      }
      return texts;
    }
  }
  ADD_FAILURE() << "no technique has a parameter that is a number";
  return {};
}

// A request for `value` of what the limit is named after, nothing else out of the ordinary.
ReplayOptions options_with(std::string_view name, std::uint64_t value) {
  ReplayOptions options;
  const auto number = static_cast<std::uint32_t>(value);
  if (name == "samples") options.samples = number;
  if (name == "width" || name == "height") options.width = options.height = 8;
  if (name == "width") options.width = number;
  if (name == "height") options.height = number;
  if (name == "repeat") options.repeat = number;
  if (name == "reference_samples") options.reference_samples = number;
  if (name == "point_lights") options.point_lights = number;
  options.techniques.assign(name == "techniques" ? value : 1, {"noaa", {}});
  return options;
}

// Why a door refuses; nothing when it takes the request.
using Door = std::function<std::optional<std::string>(std::string_view name, std::uint64_t value)>;

std::optional<std::string> engine(std::string_view name, std::uint64_t value) {
  ReplayJob job;
  job.capture = "/nonexistent.spcap";  // looked at after the limits, before a device
  job.options = options_with(name, value);
  try {
    run_replay(job, {});
  } catch (const UsageError& error) {
    return error.what();
  } catch (const InputError&) {
  }
  return std::nullopt;
}

std::string text_of_techniques(std::string_view name, std::uint64_t value) {
  std::string text;
  for (const std::string& one : settings(name == "techniques" ? value : 1)) text += (text.empty() ? "" : ",") + one;
  return text;
}

std::optional<std::string> http(std::string_view name, std::uint64_t value) {
  json body = {{"capture", "x"}, {"techniques", json::array({text_of_techniques(name, value)})}};
  if (name == "techniques" && value == 0) body["techniques"] = json::array();
  if (name == "width" || name == "height") body["width"] = body["height"] = 8;
  if (name != "techniques") body[std::string(name)] = value;
  try {
    server::parse_run_request(body.dump());
  } catch (const Error& error) {
    return error.what();
  }
  return std::nullopt;
}

std::optional<std::string> nightly(std::string_view name, std::uint64_t value) {
  json document = {{"name", "n"},
                   {"captures", json::array({{{"path", "x.spcap"}}})},
                   {"techniques", json::array({text_of_techniques(name, value)})}};
  if (name == "techniques" && value == 0) document["techniques"] = json::array();
  if (name == "width") document["size"] = {value, 8};
  if (name == "height") document["size"] = {8, value};
  if (name != "techniques" && name != "width" && name != "height") document[std::string(name)] = value;
  try {
    server::parse_nightly_config(document.dump(), "/");
  } catch (const Error& error) {
    return error.what();
  }
  return std::nullopt;
}

// Runs a verb of the binary whose input can't be had: exit code 3 says that the options were taken.
std::optional<std::string> binary(const std::string& verb, std::string_view name, std::uint64_t value) {
  static const std::map<std::string_view, std::string> kOptions{{"samples", "--samples "},
                                                                {"width", "--size 8x"},
                                                                {"height", "--size 8x"},
                                                                {"repeat", "--repeat "},
                                                                {"reference_samples", "--reference-samples "},
                                                                {"point_lights", "--lights "}};
  std::string arguments = verb + " --techniques '" + text_of_techniques(name, value) + "'";
  if (name == "width") {
    arguments += " --size " + std::to_string(value) + "x8";
  } else if (name != "techniques") {
    arguments += " " + kOptions.at(name) + std::to_string(value);
  }
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("limits_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const tests::Finished finished = tests::run_binary(arguments, folder);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(finished.code == 2 || finished.code == 3) << arguments << " ended with " << finished.code;
  return finished.code == 2 ? std::optional(finished.error) : std::nullopt;
}

std::optional<std::string> command_line(std::string_view name, std::uint64_t value) {
  return binary("replay /nonexistent.spcap", name, value);
}

// The file is there, the service is not.
std::optional<std::string> submit(std::string_view name, std::uint64_t value) {
  return binary("submit '" SUBPIXEL_SOURCE_DIR "/LICENSE' --server http://127.0.0.1:1", name, value);
}

class EveryLimit : public testing::TestWithParam<Limit> {};

TEST_P(EveryLimit, HoldsAtEveryDoorWithTheSameWords) {
  const Limit& limit = GetParam();
  if (limit.name == "results") GTEST_SKIP() << "needs the capture's frames: ResultsOfARun has it";
  std::map<std::string, Door> doors{{"engine", engine}, {"http", http}, {"nightly", nightly}};
  doors["command line"] = command_line;
  doors["submit"] = submit;
  std::set<std::uint64_t> outside{limit.high + 1};
  if (limit.low > 0) outside.insert(limit.low - 1);
  if (limit.multiple_of > 1) outside.insert({limit.high - 1, limit.multiple_of + 1, limit.high + limit.multiple_of});
  if (limit.power_of_two) outside.insert({limit.high - 1, 2 * limit.high});
  for (const auto& [name, door] : doors) {
    SCOPED_TRACE(name + ", " + std::string(limit.name));
    for (const std::uint64_t value : {limit.low, limit.high}) {
      EXPECT_EQ(door(limit.name, value).value_or(""), "") << value;
    }
    for (const std::uint64_t value : outside) {
      if ((limit.name == "width" || limit.name == "height") && value == 0 && name == "engine") continue;  // as recorded
      if (limit.name == "techniques" && (name == "submit" || (value == 0 && name == "command line"))) continue;
      const std::optional<std::string> why = door(limit.name, value);
      ASSERT_TRUE(why.has_value()) << value << " is taken";
      EXPECT_NE(why->find(limit.refusal(std::to_string(value))), std::string::npos) << *why;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryLimit, testing::ValuesIn(limits().begin(), limits().end()),
                         [](const auto& limit) { return std::string(limit.param.name); });

TEST(ResultsOfARun, AreCountedWithTheCapturesFrames) {
  ReplayOptions options = options_with("techniques", 100);
  EXPECT_EQ(server::resolve_frames(options, 1000), kResultsLimit.high);
  options.frames.reset();
  try {
    server::resolve_frames(options, 1001);
    FAIL() << "100,100 results were taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(kResultsLimit.refusal("100100")), std::string::npos) << error.what();
  }
}

TEST(LimitText, SaysWhatIsTaken) {
  EXPECT_EQ(kRepeatLimit.refusal("0"), "0 is not a whole number from 1 to 1000");
  EXPECT_EQ(kReferenceSamplesLimit.refusal("6"), "6 is not 0 or a multiple of 4 from 4 to 4096");
  EXPECT_EQ(kSamplesLimit.refusal("7"), "7 is not one of 1, 2, 4, 8, 16, 32, 64");
  EXPECT_LT(kRepeatLimit.refusal(std::string(5000, '9')).size(), 100u);
}

TEST(LimitText, OnlyDecimalDigitsAreNumbers) {
  EXPECT_EQ(kRepeatLimit.parse("007", ""), 7u) << "no octal";
  for (const char* text : {"", " 7", "7 ", "+7", "-7", "0x7", "7.0", "7e0", "18446744073709551623", "seven"}) {
    EXPECT_THROW(kRepeatLimit.parse(text, "--repeat"), UsageError) << text;
  }
}

TEST(LimitTable, IsWhatTheApiSends) {
  const json table = limits_json();
  ASSERT_EQ(table.size(), limits().size());
  std::set<std::string> names;
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_TRUE(names.insert(table[i].at("name").get<std::string>()).second) << table[i];
    EXPECT_EQ(table[i].at("low"), limits()[i].low);
    EXPECT_EQ(table[i].at("high"), limits()[i].high);
    EXPECT_FALSE(table[i].at("meaning").get<std::string>().empty());
  }
  EXPECT_EQ(table[0].at("values"), json({1, 2, 4, 8, 16, 32, 64}));
}

}  // namespace
}  // namespace subpixel::replay
