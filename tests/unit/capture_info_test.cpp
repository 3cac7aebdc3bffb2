// What `subpixel info` and `subpixel validate` print of a capture's notices and features.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture_format/writer.hpp"
#include "tests/technique/run_binary.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

class CaptureInfo : public testing::Test {
 protected:
  CaptureInfo() : folder_(std::filesystem::path(testing::TempDir()) / ("capture_info_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~CaptureInfo() override { std::filesystem::remove_all(folder_); }

  tests::Finished run(const std::string& verb, const Capture& capture) const {
    write_capture(capture, folder_ / "c.spcap");
    return tests::run_binary(verb + " c.spcap", folder_);
  }

  std::filesystem::path folder_;
};

TEST_F(CaptureInfo, ListsNoticesAndFeatures) {
  const tests::Finished text = run("info", version_2_capture());
  EXPECT_EQ(text.code, 0) << text.error;
  EXPECT_NE(text.out.find("\nnotice  "), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("ignored: morph targets of 3 meshes"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("spot lights, vertex colours, second UV set, texture transforms, samplers, unlit"),
            std::string::npos)
      << text.out;
  const nlohmann::json json = nlohmann::json::parse(run("info --json", version_2_capture()).out);
  EXPECT_EQ(json["notices"], (nlohmann::json{"ignored: morph targets of 3 meshes", ""}));
  EXPECT_EQ(run("info", small_capture()).out.find("\nnotice"), std::string::npos);
  EXPECT_EQ(run("validate", version_2_capture()).code, 0);
}

TEST_F(CaptureInfo, NoticesCannotWriteToTheTerminal) {
  Capture capture = small_capture();
  // Escape, bell, line feed, delete, and the one-character control sequence introducer.
  capture.metadata.notices = {
      "ignored: \x1b[31mred\a\r\n\x7f\xc2\x9b"
      "2J"};
  const tests::Finished text = run("info", capture);
  EXPECT_EQ(text.code, 0) << text.error;
  EXPECT_NE(text.out.find("ignored: "), std::string::npos);
  EXPECT_TRUE(std::none_of(text.out.begin(), text.out.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == '\x7f';
  })) << text.out;
  EXPECT_EQ(text.out.find("\xc2\x9b"), std::string::npos);
  const std::string plain = run("info", small_capture()).out;
  EXPECT_EQ(std::count(text.out.begin(), text.out.end(), '\n'), 1 + std::count(plain.begin(), plain.end(), '\n'));
}

}  // namespace
}  // namespace subpixel::capture
