// Texts of others on a terminal: a title and file names with control characters, through every verb that shows them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "capture_format/reading/reader.hpp"
#include "capture_format/writer.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

// In a shell's words: the file name has a line end, an escape and a byte that is no UTF-8.
const std::string kName = "$(printf 'a\\nb\\033]0;c\\377.spcap')";
const std::string kShown = "a\\x0ab\\x1b]0;c\\xff.spcap";
const std::string kTitle =
    "\x1b[2J\xc2\x9b"
    "31mred\x7f \xe2\x80\xaetxt";
const std::string kTitleShown = "\\x1b[2J\\u{9b}31mred\\x7f \\u{202e}txt";

class TerminalText : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-terminal-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    ASSERT_EQ(run_binary("generate cube cube.spcap --frames 1 --size 16x12", folder_).code, 0);
    capture::Capture capture = capture::read_capture(folder_ / "cube.spcap");
    capture.metadata.title = kTitle;
    capture.metadata.application = kTitle;
    capture.metadata.notices = {kTitle};
    capture::write_capture(capture, folder_ / "odd.spcap");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Runs and expects no byte on either stream that is not printable ASCII or a line end.
  Finished run(const std::string& arguments, int code) {
    SCOPED_TRACE(arguments);
    Finished finished = run_binary(arguments, folder_);
    EXPECT_EQ(finished.code, code) << finished.error;
    for (const std::string* const text : {&finished.out, &finished.error})
      for (const char c : *text) EXPECT_TRUE(c == '\n' || (c >= 0x20 && c < 0x7f)) << *text;
    return finished;
  }

  std::filesystem::path folder_;
};

TEST_F(TerminalText, OfCaptures) {
  EXPECT_NE(run("info odd.spcap", 0).out.find(kTitleShown), std::string::npos);
  const Finished json = run("info odd.spcap --json", 0);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("title"), kTitle);
  run("validate odd.spcap", 0);
  const Finished replayed = run("replay odd.spcap --techniques noaa --repeat 1 --reference-samples 0 --out out", 0);
  EXPECT_NE(replayed.out.find(kTitleShown), std::string::npos);
  EXPECT_NE(replayed.error.find(kTitleShown), std::string::npos);
}

TEST_F(TerminalText, OfFileNames) {
  EXPECT_NE(run("generate cube \"" + kName + "\" --frames 1 --size 16x12", 0).out.find(kShown), std::string::npos);
  EXPECT_NE(run("validate \"" + kName + "\"", 0).out.find(kShown), std::string::npos);
  for (const char* const verb : {"info", "validate"})
    EXPECT_NE(run(std::string(verb) + " \"x" + kName + "\"", 3).error.find("x" + kShown), std::string::npos);
  EXPECT_NE(run("replay \"x" + kName + "\" --techniques noaa", 3).error.find("x" + kShown), std::string::npos);
  EXPECT_NE(run("import \"x" + kName + "\" out.spcap", 3).error.find("x" + kShown), std::string::npos);
  EXPECT_NE(run("compare \"x" + kName + "\" b.png", 3).error.find("x" + kShown), std::string::npos);
  EXPECT_NE(run("advise \"x" + kName + "\" --max-mse 1", 3).error.find("x" + kShown), std::string::npos);
  EXPECT_NE(run("nightly --config \"x" + kName + "\"", 3).error.find("x" + kShown), std::string::npos);
}

TEST_F(TerminalText, OfArguments) {
  EXPECT_NE(run("\"" + kName + "\"", 2).error.find(kShown), std::string::npos);
  EXPECT_NE(run("replay odd.spcap --techniques \"" + kName + "\"", 2).error.find("\\x1b]0;"), std::string::npos);
  EXPECT_NE(run("info odd.spcap \"" + kName + "\"", 2).error.find("\\x1b]0;"), std::string::npos);
  EXPECT_NE(run("generate \"" + kName + "\" out.spcap", 2).error.find(kShown), std::string::npos);
}

}  // namespace
}  // namespace subpixel::tests
