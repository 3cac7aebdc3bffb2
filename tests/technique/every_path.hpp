// One frame by the reference and by every technique, for tests that know what is to be seen.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/reference/reference.hpp"
#include "replay/reference/turns.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {

struct PathImage {
  std::string name;
  // Of the reference, whose pixels are means over these; others are as their centre is.
  std::vector<gpu_types::TurnConstants> turns;
  std::vector<glm::vec3> radiance;  // linear, rows top to bottom
  bool reference() const { return !turns.empty(); }
};

// Shaded at each sample, so that it is known where, whatever triangles there are in a pixel.
inline constexpr ReferenceOptions kAllShaded{.samples = 64, .shade_all_samples = true};

inline PathImage reference_path(const capture::Capture& capture, std::uint32_t width, std::uint32_t height,
                                const ReferenceOptions& options = kAllShaded) {
  GpuScene scene(test_device(), capture, {});
  scene.set_frame(0, width, height);
  const Image linear = render_reference(test_device(), scene, options).linear;
  PathImage path{"reference", turn_constants(options.samples / 4, 2, width, height), {}};
  for (std::size_t i = 0; i < linear.pixels.size(); i += 3)
    path.radiance.emplace_back(linear.pixels[i], linear.pixels[i + 1], linear.pixels[i + 2]);
  return path;
}

inline PathImage technique_path(const capture::Capture& capture, std::string_view technique, std::uint32_t width,
                                std::uint32_t height, ParameterValues given = {}) {
  // A filter of finished images would move what tests look for.
  if (technique == "fxaa") given["least_contrast"] = 1;
  if (technique == "smaa") given["threshold"] = 1;
  if (technique == "taa") given.insert({{"history", 0}, {"jitter", 1}});
  PathImage path{std::string(technique) + " " + nlohmann::json(given).dump(), {}, {}};
  for (const glm::vec4& pixel : run_technique(capture, technique, given, width, height).radiance)
    path.radiance.emplace_back(pixel);
  return path;
}

// All of them with their default parameters; the reference first.
inline std::vector<PathImage> every_path(const capture::Capture& capture, std::uint32_t width, std::uint32_t height,
                                         const ReferenceOptions& options = kAllShaded) {
  std::vector<PathImage> paths{reference_path(capture, width, height, options)};
  for (const Technique* technique : techniques())
    paths.push_back(technique_path(capture, technique->name, width, height));
  return paths;
}

// What is to be seen at a point of the image, pixels; none where a test has nothing to say.
using ExpectedAt = std::function<std::optional<glm::dvec3>(double x, double y)>;

// Compares pixels whose nine points at and around the centre, a pixel apart, all have an expectation. `tolerance` of
// the techniques, and of the reference against the mean of the points it shades.
inline void expect_image(const PathImage& path, std::uint32_t width, const ExpectedAt& expected, double tolerance,
                         double reference_tolerance) {
  std::size_t wrong = 0, compared = 0;
  for (std::size_t i = 0; i < path.radiance.size(); ++i) {
    const double x = static_cast<double>(i % width) + 0.5, y = static_cast<double>(i / width) + 0.5;
    bool known = true;
    for (int k = 0; k < 9 && known; ++k) known = expected(x + k % 3 - 1, y + k / 3 - 1).has_value();
    if (!known) continue;
    ++compared;
    glm::dvec3 sought = expected(x, y).value();
    if (path.reference()) {
      glm::dvec3 sum(0);
      double count = 0;
      for (std::uint32_t k = 0; k < 4 * path.turns.size(); ++k) {
        const glm::dvec2 place = glm::dvec2(sample_place(path.turns[k / 4], k % 4));
        if (const auto here = expected(x - 0.5 + place.x, y - 0.5 + place.y)) {
          sum += *here;
          ++count;
        }
      }
      if (count == 0) continue;
      sought = sum / count;
    }
    const glm::dvec3 off = glm::abs(glm::dvec3(path.radiance[i]) - sought);
    const double most = std::max({off.x, off.y, off.z});
    if (most <= (path.reference() ? reference_tolerance : tolerance)) continue;
    if (++wrong == 1)
      ADD_FAILURE() << path.name << ", pixel " << x << " " << y << ": " << path.radiance[i].x << " "
                    << path.radiance[i].y << " " << path.radiance[i].z << " instead of " << sought.x << " " << sought.y
                    << " " << sought.z;
  }
  EXPECT_EQ(wrong, 0u) << path.name << ", of " << compared << " pixels";
  EXPECT_GT(compared, 0u) << path.name;
}

// The two show the same: no pixel differs by more than `tolerance`, and few do at all, since a sample beside the edge
// of an alpha test may fall to the other side.
inline void expect_same_image(const PathImage& a, const PathImage& b, double tolerance, std::size_t most_others = 0) {
  ASSERT_EQ(a.radiance.size(), b.radiance.size());
  std::size_t others = 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.radiance.size(); ++i) {
    const glm::vec3 off = glm::abs(a.radiance[i] - b.radiance[i]);
    const double most = std::max({off.x, off.y, off.z});
    worst = std::max(worst, most);
    others += most <= tolerance ? 0 : 1;
  }
  EXPECT_LE(others, most_others) << a.name << ", up to " << worst;
}

}  // namespace subpixel::replay
