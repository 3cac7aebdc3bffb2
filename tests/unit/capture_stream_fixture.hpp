// A small recording of several frames, made by either recorder, and a folder for its file.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "capture_format/recorder.hpp"

namespace subpixel::capture {

class CaptureStreamRecorder : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::vector<std::byte> bytes_of_file(const std::filesystem::path& path) const {
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("subpixel_stream_" + std::to_string(::getpid()));
  const std::filesystem::path path_ = folder_ / "recorded.spcap";
};

// A triangle whose vertices are others in each frame, beside a quad that stays; materials come as they are needed.
template <typename Recorder>
void record_frame(Recorder& recorder, std::uint32_t number) {
  const auto f = static_cast<float>(number);
  const std::vector<float> moved{0, f, -2, 1, f, -2, 0, f + 1, -2};
  const std::vector<float> still{0, 0, -3, 1, 0, -3, 0, 1, -3, 1, 1, -3};
  const std::vector<std::uint16_t> order{0, 1, 2, 2, 1, 3};
  Texture texture{"dots", TextureEncoding::rgba8, true, 1, 1, std::vector<std::byte>(4, std::byte(number / 2)), {}};
  Material material;
  material.name = "material " + std::to_string(number);
  material.base_colour_texture = recorder.add_texture(texture);
  Draw first, second;
  first.name = "moved";
  first.position = {recorder.add_buffer("moved", std::as_bytes(std::span(moved))), VertexFormat::float32x3, 0, 12};
  first.vertex_count = first.index_count = 3;
  first.material = recorder.add_material(material);
  second.name = "still";
  second.position = {recorder.add_buffer("still", std::as_bytes(std::span(still))), VertexFormat::float32x3, 0, 12};
  second.vertex_count = 4;
  second.index_type = IndexType::uint16;
  second.index_buffer = recorder.add_buffer("order", std::as_bytes(std::span(order)));
  second.index_count = 6;
  second.material = 0;
  Frame frame;
  frame.name = "frame " + std::to_string(number);
  frame.view = frame.projection = Draw{}.transform;
  recorder.begin_frame(frame);
  recorder.draw(first);
  recorder.draw(second);
  recorder.end_frame();
}

inline constexpr std::uint32_t kFrames = 7;

inline Capture in_memory() {
  Recorder recorder(Metadata{"Streamed", "a test", "a recorder", "CC0-1.0"});
  for (std::uint32_t f = 0; f < kFrames; ++f) record_frame(recorder, f);
  return recorder.take();
}

}  // namespace subpixel::capture
