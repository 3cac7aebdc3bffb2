// Records 100 frames of a spinning pyramid into the file that is named.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <span>

#include "base/error.hpp"
#include "capture_format/stream_recorder.hpp"

using namespace subpixel::capture;

static void record(StreamRecorder& recorder) {
  static constexpr float kCorners[5][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1.5f, 0}};
  static constexpr std::uint16_t kTriangles[] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0, 0, 1, 2, 0, 2, 3};
  Material gold;
  gold.name = "gold";
  gold.base_colour = {1, 0.7f, 0.3f, 1};
  gold.metallic = 1;
  gold.roughness = 0.3f;

  Draw pyramid;
  pyramid.name = "pyramid";
  pyramid.material = recorder.add_material(gold);
  pyramid.position.buffer = recorder.add_buffer("corners", std::as_bytes(std::span(kCorners)));
  pyramid.position.stride = sizeof kCorners[0];
  pyramid.vertex_count = 5;
  pyramid.index_buffer = recorder.add_buffer("triangles", std::as_bytes(std::span(kTriangles)));
  pyramid.index_type = IndexType::uint16;
  pyramid.index_count = 18;

  Frame frame;  // reversed depth, the far plane at infinity, Vulkan's clip space
  frame.view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -0.5f, -4, 1};
  frame.projection = {1, 0, 0, 0, 0, -16 / 9.0f, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0};
  frame.sun = DirectionalLight{{-0.5f, -1, -0.7f}, {3, 3, 3}, true};
  for (int f = 0; f < 100; ++f) {
    const float c = std::cos(0.0628f * static_cast<float>(f)), s = std::sin(0.0628f * static_cast<float>(f));
    pyramid.transform = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1};
    frame.time_s = f / 60.0;
    recorder.begin_frame(frame);
    recorder.draw(pyramid);
    recorder.end_frame();
  }
  recorder.finish();
}

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  Metadata metadata;
  metadata.title = "Spinning pyramid";
  metadata.tool = "spinning.cpp";
  StreamRecorder recorder(metadata, argv[1]);
  record(recorder);
  return 0;
} catch (const subpixel::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
