// Scenes of screen triangles for tests of the front-end, what the device makes of them, and exact coverage on the host.
//
// The image's sides are powers of two and the projection is the identity, so a corner at a multiple of 1/256 pixel
// reaches the device's snapping without any rounding: the snapped position is known here, not read back.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/frame/frame_setup.hpp"
#include "replay/frontend/visibility.hpp"
#include "scenes/generate/generate.hpp"
#include "shaders/frontend/frontend_types.h"
#include "shaders/frontend/sample_patterns.h"
#include "shaders/tests/test_interface.h"

namespace subpixel::replay {

// Names of all generated scenes.
inline std::vector<std::string> every_scene() {
  std::vector<std::string> names;
  for (const capture::SceneInfo& scene : capture::list_scenes()) names.emplace_back(scene.name);
  return names;
}

// A corner in 1/256 pixel from the image's top left corner.
struct GridPoint {
  std::int64_t x = 0, y = 0;
  bool operator==(const GridPoint&) const = default;
};

struct ScreenTriangle {
  GridPoint corner[3];
  float z[3] = {0.5f, 0.5f, 0.5f};  // reversed depth
};

// The same numbers from every standard library, unlike std's distributions.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : engine_(seed) {}
  std::int64_t whole(std::int64_t first, std::int64_t last) {
    return first + static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(last - first + 1));
  }
  double real(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

inline std::vector<std::byte> bytes_of_floats(const std::vector<float>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

// One two-sided draw of a triangle list; `positions` are three floats a vertex, `projection` takes them to clip space.
inline capture::Capture triangle_list_capture(const std::vector<float>& positions, const glm::dmat4& projection) {
  capture::Capture capture;
  capture.metadata.title = "screen triangles";
  capture.buffers = {{"positions", bytes_of_floats(positions)}};
  capture::Material material;
  material.name = "plain";
  material.two_sided = true;
  capture.materials = {material};
  capture::Draw draw;
  draw.name = "triangles";
  draw.position = {0, capture::VertexFormat::float32x3, 0, 12};
  draw.index_count = draw.vertex_count = static_cast<std::uint32_t>(positions.size() / 3);
  capture::Frame frame;
  for (int i = 0; i < 4; ++i) frame.view[static_cast<std::size_t>(5 * i)] = 1;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      frame.projection[static_cast<std::size_t>(4 * c + r)] = static_cast<float>(projection[c][r]);
  frame.clip_depth = capture::ClipDepth::one_to_zero;
  if (!positions.empty()) frame.draws = {draw};
  capture.frames = {frame};
  return capture;
}

// Corners straight in clip coordinates with w = 1.
inline capture::Capture screen_capture(const std::vector<ScreenTriangle>& triangles, std::uint32_t width,
                                       std::uint32_t height) {
  if (!std::has_single_bit(width) || !std::has_single_bit(height)) throw std::logic_error("sides are powers of two");
  std::vector<float> positions;
  const auto normalized = [](std::int64_t grid, std::uint32_t side) {
    const std::int64_t half = 128 * std::int64_t{side};
    return static_cast<float>(grid - half) / static_cast<float>(half);  // exact: a whole number by a power of two
  };
  for (const auto& triangle : triangles)
    for (int k = 0; k < 3; ++k) {
      positions.push_back(normalized(triangle.corner[k].x, width));
      positions.push_back(normalized(triangle.corner[k].y, height));
      positions.push_back(triangle.z[k]);
    }
  return triangle_list_capture(positions, glm::dmat4(1.0));
}

// Exact coverage and the bits of depth, written from the rules and not from the shaders.
class ExactTriangle {
 public:
  ExactTriangle() = default;
  ExactTriangle(GridPoint a, GridPoint b, GridPoint c) : corner_{a, b, c} {
    if (twice_area() < 0) std::swap(corner_[1], corner_[2]);
  }

  // Square grid units. Positive after construction; 0 for an empty triangle, which covers nothing.
  std::int64_t twice_area() const { return edge(corner_[0], corner_[1], corner_[2]); }
  const GridPoint& corner(int i) const { return corner_[i]; }

  // Top-left rule, by its meaning: a point on an edge counts as if it were moved right by an infinitesimal length and
  // down by a still smaller one. Coordinates stay below 2^23, so products stay below 2^48.
  bool covers(GridPoint p) const {
    if (twice_area() == 0) return false;
    for (int i = 0; i < 3; ++i) {
      const GridPoint &from = corner_[i], &to = corner_[(i + 1) % 3];
      const std::int64_t value = edge(from, to, p);
      if (value < 0) return false;
      if (value == 0) {
        const std::int64_t right = -(to.y - from.y), down = to.x - from.x;  // the edge function's slopes
        if (right < 0 || (right == 0 && down <= 0)) return false;
      }
    }
    return true;
  }

  // No point of the pixel's square is inside: decides whole pixels at once, with a safe margin.
  bool misses_pixel(std::int64_t px, std::int64_t py) const {
    const GridPoint centre{256 * px + 128, 256 * py + 128};
    for (int i = 0; i < 3; ++i) {
      const GridPoint &from = corner_[i], &to = corner_[(i + 1) % 3];
      const std::int64_t reach = 130 * (std::abs(to.x - from.x) + std::abs(to.y - from.y));
      if (edge(from, to, centre) < -reach) return true;
    }
    return false;
  }

  // Grid units from the nearest of the edges' segments.
  double distance_to_edges(GridPoint p) const {
    double nearest = 1e300;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec2 a(corner_[i].x, corner_[i].y), b(corner_[(i + 1) % 3].x, corner_[(i + 1) % 3].y), q(p.x, p.y);
      const glm::dvec2 along = b - a;
      const double length2 = glm::dot(along, along);
      const double t = length2 > 0 ? glm::clamp(glm::dot(q - a, along) / length2, 0.0, 1.0) : 0.0;
      nearest = std::min(nearest, glm::length(q - (a + t * along)));
    }
    return nearest;
  }

 private:
  static std::int64_t edge(const GridPoint& from, const GridPoint& to, const GridPoint& p) {
    return (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
  }
  GridPoint corner_[3];
};

inline GridPoint sample_point(std::int64_t px, std::int64_t py, std::uint32_t n, std::uint32_t sample) {
  const auto offset = gpu_types::sample_offset(n, sample);
  return {256 * px + 128 + 2 * offset.x, 256 * py + 128 + 2 * offset.y};
}

// Pixels of the viewport that a triangle can touch: [x0, x1) x [y0, y1).
struct PixelBox {
  std::int64_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
inline PixelBox pixel_box(const ExactTriangle& t, std::uint32_t width, std::uint32_t height) {
  const auto [lx, hx] = std::minmax({t.corner(0).x, t.corner(1).x, t.corner(2).x});
  const auto [ly, hy] = std::minmax({t.corner(0).y, t.corner(1).y, t.corner(2).y});
  return {std::max<std::int64_t>((lx >> 8) - 1, 0), std::max<std::int64_t>((ly >> 8) - 1, 0),
          std::min<std::int64_t>((hx >> 8) + 2, width), std::min<std::int64_t>((hy >> 8) + 2, height)};
}

// What set-up left of one triangle.
struct SetUpTriangle {
  std::uint32_t record = 0;  // its number
  std::uint32_t source = 0;  // the triangle of the draw it came from
  bool piece = false;        // of a clipped triangle
  ExactTriangle exact;
  gpu_types::TriangleRecord data{};

  // The depth plane at a sample, clamped to the triangle's range: the expression of shaders/include/coverage.glsl, each
  // product and each sum rounded.
  float depth(std::int64_t px, std::int64_t py, gpu_types::SampleOffset offset) const {
    const float centre = dx() * away_x(px) + (dy() * away_y(py) + number(data.depth.x));
    const float z =
        dx() * (static_cast<float>(offset.x) / 128.0f) + (dy() * (static_cast<float>(offset.y) / 128.0f) + centre);
    return std::min(std::max(z, number(data.depth.w)), number(data.depth2.x));
  }
  // What the rounding of its numbers, products and sums can make of it, generously.
  double depth_rounding(std::int64_t px, std::int64_t py) const {
    const double reach = std::abs(static_cast<double>(dx())) * (std::abs(static_cast<double>(away_x(px))) + 1) +
                         std::abs(static_cast<double>(dy())) * (std::abs(static_cast<double>(away_y(py))) + 1);
    return 0x1p-22 * (2 * reach + 1);
  }

 private:
  static float number(std::uint32_t bits) { return std::bit_cast<float>(bits); }
  float dx() const { return number(data.depth.y); }
  float dy() const { return number(data.depth.z); }
  float away_x(std::int64_t px) const { return static_cast<float>(px - std::int64_t{data.v2_ref.z & 0xffffu}); }
  float away_y(std::int64_t py) const { return static_cast<float>(py - std::int64_t{data.v2_ref.z >> 16}); }
};

struct VisibleSample {
  std::uint32_t depth_bits = 0, triangle = SUBPIXEL_NO_TRIANGLE;
  bool operator==(const VisibleSample&) const = default;
};

// A capture on the device at one size and sample count, after set-up and visibility.
class FrontendRun {
 public:
  FrontendRun(gpu::Device& device, capture::Capture recorded, std::uint32_t image_width, std::uint32_t image_height,
              std::uint32_t samples_per_pixel, std::optional<SmallTriangles> small = std::nullopt)
      : width(image_width),
        height(image_height),
        samples(samples_per_pixel),
        capture(std::move(recorded)),
        scene(device, capture, {}),
        frontend(device, scene),
        recorder(device) {
    parameters_.samples = samples;
    scene.set_frame(0, width, height);
    frontend.prepare(samples);
    frontend.record_setup(recorder);
    small_ = small ? *small : choose_small_triangles({frontend, width, height});
    visibility = &record_visibility(recorder, setup());
    buffer_ = gpu::Buffer(device, "samples", std::uint64_t{width} * height * samples * sizeof(VisibleSample));
    gpu::ComputePass read;
    read.name = "read";
    read.shader = "tests/read_visibility.comp";
    read.constants = {{CONSTANT_SAMPLES, samples}};
    read.bindings = {gpu::samples(FRAME_SLOT_VISIBILITY, *visibility), gpu::writes(TEST_SLOT_SAMPLES, buffer_)};
    read.groups = {(width * height + 63) / 64, 1, 1};
    recorder.compute(std::move(read));
  }

  // Lists of what shows, recorded now.
  VisibleFragments visible() {
    const FragmentListSizes sizes = measure_visible_fragments(setup());
    return {visibility, record_visible_fragments(recorder, setup(), *visibility, sizes, "list")};
  }

  FrameSetup setup() { return {{frontend, width, height, parameters_.alpha, small_}, parameters_, outputs_}; }

  // Runs all that is recorded and takes what set-up and visibility left.
  void run() {
    recorder.run();
    triangles.clear();
    // Whole triangles have the records of their own slots, in chunks; pieces of clipped ones follow.
    const std::uint64_t slots =
        (scene.triangle_count() + SUBPIXEL_CHUNK_TRIANGLES - 1) / SUBPIXEL_CHUNK_TRIANGLES * SUBPIXEL_CHUNK_TRIANGLES;
    const auto corners = frontend.hull_indices().as<std::uint32_t>();
    const auto records = frontend.records().as<gpu_types::TriangleRecord>();
    for (std::uint64_t h = 0; h < frontend.hull_triangles(); ++h) {
      SetUpTriangle t;
      t.record = corners[3 * h] / 4;
      const std::uint32_t second = corners[3 * h + 1] % 4 - 1;  // of a hull's two triangles
      if (corners[3 * h] != 4 * t.record || corners[3 * h + 1] != 4 * t.record + 1 + second ||
          corners[3 * h + 2] != 4 * t.record + 2 + second || second > 1)
        throw std::logic_error("a hull's corners are not those of one record");
      if (second == 1) {
        if (triangles.empty() || triangles.back().record != t.record)
          throw std::logic_error("a hull's second triangle does not follow its first");
        continue;
      }
      t.data = records[t.record];
      t.source = t.data.hull2_id.z / 3;
      t.piece = t.record >= slots;
      const auto grid = [](std::uint32_t x, std::uint32_t y) {
        return GridPoint{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
      };
      t.exact = {grid(t.data.v01.x, t.data.v01.y), grid(t.data.v01.z, t.data.v01.w),
                 grid(t.data.v2_ref.x, t.data.v2_ref.y)};
      triangles.push_back(t);
    }
    if (triangles.size() != frontend.hull_count())
      throw std::logic_error("hulls and screen triangles differ in number");
    std::memcpy(seen_.data(), buffer_.mapped().data(), seen_.size() * sizeof(VisibleSample));
  }

  std::span<const VisibleSample> seen() const { return seen_; }
  std::size_t place(std::int64_t px, std::int64_t py, std::uint32_t sample) const {
    return (static_cast<std::size_t>(py) * width + static_cast<std::size_t>(px)) * samples + sample;
  }

  const std::uint32_t width, height, samples;
  const capture::Capture capture;  // the scene refers to it
  GpuScene scene;
  Frontend frontend;
  gpu::PassRecorder recorder;
  gpu::Image* visibility = nullptr;
  std::vector<SetUpTriangle> triangles;  // in submission order

 private:
  CommonParameters parameters_;
  SmallTriangles small_ = SmallTriangles::as_hulls;
  FrameOutputs outputs_;
  gpu::Buffer buffer_;
  std::vector<VisibleSample> seen_ = std::vector<VisibleSample>(std::size_t{width} * height * samples);
};

}  // namespace subpixel::replay
