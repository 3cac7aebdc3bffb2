// Frames of a file by themselves.
#include "replay/single_frame.hpp"

#include <unistd.h>

#include <gtest/gtest.h>

#include <cstring>

#include "capture_format/writer.hpp"
#include "replay/scene/gpu_scene.hpp"
#include "scenes/generate/generate.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37, kFrames = 11, kLights = 20;

// The first bytes of a frame's lights as shaders read them.
std::vector<std::byte> lights_of(const capture::Capture& capture, std::uint32_t frame) {
  GpuScene scene(test_device(), capture, {.point_lights = kLights});
  scene.set_frame(frame, kWidth, kHeight);
  EXPECT_EQ(scene.constants().counts.x, kLights);
  std::vector<std::byte> bytes(kLights * sizeof scene.constants().point_lights[0]);
  std::memcpy(bytes.data(), scene.constants().point_lights, bytes.size());
  return bytes;
}

// Lights are placed for frames from all over the capture, more than the one that is drawn.
TEST(SingleFrame, HasThePlacedLightsOfTheWholeCapture) {
  const auto path =
      std::filesystem::temp_directory_path() / ("subpixel-single-" + std::to_string(::getpid()) + ".spcap");
  capture::write_capture(capture::generate("city", {kFrames, kWidth, kHeight, 1, 0.02}), path);
  const capture::CaptureFile file(path);
  const capture::Capture whole = file.load(0, kFrames - 1);
  for (const std::uint32_t frame : {0U, 4U, kFrames - 1}) {
    SCOPED_TRACE(frame);
    const std::vector<std::byte> expected = lights_of(whole, frame);
    EXPECT_EQ(lights_of(load_frame(path, frame, 0, kLights), frame), expected);
    EXPECT_EQ(lights_of(load_frames(file, frame / 2, frame, kLights), frame), expected);
  }
  // As many of the captured ones are taken as there are; none is placed for those.
  const capture::Capture alone = load_frame(path, 4, 0, 0);
  EXPECT_TRUE(alone.frames[5].draws.empty());
  EXPECT_FALSE(alone.frames[4].draws.empty());
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace subpixel::replay
