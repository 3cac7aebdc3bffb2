// Set-up on the host against set-up by the device's shaders: the same triangles, to the bit.
#include <gtest/gtest.h>

#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 160, kHeight = 90;

// Set-up of the first frame; of rows of it, where `rows` are given.
class SetUpFrame {
 public:
  SetUpFrame(const capture::Capture& capture, SetupPlace place, std::uint32_t samples, std::uint32_t first_row,
             std::uint32_t rows)
      : scene_(test_device(), capture, {}), frontend_(test_device(), scene_, place) {
    scene_.set_frame(0, kWidth, kHeight);
    scene_.set_band(first_row, rows);
    frontend_.prepare(samples);
    gpu::PassRecorder recorder(test_device());
    frontend_.record_setup(recorder);
    recorder.run();
  }
  Frontend& frontend() { return frontend_; }

  std::vector<std::uint32_t> counts() {
    const auto all = frontend_.counts().as<std::uint32_t>();
    return {all.begin(), all.end()};
  }
  std::vector<std::uint32_t> hull_indices() {
    const auto all = frontend_.hull_indices().as<std::uint32_t>().first(3 * frontend_.hull_triangles());
    return {all.begin(), all.end()};
  }
  const gpu_types::TriangleRecord& record(std::uint32_t number) {
    return frontend_.records().as<gpu_types::TriangleRecord>()[number];
  }

 private:
  GpuScene scene_;
  Frontend frontend_;
};

void expect_same_set_up(const capture::Capture& capture, std::uint32_t samples, std::uint32_t first_row = 0,
                        std::uint32_t rows = kHeight) {
  SetUpFrame device(capture, SetupPlace::device, samples, first_row, rows);
  SetUpFrame host(capture, SetupPlace::host, samples, first_row, rows);
  EXPECT_EQ(host.frontend().clipped_count(), device.frontend().clipped_count());
  EXPECT_EQ(host.frontend().hull_count(), device.frontend().hull_count());
  ASSERT_EQ(host.counts(), device.counts());
  const std::vector<std::uint32_t> corners = device.hull_indices();
  ASSERT_EQ(host.hull_indices(), corners);
  std::size_t different = 0;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const gpu_types::TriangleRecord &a = host.record(corners[i] / 4), &b = device.record(corners[i] / 4);
    if (std::memcmp(&a, &b, sizeof a) == 0) continue;
    if (++different > 3) continue;
    const auto* x = reinterpret_cast<const std::uint32_t*>(&a);
    const auto* y = reinterpret_cast<const std::uint32_t*>(&b);
    for (std::size_t k = 0; k < sizeof a / 4; ++k)
      EXPECT_EQ(x[k], y[k]) << "word " << k << " of record " << corners[i] / 4 << ", in floats "
                            << std::bit_cast<float>(x[k]) << " and " << std::bit_cast<float>(y[k]);
  }
  EXPECT_EQ(different, 0U) << "records of " << corners.size() / 3;
}

class HostSetup : public testing::TestWithParam<std::string> {};

TEST_P(HostSetup, LeavesTheBitsOfTheDevice) {
  const capture::Capture capture = capture::generate(GetParam(), {1, kWidth, kHeight, 1, 0.1});
  for (const std::uint32_t samples : {1U, 8U, 64U}) {
    SCOPED_TRACE(samples);
    expect_same_set_up(capture, samples);
  }
  expect_same_set_up(capture, 8, 31, 17);
}

INSTANTIATE_TEST_SUITE_P(Scenes, HostSetup, testing::ValuesIn(every_scene()),
                         [](const auto& tested) { return tested.param; });

// Triangles of all sizes up to 2 to the power `largest`, most of them near or across the borders, the eye's plane and
// the guard band, all of it `scale` times as large.
std::vector<float> random_triangles(double largest, double scale) {
  Numbers numbers(7);
  std::vector<float> positions;
  for (int i = 0; i < 6000; ++i) {
    const double size = std::exp2(numbers.real(-8, largest));
    const glm::dvec3 middle(numbers.real(-3, 3), numbers.real(-3, 3), numbers.real(-4, 0.5));
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        positions.push_back(static_cast<float>(scale * (middle[axis] + size * numbers.real(-1, 1))));
  }
  return positions;
}

// Reversed depth, the near plane at 0.01.
glm::dmat4 perspective() {
  glm::dmat4 projection(0.0);
  projection[0][0] = 1.2;
  projection[1][1] = -2.1;
  projection[2][3] = -1;
  projection[3][2] = 0.01;
  return projection;
}

TEST(HostSetupOf, RandomTrianglesLeavesTheBitsOfTheDevice) {
  for (const bool two_sided : {true, false}) {
    capture::Capture capture = triangle_list_capture(random_triangles(7, 1), perspective());
    capture.materials[0].two_sided = two_sided;
    for (const std::uint32_t samples : {1U, 4U, 16U, 32U}) {
      SCOPED_TRACE(samples);
      expect_same_set_up(capture, samples);
    }
    expect_same_set_up(capture, 8, 80, 10);
  }
}

// Depths too small for normal numbers, which lavapipe's compute keeps.
TEST(HostSetupOf, TrianglesFarAwayLeavesTheBitsOfTheDevice) {
  expect_same_set_up(triangle_list_capture(random_triangles(2, 1e37), perspective()), 8);
}

}  // namespace
}  // namespace subpixel::replay
