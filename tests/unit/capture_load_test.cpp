// Payloads that several threads decode: the bytes of each, and the error of the first that can't be decoded.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "capture_format/reading/capture_file.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint32_t kBuffers = 24;

// A draw for each buffer of 300 KiB, and a texture of 256 KiB.
Capture many_buffers() {
  Capture capture;
  std::mt19937 numbers(5);
  const auto bytes = [&](std::size_t count) {
    std::vector<std::byte> all(count);
    for (auto& byte : all) byte = static_cast<std::byte>(numbers() & 0x3f);
    return all;
  };
  Texture texture;
  texture.name = "texels";
  texture.width = texture.height = 256;
  texture.bytes = bytes(4 * 256 * 256);
  capture.textures = {texture};
  Material material;
  material.base_colour_texture = 0;
  capture.materials = {material};
  Frame frame;
  frame.width = frame.height = 16;
  for (std::uint32_t b = 0; b < kBuffers; ++b) {
    capture.buffers.push_back({"vertices", bytes(300 * 1024)});
    Draw draw;
    draw.name = "triangle";
    draw.position = {b, VertexFormat::float32x3, 0, 12};
    draw.vertex_count = 3;
    frame.draws.push_back(draw);
  }
  capture.frames = {frame};
  return capture;
}

class CaptureLoad : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  void write(std::span<const std::byte> bytes) {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("subpixel_load_" + std::to_string(::getpid()) + ".spcap");
};

TEST_F(CaptureLoad, GivesEachBufferAndTextureItsBytes) {
  const Capture capture = many_buffers();
  for (const int level : {0, 3}) {
    write_capture(capture, path_, {.zstd_level = level});
    const Capture loaded = CaptureFile(path_).load(0, 0);
    ASSERT_EQ(loaded.buffers.size(), capture.buffers.size());
    for (std::uint32_t b = 0; b < kBuffers; ++b) EXPECT_EQ(loaded.buffers[b].bytes, capture.buffers[b].bytes) << b;
    ASSERT_EQ(loaded.textures.size(), 1U);
    EXPECT_EQ(loaded.textures[0].bytes, capture.textures[0].bytes);
  }
}

// Whose thread may well be done after that of the second.
TEST_F(CaptureLoad, NamesTheFirstPayloadThatIsWrong) {
  Forgery forgery(many_buffers());
  for (const std::uint32_t number : {7U, 8U, 20U}) {
    const std::size_t at = forgery.chunk(ChunkType::data, number) + kChunkHeaderBytes;
    forgery.set(at, ~forgery.get<std::uint32_t>(at));
  }
  write(forgery.bytes());
  const CaptureFile file(path_);
  for (int turn = 0; turn < 20; ++turn) {
    try {
      file.load(0, 0);
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("DATA 7"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace subpixel::capture
