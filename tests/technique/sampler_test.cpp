// Wrap modes, filters and mip modes of every path's texture reads, against a sampler written here from the Vulkan
// specification (1.3, chapter "Image Operations") in doubles.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "replay/scene/textures.hpp"
#include "tests/technique/every_path.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kTexels = 8;  // along a texture's side
constexpr std::uint32_t kCell = 24;   // pixels along a quadrilateral's side
constexpr std::uint32_t kCells = 6;   // along the image's side
constexpr std::uint32_t kSide = kCell * kCells;

// One texture and how it is read.
struct Read {
  capture::Sampler sampler;
  double lod = 0;                // of the whole quadrilateral
  glm::dvec2 first{0}, step{0};  // uv at its top left, and per pixel
  std::vector<std::vector<std::array<std::uint8_t, 4>>> levels;
};

int wrapped(int i, int size, capture::Wrap wrap) {
  switch (wrap) {
    case capture::Wrap::repeat:
      return (i % size + size) % size;
    case capture::Wrap::clamp_to_edge:
      return std::clamp(i, 0, size - 1);
    case capture::Wrap::mirrored_repeat: {
      const int twice = (i % (2 * size) + 2 * size) % (2 * size);
      return twice < size ? twice : 2 * size - 1 - twice;
    }
  }
  return 0;
}

class Oracle {
 public:
  explicit Oracle(const Read& read) : read_(read) {}

  // At a pixel position relative to the quadrilateral's corner. None where a nearest texel is a matter of rounding.
  std::optional<glm::dvec3> at(double x, double y) const {
    const glm::dvec2 uv = read_.first + read_.step * glm::dvec2(x, y);
    const bool magnified = read_.lod <= 0;
    const bool nearest = (magnified ? read_.sampler.magnify : read_.sampler.minify) == capture::TexelFilter::nearest;
    const double last =
        read_.sampler.mip == capture::MipFilter::none ? 0 : static_cast<double>(read_.levels.size() - 1);
    double lod = std::clamp(read_.lod, 0.0, last);
    if (read_.sampler.mip == capture::MipFilter::nearest || read_.sampler.mip == capture::MipFilter::nearest_of_means)
      lod = std::ceil(lod + 0.5) - 1;
    const auto fine = static_cast<std::size_t>(lod);
    const std::size_t coarse = std::min(fine + 1, static_cast<std::size_t>(last));
    const auto a = filtered(fine, uv, nearest), b = filtered(coarse, uv, nearest);
    const double part = lod - static_cast<double>(fine);
    if (!a || (part > 0 && !b)) return std::nullopt;
    return part > 0 ? glm::mix(*a, *b, part) : *a;
  }

 private:
  glm::dvec3 texel(std::size_t level, int x, int y) const {
    const int size = static_cast<int>(kTexels >> level);
    const int row = wrapped(y, size, read_.sampler.wrap_v), column = wrapped(x, size, read_.sampler.wrap_u);
    const auto& t = read_.levels[level][static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                                        static_cast<std::size_t>(column)];
    return glm::dvec3(t[0], t[1], t[2]) / 255.0;
  }

  std::optional<glm::dvec3> filtered(std::size_t level, const glm::dvec2& uv, bool nearest) const {
    const glm::dvec2 at = uv * static_cast<double>(kTexels >> level);
    if (nearest) {
      const glm::dvec2 part = at - glm::floor(at);
      if (std::min({part.x, part.y, 1 - part.x, 1 - part.y}) < 1e-3) return std::nullopt;
      return texel(level, static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
    }
    const glm::dvec2 corner = glm::floor(at - 0.5), f = at - 0.5 - corner;
    const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
    return glm::mix(glm::mix(texel(level, x, y), texel(level, x + 1, y), f.x),
                    glm::mix(texel(level, x, y + 1), texel(level, x + 1, y + 1), f.x), f.y);
  }

  const Read& read_;
};

// All pairs of wrap modes, and with them filters and mip modes, near and far.
std::vector<Read> reads() {
  std::vector<Read> all;
  std::mt19937 random(3);
  // Between the switches at 0 and 1/2, and beyond the last level that a nearest one may round to.
  const double lods[] = {-2, 0.3, -0.7, 0.7, 1.2, -2};
  for (std::uint32_t i = 0; i < kCells * kCells; ++i) {
    Read read;
    read.sampler.wrap_u = static_cast<capture::Wrap>(i % 3);
    read.sampler.wrap_v = static_cast<capture::Wrap>(i / 3 % 3);
    read.sampler.magnify = static_cast<capture::TexelFilter>(i / 2 % 2);
    read.sampler.minify = static_cast<capture::TexelFilter>(i / 4 % 2);
    read.sampler.mip = static_cast<capture::MipFilter>(i / 9 % 5);
    read.lod = lods[(i + i / 6) % std::size(lods)];
    const double step = std::exp2(read.lod) / kTexels;
    read.step = {step, step};
    // So that the image's border, twice where it is mirrored, lies in the quadrilateral's middle.
    read.first = glm::dvec2(i % 2, i / 2 % 2) - step * (kCell / 2.0 + 0.137);
    auto& finest = read.levels.emplace_back(kTexels * kTexels);
    for (auto& texel : finest)
      texel = {static_cast<std::uint8_t>(random() % 256), static_cast<std::uint8_t>(random() % 256),
               static_cast<std::uint8_t>(random() % 256), 255};
    for (std::uint32_t size = kTexels / 2; size > 0; size /= 2) {
      const auto finer = read.levels.back();
      auto& level = read.levels.emplace_back(std::size_t{size} * size);
      for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x)
          for (std::size_t c = 0; c < 4; ++c) {
            const auto of = [&](std::uint32_t dx, std::uint32_t dy) {
              return static_cast<int>(finer[std::size_t{2 * y + dy} * 2 * size + 2 * x + dx][c]);
            };
            level[std::size_t{y} * size + x][c] =
                static_cast<std::uint8_t>((of(0, 0) + of(1, 0) + of(0, 1) + of(1, 1) + 2) / 4);
          }
    }
    all.push_back(read);
  }
  return all;
}

capture::Capture capture_of(const std::vector<Read>& all) {
  auto capture = flat_capture(kSide, kSide);
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    capture::Material material;
    material.unlit = true;
    std::vector<std::uint8_t> texels;
    for (const auto& texel : all[i].levels[0]) texels.insert(texels.end(), texel.begin(), texel.end());
    material.base_colour_texture = add_texture(capture, kTexels, kTexels, texels, false);
    capture.textures.back().sampler = all[i].sampler;
    capture.materials.push_back(material);
    // A triangle twice the cell, whose other half later cells cover: no diagonal lies in what is looked at.
    const auto place = [](double pixel) { return static_cast<float>(2 * pixel / kSide - 1); };
    const std::uint32_t column = i % kCells, row = i / kCells;
    const double left = column * kCell, top = row * kCell;
    const float z = static_cast<float>(i) / static_cast<float>(all.size());
    auto& draw = add_triangles(
        capture,
        {place(left), -place(top), z, place(left), -place(top + 2 * kCell), z, place(left + 2 * kCell), -place(top), z},
        i);
    const glm::dvec2 a = all[i].first, b = a + all[i].step * (2.0 * kCell);
    const std::vector<double> uvs{a.x, a.y, a.x, b.y, b.x, a.y};
    draw.uv = {add_buffer(capture, std::vector<float>(uvs.begin(), uvs.end())), capture::VertexFormat::float32x2, 0, 8};
  }
  return capture;
}

TEST(SceneSamplers, EveryPathReadsTexturesByTheirSamplers) {
  const auto all = reads();
  const capture::Capture capture = capture_of(all);
  // Techniques read by the driver's filter, whose levels Mesa 22.3 weighs more coarsely.
  const double tolerance = test_device().info().driver_version.starts_with("Mesa 22.") ? 0.04 : 0.01;
  for (const PathImage& path : every_path(capture, kSide, kSide)) {
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "read " << i);
      const Oracle oracle(all[i]);
      const glm::dvec2 corner(i % kCells * kCell, i / kCells * kCell);
      expect_image(
          path, kSide,
          [&](double x, double y) -> std::optional<glm::dvec3> {
            const glm::dvec2 at = glm::dvec2(x, y) - corner;
            if (at.x < 0 || at.y < 0 || at.x >= kCell || at.y >= kCell) return std::nullopt;
            return oracle.at(at.x, at.y);
          },
          tolerance, 0.04);
    }
  }
}

// Without mipmaps level 0 is all there is, on the device and in the reference's table.
TEST(SceneSamplers, ATextureWithoutMipmapsHasOneLevel) {
  auto capture = flat_capture(8, 8);
  add_texture(capture, 4, 4, std::vector<std::uint8_t>(64, 100), false);
  EXPECT_EQ(load_texture(capture, {0}).levels.size(), 3u);
  capture.textures[0].sampler.mip = capture::MipFilter::none;
  EXPECT_EQ(load_texture(capture, {0}).levels.size(), 1u);
}

// Far outside, and where a transform leads nowhere: colours of the texture, and finite.
TEST(SceneSamplers, CoordinatesOfAnySizeGiveFiniteColours) {
  auto capture = flat_capture(32, 32);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const std::array<std::array<float, 6>, 4> matrices{
      {{1, 0, 0, 0, 1, 0}, {1e6f, 0, 1e6f, 0, -1e6f, 0}, {nan, 0, 0, 0, infinity, 0}, {0, 0, 0, 0, 0, 0}}};
  for (std::uint32_t i = 0; i < 12; ++i) {
    capture::Material material;
    material.unlit = true;
    material.base_colour_texture = add_texture(capture, 2, 1, {255, 255, 255, 255, 128, 128, 128, 255}, false);
    auto& sampler = capture.textures.back().sampler;
    sampler.wrap_u = sampler.wrap_v = static_cast<capture::Wrap>(i % 3);
    sampler.magnify = static_cast<capture::TexelFilter>(i % 2);
    material.base_colour_uv.matrix = matrices[i / 3];
    capture.materials.push_back(material);
    const auto column = i % 4, row = i / 4;
    const float x = static_cast<float>(column) * 0.5f - 1, y = static_cast<float>(row) * 0.66f - 1;
    auto& draw = add_triangles(capture, rectangle(x, y, x + 0.5f, y + 0.66f, 0), i);
    draw.uv = {add_buffer(capture, std::vector<float>{-9e5f, 3, 9e5f, -7e5f, 1e30f, nan, 0, 1, 1, -1e9f, 5e5f, 0}),
               capture::VertexFormat::float32x2, 0, 8};
  }
  const ExpectedAt anything = [](double x, double y) -> std::optional<glm::dvec3> {
    if (x < 0 || y < 1 || x > 32 || y > 32) return std::nullopt;
    return glm::dvec3(0.75);
  };
  for (const PathImage& path : every_path(capture, 32, 32)) expect_image(path, 32, anything, 0.26, 0.26);
}

}  // namespace
}  // namespace subpixel::replay
