// One table of limits, walked through every door: what is just within it is taken at each, what is just outside is
// refused at each, with the same words.
#include "replay/results/limits.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "replay/replay.hpp"
#include "replay/techniques/registry.hpp"
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
  if (name == "memory_mib") options.memory_mib = number;
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

// Neither has an input that can be had: exit code 3 says that the options were taken.
const std::string kReplay = "replay /nonexistent.spcap";
const std::string kSubmit = "submit '" SUBPIXEL_SOURCE_DIR "/LICENSE' --server http://127.0.0.1:1";

// `value` of what the limit is named after as an option.
std::string option(std::string_view name, std::uint64_t value) {
  const std::string text = std::to_string(value);
  if (name == "width") return " --size " + text + "x8";
  if (name == "height") return " --size 8x" + text;
  if (name == "point_lights") return " --lights " + text;
  if (name == "memory_mib") return " --memory " + text + "M";
  if (name == "reference_samples") return " --reference-samples " + text;
  return " --" + std::string(name) + " " + text;
}

std::optional<std::string> binary(const std::string& arguments) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("limits_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const tests::Finished finished = tests::run_binary(arguments, folder);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(finished.code == 2 || finished.code == 3) << arguments << " ended with " << finished.code;
  return finished.code == 2 ? std::optional(finished.error) : std::nullopt;
}

std::optional<std::string> command_line(const std::string& verb, std::string_view name, std::uint64_t value) {
  const std::string options = name == "techniques" ? "" : option(name, value);
  return binary(verb + options + " --techniques '" + text_of_techniques(name, value) + "'");
}

// What lies just outside of a limit, next to its ends and between what is taken.
std::set<std::uint64_t> outside(const Limit& limit) {
  std::set<std::uint64_t> values{limit.high + 1};
  if (limit.low > 0) values.insert(limit.low - 1);
  if (limit.multiple_of > 1) values.insert({limit.high - 1, limit.multiple_of + 1, limit.high + limit.multiple_of});
  if (limit.power_of_two) values.insert({limit.high - 1, 2 * limit.high});
  return values;
}

class EveryLimit : public testing::TestWithParam<Limit> {
 protected:
  static void expect_refusal(const std::optional<std::string>& why, std::uint64_t value) {
    ASSERT_TRUE(why.has_value()) << value << " is taken";
    EXPECT_NE(why->find(GetParam().refusal(std::to_string(value))), std::string::npos) << *why;
  }
};

// What only runs of the service have.
bool is_of_the_queue(const Limit& limit) {
  return limit.name == "priority" || limit.name == "retries";
}

TEST_P(EveryLimit, HoldsAtEveryDoorWithTheSameWords) {
  const Limit& limit = GetParam();
  std::map<std::string, Door> doors{{"http", http}};
  if (!is_of_the_queue(limit)) doors.insert({{"engine", engine}, {"nightly", nightly}});
  for (const auto& [name, door] : doors) {
    SCOPED_TRACE(name);
    for (const std::uint64_t value : {limit.low, limit.high}) {
      EXPECT_EQ(door(limit.name, value).value_or(""), "") << value;
    }
    for (const std::uint64_t value : outside(limit)) {
      if ((limit.name == "width" || limit.name == "height") && value == 0 && name == "engine") continue;  // as recorded
      expect_refusal(door(limit.name, value), value);
    }
  }
}

// The verbs that have it as an option. A list of techniques is counted by who gets it.
TEST_P(EveryLimit, HoldsOnTheCommandLineWithTheSameWords) {
  const Limit& limit = GetParam();
  if (limit.name == "techniques") {
    return expect_refusal(command_line(kReplay, limit.name, limit.high + 1), limit.high + 1);
  }
  for (const std::string& verb : {kReplay, kSubmit}) {
    if (verb == kReplay && is_of_the_queue(limit)) continue;
    SCOPED_TRACE(verb);
    expect_refusal(command_line(verb, limit.name, limit.high + 1), limit.high + 1);
    if (limit.low > 0) expect_refusal(command_line(verb, limit.name, limit.low - 1), limit.low - 1);
  }
}

TEST(CommandLine, TakesTheEndsOfAllLimits) {
  for (const std::string& verb : {kReplay, kSubmit}) {
    std::string low, high;
    for (const Limit& limit : limits()) {
      if (limit.name == "results" || limit.name == "techniques" || limit.name == "height") continue;
      if (verb == kReplay && is_of_the_queue(limit)) continue;
      low += option(limit.name, limit.low);
      high += option(limit.name, limit.high);
    }
    EXPECT_EQ(binary(verb + low + " --techniques noaa").value_or(""), "");
    EXPECT_EQ(binary(verb + high + " --techniques '" + text_of_techniques("techniques", kTechniquesLimit.high) + "'")
                  .value_or(""),
              "");
    EXPECT_EQ(command_line(verb, "height", kHeightLimit.high).value_or(""), "");
  }
}

// But the last, of results, which needs the capture's frames: ResultsOfARun has it.
INSTANTIATE_TEST_SUITE_P(All, EveryLimit, testing::ValuesIn(limits().first(limits().size() - 1)),
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

TEST(LimitText, MemoryIsInPowersOfTwo) {
  EXPECT_EQ(parse_memory("512M", ""), 512u);
  EXPECT_EQ(parse_memory("2G", ""), 2048u);
  EXPECT_EQ(parse_memory("0M", ""), 0u);
  EXPECT_EQ(parse_memory("16384G", ""), kMemoryLimit.high);
  for (const char* text : {"", "M", "512", "512K", "512m", "512MB", "1.5G", "-1M", " 1M", "1 M", "16385G", "16777217M",
                           "18014398509481984G", "18446744073709551617M"}) {
    EXPECT_THROW(parse_memory(text, "--memory"), UsageError) << text;
  }
}

TEST(LimitText, OnlyDecimalDigitsAreNumbers) {
  EXPECT_EQ(kRepeatLimit.parse("007", ""), 7u) << "no octal";
  for (const char* text : {"", " 7", "7 ", "+7", "-7", "0x7", "7.0", "7e0", "18446744073709551623", "seven"}) {
    EXPECT_THROW(kRepeatLimit.parse(text, "--repeat"), UsageError) << text;
  }
}

TEST(Size, IsWidthAndHeightWithinTheirLimits) {
  EXPECT_EQ(parse_size("1280x720", "--size"), (std::pair<std::uint32_t, std::uint32_t>(1280, 720)));
  for (const char* text : {"", "64", "x", "64x", "x64", "64x64x64", "0x64", "64x16385", "64 x64", "64X64"}) {
    EXPECT_THROW(parse_size(text, "--size"), UsageError) << text;
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
