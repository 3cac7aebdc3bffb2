// A capture of more than 4 GiB: it is opened, outlined and one frame of it loaded without the rest being read.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "capture_format/reading/capture_file.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint64_t kHole = std::uint64_t{1} << 30;  // added to the data of each frame but the first
constexpr std::uint32_t kFrames = 5;

// Each frame draws one triangle from a buffer of its own.
Capture frames_of_their_own() {
  Capture capture;
  capture.materials = {Material{}};
  for (std::uint32_t f = 0; f < kFrames; ++f) {
    const auto x = static_cast<float>(f);
    capture.buffers.push_back({"vertices", bytes_of(std::vector<float>{x, 0, -2, x + 1, 0, -2, x, 1, -2})});
    Draw draw;
    draw.name = "triangle";
    draw.position = {f, VertexFormat::float32x3, 0, 12};
    draw.vertex_count = 3;
    Frame frame;
    frame.width = frame.height = 16;
    frame.draws = {draw};
    capture.frames.push_back(frame);
  }
  return capture;
}

// Writes the capture with a hole of kHole bytes at the end of each DATA chunk but the first. Header, index and footer
// say so and are signed; the checksums of those chunks are not, which whoever reads one finds out.
void write_with_holes(const std::string& path) {
  Forgery forgery(frames_of_their_own());
  const std::size_t index = forgery.chunk(ChunkType::index);
  const std::size_t footer = index + kChunkHeaderBytes + forgery.get<std::uint64_t>(index + 16);
  std::uint64_t added = 0;
  std::ofstream out(path, std::ios::binary);
  const auto put = [&](std::size_t from, std::size_t to) {
    out.seekp(static_cast<std::streamoff>(from + added));
    out.write(reinterpret_cast<const char*>(forgery.bytes().data() + from), static_cast<std::streamsize>(to - from));
  };
  put(0, kHeaderBytes);
  const std::size_t entries = forgery.get<std::uint64_t>(index + 16) / 16;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = index + kChunkHeaderBytes + 16 * i;
    const std::size_t at = forgery.get<std::uint64_t>(entry + 8);
    const std::size_t end = i + 1 < entries ? forgery.get<std::uint64_t>(entry + 24) : index;
    const bool grows = forgery.get<ChunkType>(at) == ChunkType::data && forgery.get<std::uint32_t>(at + 4) > 0;
    const std::uint64_t bytes = forgery.get<std::uint64_t>(at + 16) + (grows ? kHole : 0);
    forgery.set(at + 16, bytes);
    forgery.set(at + 24, bytes);
    forgery.set(entry + 8, at + added);
    put(at, end);
    if (grows) added += kHole;
  }
  forgery.sign(index);
  forgery.set(footer, index + added);
  forgery.set(footer + 8, forgery.bytes().size() + added);
  forgery.sign_footer();
  put(index, forgery.bytes().size());
}

// Bytes of files that are mapped and in memory.
std::uint64_t resident_file_bytes() {
  std::ifstream status("/proc/self/status");
  std::uint64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "RssFile:") status >> kib;
  }
  return kib * 1024;
}

TEST(CaptureLargeFile, IsOpenedAndOneFrameLoadedWithoutReadingTheRest) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("subpixel_large_" + std::to_string(::getpid()) + ".spcap");
  write_with_holes(path.string());
  ASSERT_GT(std::filesystem::file_size(path), std::uint64_t{4} << 30);
  const std::uint64_t before = resident_file_bytes();
  ASSERT_GT(before, 0u);

  const CaptureFile file(path);
  EXPECT_EQ(file.frame_count(), kFrames);
  const CaptureFile::Outline outline = file.outline();
  EXPECT_EQ(outline.capture.frames.size(), kFrames);
  EXPECT_EQ(outline.buffer_bytes, (std::vector<std::uint64_t>{36, 36 + kHole, 36 + kHole, 36 + kHole, 36 + kHole}));
  const Capture first = file.load(0, 0);
  ASSERT_EQ(first.buffers.size(), 1u);
  EXPECT_EQ(first.buffers[0].bytes, frames_of_their_own().buffers[0].bytes);
  // What a page fault brings with it is far below this.
  EXPECT_LT(resident_file_bytes() - before, std::uint64_t{16} << 20);

  // The hole is what the other frames would have to read, and not what was signed.
  try {
    file.load(1, 1);
    ADD_FAILURE() << "was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("DATA 1"), std::string::npos) << error.what();
  }
  EXPECT_GT(resident_file_bytes() - before, std::uint64_t{512} << 20);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace subpixel::capture
