// What the front-end sees at each sample against rays through the same samples: a third judge, after exact arithmetic
// and the driver's rasteriser, which knows neither snapping nor edge functions nor depth planes.
//
// Embree in its robust mode (watertight: Woop, Benthin, Wald 2013) gets the triangles in view space, placed in double
// and rounded once to float. Its float numbers move a ray against a triangle by some 2^-23 of their distance. A pixel
// of an image 160 wide under a usual lens is 2^-7 of the distance, so that is 2^-16 pixels: nothing beside the
// front-end's own snapping of corners to 1/256 pixel, which may move an edge by 0.71 of that grid's units.
//
// So the two may differ where the sample lies within one unit (two where clipping made corners) of an edge of one of
// the two triangles, or where their depths are as near as shifting the planes by so much makes them: these are ties,
// counted and bounded. Elsewhere they may not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include "replay/scene/camera.hpp"
#include "scenes/generate/generate.hpp"
#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/scene_device_fixture.hpp"

#ifdef SUBPIXEL_EMBREE
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#endif

namespace subpixel::replay {
namespace {

#ifndef SUBPIXEL_EMBREE

TEST(Rays, NeedEmbree) {
  GTEST_SKIP() << "built without Embree (Debian: libembree-dev)";
}

#else

constexpr double kUnit_px = 1.0 / SUBPIXEL_SNAP;

// A triangle as captured, in homogeneous pixels (x w, y w, w) and with its clip-space z.
struct JudgedTriangle {
  std::uint32_t source = 0, instance = 0;
  bool two_sided = false;
  double winding = 1;  // of the corners against the viewer: negative where mirrored
  glm::dvec3 pixel[3];
  double z[3] = {0, 0, 0};

  // How far what the front-end makes of it may lie from it, in pixels.
  double reach() const {
    for (int k = 0; k < 3; ++k) {
      const double w = pixel[k].z;
      const bool inside = z[k] >= 0 && z[k] <= w && std::abs(pixel[k].x) < SUBPIXEL_GUARD_BAND_PX * w &&
                          std::abs(pixel[k].y) < SUBPIXEL_GUARD_BAND_PX * w;
      if (!inside) return 2 * kUnit_px;
    }
    return kUnit_px;
  }

  // From the nearest edge, in pixels; from its whole line where a corner is behind the eye.
  double edge_distance(const glm::dvec2& p) const {
    double nearest = 1e300;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 &a = pixel[k], &b = pixel[(k + 1) % 3];
      if (a.z > 0 && b.z > 0) {
        const glm::dvec2 from = glm::dvec2(a) / a.z, along = glm::dvec2(b) / b.z - from;
        const double length2 = glm::dot(along, along);
        const double t = length2 > 0 ? glm::clamp(glm::dot(p - from, along) / length2, 0.0, 1.0) : 0.0;
        nearest = std::min(nearest, glm::length(p - (from + t * along)));
      } else {
        const glm::dvec3 line = glm::cross(a, b);
        nearest = std::min(nearest, std::abs(glm::dot(line, glm::dvec3(p, 1))) / glm::length(glm::dvec2(line)));
      }
    }
    return nearest;
  }

  // Reversed depth at a place of the image, and by how much a shift by reach() and the rounding of floats may change
  // it.
  struct Depth {
    bool inside = false;  // the place is in the triangle
    double at = 0, slack = 0;
  };
  Depth depth(const glm::dvec2& p) const {
    const glm::dmat3 corner_weights = glm::inverse(glm::dmat3(pixel[0], pixel[1], pixel[2]));
    const glm::dvec3 weight = corner_weights * glm::dvec3(p, 1);
    const glm::dvec3 plane = glm::dvec3(z[0], z[1], z[2]) * corner_weights;  // z / w = plane . (x, y, 1)
    double away = 0;  // pixels over which the plane is followed from where it is anchored
    for (const glm::dvec3& corner : pixel)
      away = std::max(away, corner.z > 0 ? glm::length(glm::dvec2(corner) / corner.z - p) : 1e300);
    const double slope = std::abs(plane.x) + std::abs(plane.y), at = glm::dot(plane, glm::dvec3(p, 1));
    const double rounding = 0x1p-22 * (std::abs(at) + slope * std::min(away, 1.0 * SUBPIXEL_GUARD_BAND_PX));
    return {glm::min(weight.x, glm::min(weight.y, weight.z)) >= 0, at, slope * reach() + rounding};
  }
};

bool same_depth(const JudgedTriangle::Depth& a, const JudgedTriangle::Depth& b) {
  return a.inside && b.inside && std::abs(a.at - b.at) <= a.slack + b.slack;
}

// Why the two judges may differ at a place, where one sees `ours` and the other `theirs`, null for nothing.
enum class Tie { none, edge, depth };
Tie tie_at(const JudgedTriangle* ours, const JudgedTriangle* theirs, const glm::dvec2& p) {
  for (const JudgedTriangle* t : {ours, theirs})
    if (t != nullptr && t->edge_distance(p) <= t->reach()) return Tie::edge;
  if (ours != nullptr && theirs != nullptr && same_depth(ours->depth(p), theirs->depth(p))) return Tie::depth;
  for (const JudgedTriangle* t : {ours, theirs})  // the near and the far plane
    if (t != nullptr && (same_depth(t->depth(p), {true, 0, 0}) || same_depth(t->depth(p), {true, 1, 0})))
      return Tie::depth;
  return Tie::none;
}

// The scene's current frame for Embree, in view space.
class RayScene {
 public:
  RayScene(const GpuScene& scene, std::uint32_t width, std::uint32_t height) : width_(width), height_(height) {
    const Camera camera = camera_of(scene.capture().frames[0], 0);
    const glm::dmat4 projection = camera.view_projection * glm::inverse(camera.view);
    to_view_ = glm::inverse(projection);
    const auto positions = scene.positions.as<float>();
    const auto indices = scene.indices.as<std::uint32_t>();
    const auto instances = scene.instances.as<gpu_types::InstanceRecord>();
    std::vector<glm::vec3> corners;
    for (const DrawItem& draw : scene.draws())
      for (std::uint32_t i = draw.first_instance; i < draw.first_instance + draw.instance_count; ++i) {
        glm::dmat4 world(1);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 4; ++c) world[c][r] = static_cast<double>(instances[i].world_row[r][c]);
        const glm::dmat4 view = camera.view * world;
        for (std::uint32_t t = 0; t < draw.triangle_count; ++t) {
          JudgedTriangle triangle{draw.first_index / 3 + t, i, scene.two_sided(draw.material), 0, {}, {}};
          // From a right-handed view space to Vulkan's clip space the determinant is negative.
          triangle.winding = glm::determinant(view) * glm::determinant(projection) < 0 ? 1 : -1;
          bool finite = true;
          glm::vec3 corner[3];
          for (std::uint32_t k = 0; k < 3; ++k) {
            const std::size_t v = 3 * std::size_t{indices[draw.first_index + 3 * t + k]};
            const glm::dvec4 at = view * glm::dvec4(positions[v], positions[v + 1], positions[v + 2], 1);
            const glm::dvec4 clip = projection * at;
            triangle.pixel[k] = {(clip.x + clip.w) / 2 * width, (clip.y + clip.w) / 2 * height, clip.w};
            triangle.z[k] = clip.z;
            corner[k] = glm::vec3(at);
            for (int c = 0; c < 4; ++c) finite = finite && std::abs(clip[c]) <= 1e18;  // Embree's own limit
          }
          if (!finite) continue;
          corners.insert(corners.end(), corner, corner + 3);
          triangles_.push_back(triangle);
        }
      }
    device_ = rtcNewDevice("threads=1");
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    if (!triangles_.empty()) add_geometry(corners);
    rtcCommitScene(scene_);
    if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE)
      throw std::runtime_error(fmt::format("Embree reports error {}", static_cast<int>(error)));
  }
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;
  ~RayScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  // The nearest triangle between the near and the far plane at a place of the image, null for none.
  const JudgedTriangle* hit(const glm::dvec2& pixel) const {
    const glm::dvec2 place(2 * pixel.x / width_ - 1, 2 * pixel.y / height_ - 1);
    const glm::dvec4 front = to_view_ * glm::dvec4(place, 1, 1), back = to_view_ * glm::dvec4(place, 0, 1);
    const glm::dvec3 from = glm::dvec3(front) / front.w;
    const glm::dvec3 along = glm::dvec3(back) - from * back.w;  // the far plane may be at infinity
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(from.x);
    ray.ray.org_y = static_cast<float>(from.y);
    ray.ray.org_z = static_cast<float>(from.z);
    const glm::vec3 direction(glm::normalize(along));
    ray.ray.dir_x = direction.x;
    ray.ray.dir_y = direction.y;
    ray.ray.dir_z = direction.z;
    ray.ray.tfar = back.w > 1e-12 * front.w ? static_cast<float>(glm::length(along) / back.w)
                                            : std::numeric_limits<float>::infinity();
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene_, &ray, nullptr);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &ray);
#endif
    return ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? nullptr : &triangles_[ray.hit.primID];
  }

  std::span<const JudgedTriangle> triangles() const {
    return triangles_;
  }

 private:
  void add_geometry(const std::vector<glm::vec3>& corners) {
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), corners.size()));
    std::copy(corners.begin(), corners.end(), vertices);
    auto* numbers = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles_.size()));
    for (std::uint32_t v = 0; v < corners.size(); ++v) numbers[v] = v;
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryIntersectFilterFunction(geometry, leave_out_back_faces);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  static void leave_out_back_faces(const RTCFilterFunctionNArguments* arguments) {
    const auto& self = *static_cast<const RayScene*>(arguments->geometryUserPtr);
    const RTCRay ray = rtcGetRayFromRayN(arguments->ray, 1, 0);
    const RTCHit hit = rtcGetHitFromHitN(arguments->hit, 1, 0);
    const JudgedTriangle& triangle = self.triangles_[hit.primID];
    const float facing = hit.Ng_x * ray.dir_x + hit.Ng_y * ray.dir_y + hit.Ng_z * ray.dir_z;
    if (!triangle.two_sided && static_cast<double>(facing) * triangle.winding >= 0) arguments->valid[0] = 0;
  }

  double width_, height_;
  glm::dmat4 to_view_;
  std::vector<JudgedTriangle> triangles_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

struct Verdict {
  std::uint64_t samples = 0, hits = 0;
  std::uint64_t edge_ties = 0, depth_ties = 0, wrong = 0;  // differences
  std::uint64_t holes = 0;                                 // of them, hits where the front-end sees nothing
  std::string first_wrong;
};

// Alpha is read by the techniques' tests: here every triangle is all there.
capture::Capture opaque(capture::Capture capture) {
  for (auto& material : capture.materials) material.alpha_mode = capture::AlphaMode::opaque;
  return capture;
}

Verdict judge(capture::Capture recorded, std::uint32_t width, std::uint32_t height, std::uint32_t samples) {
  FrontendRun run(test_device(), opaque(std::move(recorded)), width, height, samples);
  run.run();
  const RayScene rays(run.scene, width, height);
  std::map<std::pair<std::uint32_t, std::uint32_t>, const JudgedTriangle*> by_source;
  for (const JudgedTriangle& t : rays.triangles()) by_source[{t.source, t.instance}] = &t;
  std::map<std::uint32_t, const JudgedTriangle*> by_record;
  for (const SetUpTriangle& t : run.triangles) by_record[t.record] = by_source.at({t.source, t.data.hull2_id.w});

  Verdict verdict;
  for (std::int64_t py = 0; py < height; ++py)
    for (std::int64_t px = 0; px < width; ++px)
      for (std::uint32_t s = 0; s < samples; ++s) {
        const GridPoint grid = sample_point(px, py, samples, s);
        const glm::dvec2 p = glm::dvec2(grid.x, grid.y) * kUnit_px;
        const std::uint32_t record = run.seen()[run.place(px, py, s)].triangle;
        const JudgedTriangle* ours = record == SUBPIXEL_NO_TRIANGLE ? nullptr : by_record.at(record);
        const JudgedTriangle* theirs = rays.hit(p);
        ++verdict.samples;
        verdict.hits += theirs != nullptr ? 1 : 0;
        if (ours == theirs) continue;
        verdict.holes += ours == nullptr ? 1 : 0;
        const Tie tie = tie_at(ours, theirs, p);
        ++(tie == Tie::edge ? verdict.edge_ties : tie == Tie::depth ? verdict.depth_ties : verdict.wrong);
        if (tie == Tie::none && verdict.first_wrong.empty())
          verdict.first_wrong = fmt::format("pixel {}, {}, sample {}: ours {}, Embree's {}", px, py, s,
                                            ours != nullptr ? fmt::to_string(ours->source) : "none",
                                            theirs != nullptr ? fmt::to_string(theirs->source) : "none");
      }
  return verdict;
}

class RaysThroughScene : public testing::TestWithParam<std::string> {};

TEST_P(RaysThroughScene, HitWhatTheFrontEndSees) {
  if (GetParam() == "hard_grazing")
    GTEST_SKIP() << "walls that reach from 2 to 2,000,000 units: in floats Embree's edges move by pixels";
  const capture::SceneInfo scene = capture::find_scene(GetParam());
  const bool hard = scene.group == capture::SceneGroup::hard;
  const std::uint32_t width = hard ? 64 : 160, height = hard ? 48 : 90;
  const Verdict verdict = judge(capture::generate(GetParam(), {1, width, height, 1, 0.3}), width, height, 8);
  fmt::print("| `{}` | {} | {} | {} | {} | {} |\n", GetParam(), verdict.samples, verdict.hits, verdict.edge_ties,
             verdict.depth_ties, verdict.wrong);
  EXPECT_EQ(verdict.wrong, 0u) << verdict.first_wrong;
  // Where nearly all is edge, a few in a hundred are near one.
  const bool thin = GetParam() == "agaa_hairs" || GetParam() == "hard_slivers" || GetParam() == "streaming_depth";
  EXPECT_LE(verdict.edge_ties * (thin ? 14 : 50), verdict.hits);
  // Where surfaces lie in each other the order of submission decides, which rays know nothing of.
  if (GetParam() != "hard_coplanar") {
    EXPECT_LE(verdict.depth_ties * 100, verdict.hits);
  }
  EXPECT_EQ(verdict.hits == 0, GetParam() == "empty");
}

INSTANTIATE_TEST_SUITE_P(All, RaysThroughScene, testing::ValuesIn(every_scene()),
                         [](const auto& scene) { return scene.param; });

// A wall over the whole image whose corners lie on sample positions, so that edges run through samples and fans meet in
// them. Both sides are exact here, and neither may leave a hole: of the front-end, that is its top-left rule.
TEST(Rays, FindNoHoleWhereEdgesRunThroughSamples) {
  constexpr std::uint32_t kSide = 64, kSamples = 8;
  constexpr std::int64_t kCell = 512, kCells = 256 * kSide / kCell + 2;  // grid units; the wall begins before the image
  Numbers numbers(20);
  std::vector<GridPoint> corners;
  for (std::int64_t y = 0; y <= kCells; ++y)
    for (std::int64_t x = 0; x <= kCells; ++x) {
      const auto sample = static_cast<std::uint32_t>(numbers.whole(0, kSamples - 1));
      corners.push_back(sample_point(2 * (x - 1), 2 * (y - 1), kSamples, sample));
    }
  std::vector<ScreenTriangle> wall;
  for (std::int64_t y = 0; y < kCells; ++y)
    for (std::int64_t x = 0; x < kCells; ++x) {
      const auto at = [&](std::int64_t i, std::int64_t j) {
        return corners[static_cast<std::size_t>((y + j) * (kCells + 1) + x + i)];
      };
      wall.push_back({{at(0, 0), at(1, 0), at(1, 1)}});
      wall.push_back({{at(0, 0), at(1, 1), at(0, 1)}});
    }
  const Verdict verdict = judge(screen_capture(wall, kSide, kSide), kSide, kSide, kSamples);
  fmt::print("{} samples, {} hit, {} ties\n", verdict.samples, verdict.hits, verdict.edge_ties);
  EXPECT_EQ(verdict.hits, verdict.samples);
  EXPECT_EQ(verdict.holes, 0u);
  EXPECT_EQ(verdict.wrong, 0u);
  EXPECT_GT(verdict.edge_ties, 100u) << "no edge ran through a sample";
}

#endif

}  // namespace
}  // namespace subpixel::replay
