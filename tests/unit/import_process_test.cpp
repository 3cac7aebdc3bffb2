// `subpixel import` as a user meets it when a reader crashes, hangs or takes too much memory: one line, exit code 3,
// nothing left behind.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/technique/run_binary.hpp"

namespace subpixel::tests {
namespace {

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

class ImportProcess : public testing::Test {
 protected:
  ImportProcess()
      : folder_(std::filesystem::path(testing::TempDir()) / ("import_process_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_ / "out");
  }
  ~ImportProcess() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  // A comb of many teeth, over and over: ear clipping takes minutes.
  void write_slow() const {
    std::ofstream out(folder_ / "slow.obj");
    constexpr int kTeeth = 4998;
    out << "v 0 -1 0\nv " << kTeeth << " -1 0\n";
    for (int i = kTeeth; i > 0; --i) out << "v " << i << " 0 0\nv " << i - 0.5 << " 9 0\n";
    for (int face = 0; face < 500; ++face) {
      out << 'f';
      for (int i = 1; i <= 2 * kTeeth + 2; ++i) out << ' ' << i;
      out << '\n';
    }
  }

  Finished import(const std::string& arguments, const std::string& limits = "") const {
    return run_binary("import " + arguments, folder_, "", limits);
  }

  void expect_refused(const Finished& run, const std::string& reason) const {
    EXPECT_EQ(run.code, 3) << run.error;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(std::count(run.error.begin(), run.error.end(), '\n'), 1) << run.error;
    EXPECT_TRUE(run.error.starts_with("subpixel: can't import the model: ")) << run.error;
    EXPECT_NE(run.error.find(reason), std::string::npos) << run.error;
    EXPECT_TRUE(std::filesystem::is_empty(folder_ / "out"));
  }

  std::filesystem::path folder_;
};

TEST_F(ImportProcess, WritesTheCaptureAndNothingElse) {
  write("model.obj", kTriangle);
  const Finished run = import("model.obj out/c.spcap --frames 2 --size 64x48");
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_TRUE(run.out.starts_with("out/c.spcap: 2 frames, 1 draws, 1 triangles, ")) << run.out;
  EXPECT_EQ(run.error, "");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "out"), {}), 1);
  EXPECT_EQ(run_binary("validate out/c.spcap", folder_).code, 0);
  const auto mode = [&](const char* name) { return std::filesystem::status(folder_ / name).permissions(); };
  EXPECT_EQ(mode("out/c.spcap"), mode("model.obj")) << "as any new file";
}

TEST_F(ImportProcess, ErrorsAndProgressOfTheReaderPassThrough) {
  write("model.obj", std::string(kTriangle) + "f 1 2 7\n");
  expect_refused(import("model.obj out/c.spcap"), "\"7\"");
  EXPECT_EQ(import("none.obj out/c.spcap").error,
            "subpixel: can't import the model: there is no such file: none.obj\n");
  EXPECT_EQ(import("model.obj out/c.spcap --frames 0").code, 2);
  EXPECT_EQ(import("model.obj out/c.spcap --size 3").code, 2);
  EXPECT_EQ(import("model.obj out/c.spcap --limit-seconds=-1").code, 2);
  write("model.obj", std::string("l 1 2\n") + kTriangle);
  const Finished noticed = import("model.obj out/c.spcap --frames 1");
  EXPECT_EQ(noticed.code, 0);
  EXPECT_EQ(noticed.error, "ignored: statement \"l\" of OBJ, first in line 1\n");
}

TEST_F(ImportProcess, ACrashIsOneLine) {
  write_slow();
  // The kernel ends the reader by a signal when its second is used up.
  expect_refused(import("slow.obj out/c.spcap", "ulimit -S -t 1; "), "the reader crashed (signal 24): slow.obj");
}

TEST_F(ImportProcess, DamagedFilesOfFormatsThatAssimpReadsAreOneLine) {
  const std::pair<const char*, std::string> files[] = {
      {"huge.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\nproperty float x\nelement face 1\n"
       "property list uint uint vertex_indices\nend_header\n\xff\xff\xff\xff"},
      {"huge.off", "OFF\n4000000000 4000000000 0\n0 0 0\n"},
      {"index.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 77\n"},
      {"finite.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 nan 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {"empty.stl", ""},
      {"cut.stl", std::string(80, 'x') + std::string("\xff\xff\xff\x7f", 4)},
      {"text.fbx", "Kaydara FBX Binary  \x00\x1a\x00 and no more"},
      {"zip.3mf", "PK\x03\x04 and no more"},
      {"tree.x", "xof 0303txt 0032\nMesh m { 3; 0;0;0;, 1;0;0;, 0;1;0;; 1; 3;0,1,9;; }\n"},
  };
  for (const auto& [name, content] : files) {
    write(name, content);
    SCOPED_TRACE(name);
    expect_refused(import(std::string(name) + " out/c.spcap --limit-seconds 60"), name);
  }
}

TEST_F(ImportProcess, AHangEndsAtTheTimeLimit) {
  write_slow();
  expect_refused(import("slow.obj out/c.spcap --limit-seconds 1"), "longer than 1 s (--limit-seconds): slow.obj");
}

TEST_F(ImportProcess, MemoryEndsAtItsLimit) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's address space is no measure";
  write("large.obj", "");
  std::filesystem::resize_file(folder_ / "large.obj", std::uintmax_t{1} << 30);  // takes no space on the disk
  expect_refused(import("large.obj out/c.spcap --limit-memory 900"),
                 "more memory than --limit-memory allows: large.obj");
  write("model.obj", kTriangle);
  EXPECT_EQ(import("model.obj out/c.spcap --limit-memory 900 --frames 1").code, 0);
}

TEST_F(ImportProcess, WhatWasThereStaysWhenItFails) {
  write("out/c.spcap", "an earlier capture");
  write("model.obj", "f 1 2 3\n");
  EXPECT_EQ(import("model.obj out/c.spcap").code, 3);
  std::string kept;
  std::getline(std::ifstream(folder_ / "out/c.spcap"), kept);
  EXPECT_EQ(kept, "an earlier capture");
}

TEST_F(ImportProcess, AnInterruptLeavesNothing) {
  write_slow();
  const std::string command =
      "cd '" + folder_.string() + "' && timeout -s INT 1 '" SUBPIXEL_BINARY "' import slow.obj out/c.spcap 2>/dev/null";
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "out"));
}

TEST_F(ImportProcess, WhereItCantWriteItSaysSo) {
  write("model.obj", kTriangle);
  const Finished run = import("model.obj nowhere/c.spcap");
  EXPECT_EQ(run.code, 3);
  EXPECT_EQ(run.error, "subpixel: can't write the capture: No such file or directory: nowhere/c.spcap\n");
  const Finished full = import("model.obj out/c.spcap", "ulimit -f 1; ");
  EXPECT_EQ(full.code, 3);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "out"));
  EXPECT_EQ(import("model.obj /dev/null --frames 1").code, 0) << "a device is written in place";
}

}  // namespace
}  // namespace subpixel::tests
