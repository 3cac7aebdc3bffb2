// The reference against images known without rendering.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference.hpp"
#include "replay/reference/triangle_list.hpp"
#include "replay/reference/turns.hpp"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kSide = 32;

ReferenceImage render(const capture::Capture& capture, std::uint32_t samples, std::uint32_t side = kSide) {
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, side, side);
  return render_reference(test_device(), scene, {.samples = samples});
}

float red(const ReferenceImage& image, std::uint32_t x, std::uint32_t y) {
  return image.linear.pixels[image.linear.offset(x, y)];
}

double mean_red(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) sum += image.pixels[i];
  return sum / (static_cast<double>(image.pixels.size()) / 3);
}

// Pixel coordinates of the image to world coordinates of flat_capture().
float world_x(double pixel) {
  return static_cast<float>(2 * pixel / kSide - 1);
}
float world_y(double pixel) {
  return static_cast<float>(1 - 2 * pixel / kSide);
}

TEST(ReferenceTurns, SamplesOfAllTurnsFillThePixelEvenly) {
  for (const std::uint32_t side : {2u, 4u}) {
    for (const std::uint32_t turns : {1u, 16u, 20u, 128u}) {
      const auto constants = turn_constants(turns, side, 640, 360);
      int cells[8][8] = {};
      for (const auto& turn : constants)
        for (std::uint32_t s = 0; s < side * side; ++s) {
          const glm::vec2 p = sample_place(turn, s);
          ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
          ++cells[static_cast<int>(p.y * 8)][static_cast<int>(p.x * 8)];
        }
      if (turns < 16) continue;
      for (const auto& row : cells)
        for (const int count : row) EXPECT_NEAR(count, turns * side * side / 64.0, turns > 16 ? 2 : 1);
    }
  }
}

// Shading points of a pixel, or of its quarter, that one triangle fills: a rectangle of 1/turns of it, cut by halves,
// has one each.
TEST(ReferenceTurns, ShadingPointsFillThePixelEvenly) {
  for (const std::uint32_t side : {2u, 4u}) {
    for (std::uint32_t bits = 2; bits <= 10; ++bits) {
      const std::uint32_t turns = 1u << bits;
      const auto constants = turn_constants(turns, side, 640, 360);
      for (std::uint32_t across = 0; across <= bits; ++across) {
        const std::uint32_t columns = 1u << across, rows = turns / columns;
        std::vector<int> cells(turns);
        for (const gpu_types::TurnConstants& turn : constants) {
          // Of sixteen samples the first four are those of the first quarter.
          const glm::vec2 p = sample_place(turn, shaded_sample(turn)) * (static_cast<float>(side) / 2);
          ++cells[static_cast<std::uint32_t>(p.y * static_cast<float>(rows)) * columns +
                  static_cast<std::uint32_t>(p.x * static_cast<float>(columns))];
        }
        EXPECT_EQ(std::ranges::count(cells, 1), turns) << side << ", " << turns << " turns, " << columns << " columns";
      }
    }
  }
}

// A triangle that fills part of a pixel is shaded all over that part: its colour rises by a quarter a pixel to the
// right and down, so that a place preferred by an eighth of a pixel shows.
TEST(ReferenceImage, PartsOfPixelsAreShadedEvenly) {
  constexpr double kFrom = 8, kSlope = 0.25;  // colour 0 at the corner (kFrom, kFrom)
  const auto colour_at = [](double x, double y) { return kSlope * (x - kFrom) + 0.5 * kSlope * (y - kFrom); };
  struct Part {
    double right, below, sum;  // of x, of y, of both: what is seen lies before these
  };
  for (const Part& part : {Part{12, 9.5, 99}, Part{9.5, 12, 99}, Part{12, 12, 19.5}, Part{12, 12, 18.5}}) {
    auto capture = flat_capture(kSide, kSide);
    capture.frames[0].ambient = {0, 0, 0};
    capture::Material plain;
    plain.name = "unlit";
    plain.unlit = true;
    plain.two_sided = true;
    capture.materials.push_back(plain);
    const double most = std::min(part.right - kFrom, part.sum - 2 * kFrom);
    const double down = std::min(part.below - kFrom, part.sum - 2 * kFrom);
    // A triangle that the diagonal bounds, or a rectangle.
    const bool is_triangle = part.sum < 90;
    std::vector<float> corners, colours;
    const auto add = [&](double x, double y) {
      corners.insert(corners.end(), {world_x(x), world_y(y), 0});
      const auto colour = static_cast<float>(colour_at(x, y));
      colours.insert(colours.end(), {colour, colour, colour, 1});
    };
    add(kFrom, kFrom), add(kFrom, kFrom + down), add(kFrom + most, kFrom);
    if (!is_triangle) add(kFrom + most, kFrom), add(kFrom, kFrom + down), add(kFrom + most, kFrom + down);
    auto& draw = add_triangles(capture, corners, static_cast<std::uint32_t>(capture.materials.size() - 1));
    draw.colour = {add_buffer(capture, colours), capture::VertexFormat::float32x4, 0, 16};
    GpuScene scene(test_device(), capture, {});
    scene.set_frame(0, kSide, kSide);
    const auto once = render_reference(test_device(), scene, {.samples = 4096});
    const auto all = render_reference(test_device(), scene, {.samples = 4096, .shade_all_samples = true});
    for (const auto& [x, y] : {std::pair{8u, 8u}, {9u, 8u}, {8u, 9u}, {9u, 9u}, {10u, 8u}, {10u, 9u}, {9u, 10u}}) {
      EXPECT_NEAR(red(once, x, y), red(all, x, y), 0.004)
          << "pixel " << x << " " << y << " before " << part.right << " " << part.below << " " << part.sum;
    }
    // The first rectangle's row 9 is half seen, and pixel (9, 8) whole.
    if (part.below == 9.5) {
      EXPECT_NEAR(red(once, 10, 9), 0.5 * colour_at(10.5, 9.25), 0.002);
      EXPECT_NEAR(red(once, 9, 8), colour_at(9.5, 8.5), 0.002);
    }
  }
}

// A pixel that one triangle fills: one shading for four samples, whether a turn has four or sixteen.
TEST(ReferenceImage, FourSamplesShareAShading) {
  auto capture = flat_capture(kSide, kSide);
  const auto material = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, {-3, -1, 0, 3, -1, 0, 0, 3, 0}, material);
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, kSide, kSide);
  for (const std::uint32_t samples : {128u, 256u}) {
    PixelReference told{.pixel = {16, 20}, .shadings = {}};
    render_reference(test_device(), scene, {.samples = samples, .story = &told});
    EXPECT_EQ(told.shadings.size(), samples / 4);
    int cells[4][4] = {};
    for (const PixelShading& one : told.shadings) {
      EXPECT_EQ(std::popcount(one.samples), 4);
      ++cells[static_cast<int>(4 * one.at.y)][static_cast<int>(4 * one.at.x)];
    }
    for (const auto& row : cells)
      for (const int count : row) EXPECT_EQ(count, samples / 64);
  }
}

TEST(ReferenceImage, AnAxisAlignedRectangleCoversItsArea) {
  auto capture = flat_capture(kSide, kSide);
  const auto material = add_emitter(capture, {1, 0.5f, 0.25f});
  capture.frames[0].ambient = {0, 0, 0};
  add_triangles(capture, rectangle(world_x(4.3), world_y(20.6), world_x(17.9), world_y(9.25), 0), material);
  const auto image = render(capture, 512);
  const double expected[] = {0.7, 1.0, 0.9};
  const std::uint32_t columns[] = {4, 10, 17};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(red(image, columns[i], 12), expected[i], 0.01) << "column " << columns[i];
  EXPECT_NEAR(red(image, 10, 9), 0.75, 0.01);
  EXPECT_NEAR(red(image, 10, 20), 0.6, 0.01);
  EXPECT_NEAR(red(image, 4, 9), 0.7 * 0.75, 0.01);
  EXPECT_EQ(red(image, 3, 12), 0.0f);
  EXPECT_EQ(red(image, 10, 8), 0.0f);
  // Snapping to 1/256 pixel moves an edge by 1/512 pixel at most.
  EXPECT_NEAR(mean_red(image.linear) * kSide * kSide, 13.6 * 11.35, 0.15);
  EXPECT_NEAR(image.linear.pixels[image.linear.offset(10, 12) + 1], 0.5, 1e-6);
}

TEST(ReferenceImage, SlantedEdgesConverge) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  add_triangles(capture, {-0.83f, -0.71f, 0, 0.92f, -0.37f, 0, -0.11f, 0.88f, 0}, add_emitter(capture, {1, 1, 1}));
  const double area = 0.5 * std::abs((0.92 + 0.83) * (0.88 + 0.71) - (-0.11 + 0.83) * (-0.37 + 0.71)) / 4;
  const auto exact = render(capture, 2048);
  EXPECT_NEAR(mean_red(exact.linear), area, 2e-4);
  double error_before = 1;
  for (const std::uint32_t samples : {4u, 64u, 512u}) {
    const auto image = render(capture, samples);
    EXPECT_NEAR(mean_red(image.linear), area, 0.02 / std::sqrt(samples));
    const double error = std::sqrt(mse(exact.display, image.display));
    EXPECT_LT(error, error_before * 0.5) << samples << " samples";
    error_before = error;
  }
}

TEST(ReferenceImage, NearerTrianglesHideAndTheSkyFillsTheRest) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sky = {0.25f, 0.5f, 0.125f};
  const auto dim = add_emitter(capture, {0.5f, 0, 0}), bright = add_emitter(capture, {2, 0, 0});
  add_triangles(capture, rectangle(-1, -1, 0, 1, 0.5f), bright);
  add_triangles(capture, rectangle(-1, -1, 0, 1, 0.25f), dim);  // behind the first
  add_triangles(capture, rectangle(-1, 0, 0, 1, 0.75f), dim);   // before it, upper half
  const auto image = render(capture, 16);
  EXPECT_EQ(red(image, 5, 25), 2.0f);
  EXPECT_EQ(red(image, 5, 5), 0.5f);
  EXPECT_EQ(red(image, 25, 5), 0.25f);
}

TEST(ReferenceImage, OfCoplanarTrianglesTheFirstSubmittedIsSeen) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  const auto first = add_emitter(capture, {1, 0, 0}), second = add_emitter(capture, {3, 0, 0});
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0.5f), first);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0.5f), second);
  const auto image = render(capture, 16);
  EXPECT_EQ(*std::max_element(image.linear.pixels.begin(), image.linear.pixels.end()), 1.0f);
}

TEST(ReferenceImage, BackFacesShowOnlyWhenTwoSidedAndMirroringTurnsThem) {
  for (const bool two_sided : {false, true})
    for (const bool mirrored : {false, true})
      for (const bool reversed : {false, true}) {
        auto capture = flat_capture(kSide, kSide);
        capture.frames[0].ambient = {0, 0, 0};
        const auto material = add_emitter(capture, {1, 0, 0});
        capture.materials[material].two_sided = two_sided;
        auto corners = rectangle(-1, -1, 1, 1, 0);
        if (reversed)
          for (std::size_t t = 0; t < corners.size(); t += 9)
            std::swap_ranges(corners.begin() + static_cast<std::ptrdiff_t>(t),
                             corners.begin() + static_cast<std::ptrdiff_t>(t) + 3,
                             corners.begin() + static_cast<std::ptrdiff_t>(t) + 3);
        auto& draw = add_triangles(capture, corners, material);
        if (mirrored) draw.transform[0] = -1;
        // Mirroring moves the corners and turns what counts as front, so only the winding in the object decides.
        const float expected = two_sided || !reversed ? 1.0f : 0.0f;
        EXPECT_EQ(red(render(capture, 4), 7, 9), expected)
            << "two-sided " << two_sided << ", mirrored " << mirrored << ", reversed " << reversed;
      }
}

TEST(ReferenceImage, NormalsFaceTheViewerOnBothSides) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sun = capture::DirectionalLight{{0, 0, -1}, {3, 3, 3}, false};
  capture::Material material;
  material.roughness = 1;
  material.two_sided = true;
  capture.materials.push_back(material);
  auto corners = rectangle(-1, -1, 1, 1, 0);
  add_triangles(capture, corners, 0);
  const float front = red(render(capture, 4), 5, 5);
  EXPECT_GT(front, 0.5f);
  capture.frames[0].draws[0].transform[0] = -1;  // mirrored
  EXPECT_NEAR(red(render(capture, 4), 5, 5), front, 1e-5);
  capture.frames[0].draws[0].transform[0] = -1;  // turned around y: the back is seen
  capture.frames[0].draws[0].transform[10] = -1;
  EXPECT_NEAR(red(render(capture, 4), 5, 5), front, 1e-5);
}

TEST(ReferenceImage, TheAlphaTestCutsAtEverySample) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  const auto material = add_emitter(capture, {1, 0, 0});
  auto& m = capture.materials[material];
  // Alpha falls linearly over the middle texel's width; 0.5 is passed exactly in the middle of the image.
  m.base_colour_texture = add_texture(capture, 2, 1, {255, 255, 255, 255, 255, 255, 255, 0}, true);
  m.alpha_mode = capture::AlphaMode::test;
  auto& draw = add_triangles(capture, rectangle(world_x(-8.3), world_y(32), world_x(40.9), world_y(0), 0), material);
  draw.uv = {add_buffer(capture, rectangle_uvs()), capture::VertexFormat::float32x2, 0, 8};
  const auto image = render(capture, 512);
  // The texture spans pixels -8.3 to 40.9, its middle is at 16.3.
  EXPECT_EQ(red(image, 15, 9), 1.0f);
  EXPECT_NEAR(red(image, 16, 9), 0.3, 0.02);
  EXPECT_EQ(red(image, 17, 9), 0.0f);
}

TEST(ReferenceImage, BlendedMaterialsLetThroughWhatTheirAlphaLeaves) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  const auto material = add_emitter(capture, {1, 0, 0});
  capture.materials[material].base_colour[3] = 0.25f;
  capture.materials[material].alpha_mode = capture::AlphaMode::blend;
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);
  add_triangles(capture, rectangle(-1, -1, 0, 1, 0.5f), material);
  const auto image = render(capture, 1024);
  EXPECT_NEAR(red(image, 25, 9), 0.25, 0.01);
  EXPECT_NEAR(red(image, 5, 9), 1 - 0.75 * 0.75, 0.03);
}

TEST(ReferenceImage, TexturesAreWhereTheirCoordinatesSay) {
  auto capture = flat_capture(kSide, kSide);
  const auto material = add_emitter(capture, {1, 1, 1});
  auto& m = capture.materials[material];
  m.emissive_texture =
      add_texture(capture, 2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 188, 188, 188, 255}, true);
  capture.frames[0].ambient = {0, 0, 0};
  auto& draw = add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);
  draw.uv = {add_buffer(capture, rectangle_uvs()), capture::VertexFormat::float32x2, 0, 8};
  const auto image = render(capture, 64);
  const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return image.linear.pixels[image.linear.offset(x, y) + c];
  };
  // Texel centres are at pixels 8 and 24; the pixels beside them are within 1/32 of a texel.
  EXPECT_NEAR(at(8, 8, 0), 1, 0.1);
  EXPECT_NEAR(at(24, 8, 1), 1, 0.1);
  EXPECT_NEAR(at(8, 24, 2), 1, 0.1);
  for (const std::uint32_t c : {0u, 1u, 2u}) EXPECT_NEAR(at(24, 24, c), 0.5, 0.06);
}

TEST(ReferenceImage, TheSunsShadowFallsWhereItShould) {
  auto capture = flat_capture(64, 64);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sun = capture::DirectionalLight{{1, 0, -1}, {3, 3, 3}, true};
  capture::Material material;
  material.two_sided = true;
  capture.materials.push_back(material);
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.5f), 0);
  // A plate 0.5 above the floor: its shadow lies 0.5 further along x. The plate itself hides [-0.75, -0.25].
  add_triangles(capture, rectangle(-0.75f, -0.5f, -0.25f, 0.5f, 0.0f), 0);
  const auto image = render(capture, 16, 64);
  const auto x = [](double world) { return static_cast<std::uint32_t>((world + 1) * 32); };
  EXPECT_GT(red(image, x(0.6), 32), 0.3f);
  EXPECT_GT(red(image, x(-0.5), 32), 0.3f);  // the plate's top
  EXPECT_EQ(red(image, x(0.0), 32), 0.0f);   // the middle of its shadow
  EXPECT_GT(red(image, x(0.0), 8), 0.3f);    // beside it
  EXPECT_GT(red(image, x(0.32), 32), 0.3f);
  EXPECT_LT(red(image, x(0.2), 32), 0.01f);
}

TEST(ReferenceImage, BrokenVerticesLeaveTheRestAsItIs) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sun = capture::DirectionalLight{{1, 0, -1}, {3, 3, 3}, true};
  const auto material = add_emitter(capture, {1, 0, 0});
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  auto corners = rectangle(-1, -1, 1, 0, 0);
  corners.insert(corners.end(), {nan, 0, 0, 1, 1,     0,     0,      1, 0, 0, infinity, 0, 1, 1,
                                 0,   0, 1, 0, 3e38f, 3e38f, -3e38f, 1, 1, 0, -3e38f,   1, 0});
  add_triangles(capture, corners, material);
  auto& draw = add_triangles(capture, rectangle(-1, 0, 1, 1, 0), material);
  draw.transform[0] = nan;
  const auto image = render(capture, 16);
  EXPECT_NEAR(red(image, 10, 24), 1.0, 0.1);  // and a little of the sun
  EXPECT_EQ(invalid_pixels(image.linear), 0u);
  EXPECT_EQ(invalid_pixels(image.display), 0u);
}

TEST(ReferenceImage, AnEmptyFrameIsSky) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].sky = {0.5f, 0.25f, 0.125f};
  capture.frames[0].sun = capture::DirectionalLight{{1, 0, -1}, {3, 3, 3}, true};
  const auto image = render(capture, 8);
  EXPECT_EQ(red(image, 0, 0), 0.5f);
  EXPECT_EQ(red(image, kSide - 1, kSide - 1), 0.5f);
}

TEST(ReferenceImage, ToneMappingSamplesDiffersWhereBrightMeetsDark) {
  auto capture = flat_capture(kSide, kSide);
  capture.frames[0].ambient = {0, 0, 0};
  add_triangles(capture, rectangle(-1, -1, world_x(10.5), 1, 0), add_emitter(capture, {50, 50, 50}));
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, kSide, kSide);
  const auto after = render_reference(test_device(), scene, {.samples = 64});
  const auto before = render_reference(test_device(), scene, {.samples = 64, .tone_map_samples = true});
  EXPECT_EQ(after.linear.pixels, before.linear.pixels);
  const std::size_t edge = after.display.offset(10, 5), inside = after.display.offset(3, 5);
  EXPECT_NEAR(after.display.pixels[inside], before.display.pixels[inside], 1e-5);
  EXPECT_NEAR(before.display.pixels[edge], before.display.pixels[inside] / 2, 0.01);
  EXPECT_GT(after.display.pixels[edge], 0.95f);
}

TEST(ReferenceImage, ReportsEachTurnAndRefusesOddSampleCounts) {
  auto capture = flat_capture(kSide, kSide);
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, kSide, kSide);
  std::vector<std::uint32_t> seen;
  render_reference(test_device(), scene, {.samples = 16}, [&](std::uint32_t done, std::uint32_t total) {
    EXPECT_EQ(total, 4u);
    seen.push_back(done);
  });
  EXPECT_EQ(seen, (std::vector<std::uint32_t>{1, 2, 3, 4}));
  for (const std::uint32_t samples : {0u, 2u, 6u, 4100u})
    EXPECT_THROW(render_reference(test_device(), scene, {.samples = samples}), UsageError) << samples;
}

TEST(ReferenceTriangles, AreThoseThatCanBeSeen) {
  auto capture = flat_capture(kSide, kSide);
  const auto material = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), material);        // seen
  add_triangles(capture, rectangle(1.5f, -1, 3, 1, 0), material);      // right of the image
  add_triangles(capture, rectangle(-1, -1, 1, 1, 5), material);        // before the near plane
  add_triangles(capture, rectangle(1, -1, -1, 1, 0), material);        // from behind
  add_triangles(capture, {0, 0, 0, 0.5f, 0, 0, 1, 0, 0}, material);    // a line
  add_triangles(capture, rectangle(-1, -1, -1.01f, -1, 0), material);  // no height
  add_triangles(capture, {-9, -9, 0, 9, -9, 0, 0, 9, 0}, material);    // around everything
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, kSide, kSide);
  const auto list = visible_triangles(scene);
  ASSERT_EQ(list.triangles.size(), 3u);
  EXPECT_EQ(list.corners.size(), 9u);
  ASSERT_EQ(list.runs.size(), 1u);
  EXPECT_EQ(list.runs[0].count, 3u);
}

}  // namespace
}  // namespace subpixel::replay
