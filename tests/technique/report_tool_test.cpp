// The report's tool from the command line: measures, stores, goes on, writes the page again without a replay.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "replay/results/results_file.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class ReportTool : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("subpixel-report-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  int run(const std::string& arguments) {
    const std::string own =
        arguments.find("--folder") == std::string::npos ? " --folder '" + folder_.string() + "'" : "";
    const std::string command = "'" SUBPIXEL_REPORT_BINARY "' --quick --size 48x28" + own + " --out '" +
                                page().string() + "' " + arguments + " >'" + folder_.string() + "/out' 2>'" +
                                folder_.string() + "/log'";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  fs::path page() const { return folder_ / "page" / "results.md"; }

  fs::path folder_;
};

TEST_F(ReportTool, MeasuresStoresGoesOnAndWritesAgain) {
  const std::string few = " --techniques noaa,msaa,forward,simple_complex,streaming";
  ASSERT_EQ(run("--scenes cube" + few), 0) << text_of(folder_ / "log");
  const std::string stored = text_of(folder_ / "cube_48x28.json");
  EXPECT_EQ(replay::read_results(folder_ / "cube_48x28.json").results.size(), 5u);

  // A second scene: the first one is not measured again.
  ASSERT_EQ(run("--scenes cube,spheres" + few), 0) << text_of(folder_ / "log");
  EXPECT_NE(text_of(folder_ / "log").find("1 of 2 runs are stored"), std::string::npos) << text_of(folder_ / "log");
  EXPECT_EQ(text_of(folder_ / "cube_48x28.json"), stored);

  const std::string written = text_of(page());
  for (const char* part :
       {"# Results", "| [cube 48x28](measured/cube_48x28.json) |", "| [spheres 48x28](", "96 bytes/pixel, 50.0%",
        "\nHeld.\n", "### Lowest error in at most", "`streaming S=3`", "(images/results/spheres_memory.svg)"})
    EXPECT_NE(written.find(part), std::string::npos) << part << "\n" << written;
  EXPECT_TRUE(fs::exists(page().parent_path() / "images/results/spheres_memory.svg"));

  fs::remove(page());
  ASSERT_EQ(run("--only-write --scenes cube,spheres" + few), 0) << text_of(folder_ / "log");
  EXPECT_EQ(text_of(page()), written);
  EXPECT_EQ(text_of(folder_ / "log"), "");

  // What lies beside the page makes it again, and nothing that the plan does not have stays there.
  const fs::path measured = page().parent_path() / "measured";
  EXPECT_EQ(text_of(measured / "cube_48x28.json"), stored);
  fs::remove(page());
  ASSERT_EQ(run("--only-write --scenes cube,spheres" + few + " --folder '" + measured.string() + "'"), 0);
  EXPECT_EQ(text_of(page()), written);
  EXPECT_EQ(text_of(measured / "cube_48x28.json"), stored);
  std::ofstream(measured / "sphere_48x28.json") << "{}";
  ASSERT_EQ(run("--only-write --scenes cube" + few), 0) << text_of(folder_ / "log");
  EXPECT_FALSE(fs::exists(measured / "sphere_48x28.json"));
  EXPECT_FALSE(fs::exists(measured / "spheres_48x28.json"));

  // All is there, so this call is a new measurement; the old one is kept aside.
  ASSERT_EQ(run("--scenes cube" + few), 0) << text_of(folder_ / "log");
  EXPECT_EQ(text_of(folder_ / "previous" / "cube_48x28.json"), stored);
}

TEST_F(ReportTool, NamesMistakes) {
  EXPECT_EQ(run("--scenes nowhere"), 2);
  EXPECT_NE(text_of(folder_ / "log").find("nowhere"), std::string::npos);
  EXPECT_EQ(run("--only-write"), 3);
  EXPECT_NE(text_of(folder_ / "log").find("nothing is stored"), std::string::npos);
}

}  // namespace
}  // namespace subpixel::tests
