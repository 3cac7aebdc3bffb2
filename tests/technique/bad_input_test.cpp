// Bad input ends with one clear line and the contract's exit code, and leaves nothing half-written.
#include <gtest/gtest.h>
#include <unistd.h>

#include "capture_format/reading/reader.hpp"
#include "capture_format/writer.hpp"
#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

class BadInput : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("subpixel-bad-input-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    ASSERT_EQ(run_binary("generate cube cube.spcap --frames 2 --size 64x48", folder_).code, 0);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Runs, expects `code`, and one error line that starts as agreed and names every one of `named`.
  void expect_error(const std::string& arguments, int code, const std::vector<std::string>& named,
                    const std::string& environment = "", const std::string& limits = "") {
    SCOPED_TRACE(arguments);
    const Finished finished = run_binary(arguments, folder_, environment, limits);
    EXPECT_EQ(finished.code, code) << finished.error;
    std::vector<std::string> lines;
    std::istringstream stream(finished.error);
    for (std::string line; std::getline(stream, line);)
      if (line.starts_with("subpixel: ")) lines.push_back(line);
    ASSERT_EQ(lines.size(), 1u) << finished.error;
    for (const std::string& word : named)
      EXPECT_NE(lines[0].find(word), std::string::npos) << lines[0] << " lacks " << word;
  }

  void write(const std::string& name, const std::string& content) { std::ofstream(folder_ / name) << content; }

  std::filesystem::path folder_;
};

const std::string kReplay = "replay cube.spcap --reference-samples 4 --repeat 1 --out out ";

TEST_F(BadInput, UnknownTechniqueNamesTheValidOnes) {
  expect_error(kReplay + "--techniques mlaa", 2, {"mlaa", "noaa", "msaa"});
}

TEST_F(BadInput, UnknownParameterNamesTheValidOnes) {
  expect_error(kReplay + "--techniques msaa:", 2, {"parameter=value"});
  expect_error(kReplay + "--techniques noaa --repeats 3", 2, {"--repeats"});
  expect_error(kReplay + "--techniques msaa:sample=8", 2, {"msaa", "sample", "samples", "alpha", "resolve"});
}

TEST_F(BadInput, ValueOutOfRangeNamesTheRange) {
  expect_error(kReplay + "--techniques msaa:samples=7", 2, {"samples", "7", "4", "64"});
  expect_error(kReplay + "--techniques msaa:alpha=maybe", 2, {"alpha", "maybe", "to_coverage", "per_sample"});
  expect_error(kReplay + "--techniques noaa --frames 0-9", 2, {"0-9", "0-1"});
  expect_error(kReplay + "--techniques noaa --frames 1-0", 2, {"1-0"});
  expect_error(kReplay + "--techniques noaa --size 64", 2, {"64", "WIDTHxHEIGHT"});
  expect_error("replay cube.spcap --techniques noaa --repeat 0 --out out", 2, {"--repeat", "0", "1 to 1000"});
  expect_error("replay cube.spcap --techniques noaa --repeat -3 --out out", 2, {"--repeat", "-3", "1 to 1000"});
  expect_error(kReplay + "--techniques msaa --samples 5", 2, {"--samples", "5", "1, 2, 4, 8, 16, 32, 64"});
  expect_error("replay cube.spcap --techniques noaa --reference-samples 5 --repeat 1 --out out", 2,
               {"--reference-samples", "5", "4 to 4096"});
  expect_error("replay cube.spcap --techniques noaa --lights 9999 --repeat 1 --out out", 2, {"9999"});
}

TEST_F(BadInput, SizeTheDeviceCannotDo) {
  expect_error(kReplay + "--techniques noaa --size 100000x64", 2, {"100000x64", "1 to 16384"});
  expect_error(kReplay + "--techniques noaa --size 64x0", 2, {"64x0"});
  expect_error(kReplay + "--techniques noaa --size 0x0", 2, {"0x0"});
}

TEST_F(BadInput, NotACapture) {
  write("note.spcap", "this is no capture, but long enough to hold a header and more of that");
  expect_error("replay note.spcap --techniques noaa --out out", 3, {"note.spcap"});
  expect_error("info note.spcap", 3, {"note.spcap"});
  expect_error("replay . --techniques noaa --out out", 3, {});
  expect_error("replay missing.spcap --techniques noaa --out out", 3, {"missing.spcap"});
}

TEST_F(BadInput, TruncatedCapture) {
  const auto size = std::filesystem::file_size(folder_ / "cube.spcap");
  for (const auto left : {size - 1, size / 2, std::uintmax_t{20}, std::uintmax_t{0}}) {
    std::filesystem::copy_file(folder_ / "cube.spcap", folder_ / "cut.spcap",
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(folder_ / "cut.spcap", left);
    expect_error("replay cut.spcap --techniques noaa --out out", 3, {"cut.spcap"});
  }
}

TEST_F(BadInput, ChangedCapture) {
  std::fstream file(folder_ / "cube.spcap", std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(folder_ / "cube.spcap") / 2);
  file.seekg(middle);
  const int byte = file.get();
  file.seekp(middle);
  file.put(static_cast<char>(byte ^ 1));
  file.close();
  expect_error("replay cube.spcap --techniques noaa --out out", 3, {"cube.spcap", "byte"});
}

TEST_F(BadInput, TextureThatIsNoImage) {
  capture::Capture capture = capture::read_capture(folder_ / "cube.spcap");
  capture::Texture texture;
  texture.name = "bark";
  texture.encoding = capture::TextureEncoding::image_file;
  texture.bytes.assign(100, std::byte{'x'});
  capture.textures = {texture};
  capture.materials.at(0).base_colour_texture = 0;
  capture::write_capture(capture, folder_ / "bark.spcap");
  expect_error("replay bark.spcap --techniques noaa --out out", 3, {"bark"});
}

TEST_F(BadInput, MissingModelAndTexture) {
  expect_error("import chair.obj chair.spcap", 3, {"chair.obj"});
  write("m.mtl", "newmtl a\nmap_Kd missing.png\n");
  write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n");
  const tests::Finished without = tests::run_binary("import m.obj m.spcap --frames 1", folder_);
  EXPECT_EQ(without.code, 0) << without.error;
  EXPECT_NE(without.error.find("ignored: texture \"missing.png\" of material \"a\""), std::string::npos)
      << without.error;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "m.spcap"));
}

TEST_F(BadInput, BrokenJsonNamesLineAndColumn) {
  write("scene.json", "{\n  \"models\": [\n    {,}\n  ]\n}\n");
  expect_error("import scene.json scene.spcap", 3, {"scene.json", "line 3", "column 6"});
  write("results.json", "{\"head\":\n}\n");
  expect_error("advise results.json --max-mse 0.001", 3, {"results.json", "line 2", "column 1"});
}

TEST_F(BadInput, NoVulkanDriver) {
  const std::string none = "VK_ICD_FILENAMES=/nonexistent.json VK_DRIVER_FILES=/nonexistent.json";
  expect_error(kReplay + "--techniques noaa", 4, {"device"}, none);
}

TEST_F(BadInput, NoLavapipe) {
  // Any other installed driver: with no such hardware it offers no device, with it one that is not lavapipe.
  std::filesystem::path other;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/usr/share/vulkan/icd.d", ignored))
    if (entry.path().filename().string().find("lvp") == std::string::npos) other = entry.path();
  if (other.empty()) GTEST_SKIP() << "no other driver is installed";
  expect_error(kReplay + "--techniques noaa", 4, {"device"},
               "VK_ICD_FILENAMES=" + other.string() + " VK_DRIVER_FILES=" + other.string());
}

TEST_F(BadInput, ADeviceThatIsNotThere) {
  for (const char* wanted : {"99", "abacus"})
    expect_error(kReplay + "--techniques noaa --device " + wanted, 4, {"device", wanted, "0 "});
}

TEST_F(BadInput, FullDisk) {
  // A file may hold one block; what goes over fails like a full disk, with SIGXFSZ ignored.
  expect_error("generate grass big.spcap --frames 1", 3, {"big.spcap"}, "", "trap '' XFSZ; ulimit -f 8; ");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "big.spcap"));
}

TEST_F(BadInput, FullDevice) {
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  expect_error("generate cube /dev/full", 3, {"/dev/full", "No space left"});
  expect_error(kReplay + "--techniques noaa --json /dev/full", 3, {"/dev/full", "No space left"});
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full")) << "a file took the device's place";
}

TEST_F(BadInput, OutputFolderThatCannotBeMade) {
  expect_error("replay cube.spcap --techniques noaa --out cube.spcap", 3, {"cube.spcap", "Not a directory"});
}

TEST_F(BadInput, FullDiskWhileReplaying) {
  // Not by a file size limit: the driver's memory is made of files too.
  const std::string small = (folder_ / "small").string();
  if (std::system(("mkdir '" + small + "' && mount -t tmpfs -o size=16k tmpfs '" + small + "' 2>/dev/null").c_str()) !=
      0)
    GTEST_SKIP() << "no small file system can be mounted here";
  expect_error("replay cube.spcap --reference-samples 4 --repeat 1 --techniques noaa --size 640x360 --out small/out", 3,
               {"small/out"});
  EXPECT_EQ(std::system(("umount '" + small + "'").c_str()), 0);
}

TEST_F(BadInput, CommandLine) {
  expect_error("", 2, {});
  expect_error("dance", 2, {"dance"});
  expect_error("replay", 2, {"file"});
  expect_error("generate forest f.spcap", 2, {"forest", "grass", "city"});
}

}  // namespace
}  // namespace subpixel::tests
