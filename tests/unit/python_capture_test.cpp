// What python/subpixel_capture writes, read and written again here.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "capture_format/stream_recorder.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

int python(const std::string& arguments) {
  return std::system(("python3 " SUBPIXEL_SOURCE_DIR "/tests/python/exchange.py " + arguments).c_str());
}

std::vector<std::byte> contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(PythonCapture, IsReadAndWrittenAgainAndReadThere) {
  const auto folder = std::filesystem::path(::testing::TempDir());
  const std::filesystem::path theirs = folder / "python_capture_theirs.spcap",
                              ours = folder / "python_capture_ours.spcap";
  ASSERT_EQ(python("write " + theirs.string()), 0);
  const std::vector<std::byte> written = contents(theirs);
  ASSERT_EQ(refusal(written), "");
  const Capture capture = decode_capture(written);
  EXPECT_EQ(capture.materials[1].normal_scale, -0.5f);
  EXPECT_EQ(capture.frames[0].draws[0].colour.format, VertexFormat::unorm8x4);
  const std::vector<std::byte> own = encode_capture(capture);
  EXPECT_NE(own, written);
  EXPECT_EQ(encode_capture(decode_capture(own)), own);
  write_capture(capture, ours);
  EXPECT_EQ(python("compare " + theirs.string() + " " + ours.string()), 0);
  std::filesystem::remove(theirs);
  std::filesystem::remove(ours);
}

// Chunks in the order of recording, materials in several.
TEST(PythonCapture, StreamedRecordingsAreReadThere) {
  const auto folder = std::filesystem::path(::testing::TempDir());
  const std::filesystem::path streamed = folder / "python_capture_streamed.spcap",
                              ordered = folder / "python_capture_ordered.spcap";
  const Capture capture = small_capture();
  StreamRecorder recorder(capture.metadata, streamed);
  for (const Buffer& buffer : capture.buffers) recorder.add_buffer(buffer.name, buffer.bytes);
  for (const Texture& texture : capture.textures) recorder.add_texture(texture);
  for (const Frame& frame : capture.frames) {
    recorder.add_material(capture.materials[frame.draws.empty() ? 0 : 1]);
    Frame head = frame;
    head.draws.clear();
    recorder.begin_frame(head);
    recorder.end_frame();
  }
  recorder.finish();
  write_capture(read_capture(streamed), ordered);
  EXPECT_EQ(python("compare " + streamed.string() + " " + ordered.string()), 0);
  std::filesystem::remove(streamed);
  std::filesystem::remove(ordered);
}

}  // namespace
}  // namespace subpixel::capture
