// What the words of an aggregate keep, and how shading one compares with shading each of its surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <random>

#include "replay/gpu/pass_recorder.hpp"
#include "replay/scene/gpu_scene.hpp"
#include "shaders/techniques/agaa/agaa_interface.h"
#include "shaders/tests/agaa_test_interface.h"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

using gpu_types::AgaaTestResult;
using gpu_types::AgaaTestSurface;

constexpr glm::vec3 kLight{0.36f, 0.48f, 0.8f};  // unit, towards the sun
constexpr std::uint32_t kAllFeatures = FEATURE_SUN | FEATURE_METAL | FEATURE_VARYING_ROUGHNESS | FEATURE_EMISSIVE;

const glm::vec4 kLit{0, 0, 0, 1};  // no emission, and all light arrives

struct Sets {
  std::uint32_t samples = 8;
  std::vector<AgaaTestSurface> surfaces;
  std::vector<glm::vec4> views;
  float light_distance = 0;  // of a point light towards kLight instead of the sun, where not 0
};

std::vector<AgaaTestResult> run_on_device(const Sets& sets, std::uint32_t options, bool blinn_phong = false,
                                          std::uint32_t features = kAllFeatures, float largest_emission = 1) {
  capture::Capture capture = flat_capture(16, 16);
  capture.frames[0].ambient = {0, 0, 0};
  capture.frames[0].sun = capture::DirectionalLight{{-kLight.x, -kLight.y, -kLight.z}, {1, 1, 1}, false};
  if (sets.light_distance > 0) {
    capture.frames[0].sun.reset();
    const glm::vec3 at = sets.light_distance * kLight;
    capture.frames[0].point_lights.push_back({{at.x, at.y, at.z}, {1, 1, 1}, 100});
  }
  capture.materials.emplace_back();
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), 0);
  gpu::Device& device = test_device();
  GpuScene scene(device, capture, {});
  scene.set_frame(0, 16, 16);
  gpu::PassRecorder recorder(device);
  gpu::Buffer& surfaces = recorder.buffer("surfaces", sets.surfaces.size() * sizeof(AgaaTestSurface));
  gpu::Buffer& views = recorder.buffer("views", sets.views.size() * sizeof(glm::vec4));
  gpu::Buffer& out = recorder.buffer("results", sets.views.size() * sizeof(AgaaTestResult));
  std::copy(sets.surfaces.begin(), sets.surfaces.end(), surfaces.as<AgaaTestSurface>().begin());
  std::copy(sets.views.begin(), sets.views.end(), views.as<glm::vec4>().begin());
  gpu::ComputePass pass;
  pass.name = "aggregate";
  pass.shader = "tests/agaa_aggregate.comp";
  pass.constants = {{CONSTANT_SAMPLES, sets.samples},
                    {CONSTANT_FEATURES, features},
                    {CONSTANT_SHADING_MODEL, blinn_phong ? SHADING_MODEL_BLINN_PHONG : SHADING_MODEL_GGX},
                    {AGAA_CONSTANT_OPTIONS, options},
                    {AGAA_CONSTANT_SHADOW_TAPS, 1}};
  pass.bindings = {gpu::uniform(scene.frame_constants),
                   gpu::reads(AGAA_TEST_SLOT_SURFACES, surfaces),
                   gpu::reads(AGAA_TEST_SLOT_VIEWS, views),
                   gpu::writes(AGAA_TEST_SLOT_RESULTS, out),
                   gpu::reads(FRAME_SLOT_SPOT_CONES, scene.spot_cones),
                   gpu::reads(FRAME_SLOT_LIGHT_CELLS, scene.light_cells),
                   gpu::samples(FRAME_SLOT_SHADOW_MAP, scene.shadow_map, &scene.shadow_sampler)};
  const gpu_types::AgaaTestPush push{static_cast<std::uint32_t>(sets.views.size()), largest_emission};
  pass.push = gpu::PushConstants(push);
  pass.groups = {(push.count + 63) / 64, 1, 1};
  recorder.compute(pass);
  recorder.run();
  const auto results = out.as<AgaaTestResult>();
  return {results.begin(), results.begin() + sets.views.size()};
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double normal() { return std::sqrt(-2 * std::log(1 - unit())) * std::cos(6.283185307179586 * unit()); }
  glm::dvec3 direction() {
    const double z = 2 * unit() - 1, turn = 6.283185307179586 * unit(), r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }

 private:
  std::mt19937_64 engine_;
};

// Normals around a mean with the given spreads (radians) along two tangents, all of which `view` sees from the front.
Sets random_sets(std::uint32_t count, std::uint32_t samples, double largest_spread, bool anisotropic, double metallic,
                 double lowest_roughness, std::uint64_t seed) {
  Random random(seed);
  Sets sets;
  sets.samples = samples;
  while (sets.views.size() < count) {
    // Sets that the sun reaches, most of them near their highlight: a lit mean, a view near the mirrored sun.
    const glm::dvec3 mean = glm::normalize(glm::dvec3(kLight) + 0.9 * random.direction());
    glm::dvec3 view = 2 * glm::dot(mean, glm::dvec3(kLight)) * mean - glm::dvec3(kLight);
    view = glm::normalize(view + random.between(0, 0.7) * random.direction());
    if (glm::dot(mean, view) < 0.1) continue;
    const glm::dvec3 tangent = glm::normalize(glm::cross(mean, random.direction()));
    const glm::dvec3 bitangent = glm::cross(mean, tangent);
    const double along = random.between(0, largest_spread), across = anisotropic ? 0.05 * along : along;
    const auto roughness = static_cast<float>(random.between(lowest_roughness, 0.9));
    const glm::vec3 albedo(random.unit(), random.unit(), random.unit());
    std::vector<AgaaTestSurface> set;
    for (int tries = 0; set.size() < samples && tries < 1000; ++tries) {
      const glm::dvec3 n =
          glm::normalize(mean + tangent * (along * random.normal()) + bitangent * (across * random.normal()));
      if (glm::dot(n, view) > 0.02)
        set.push_back({glm::vec4(glm::vec3(n), roughness), glm::vec4(albedo, metallic), kLit, glm::vec4(0)});
    }
    if (set.size() < samples) continue;
    sets.surfaces.insert(sets.surfaces.end(), set.begin(), set.end());
    sets.views.emplace_back(glm::vec3(view), 0);
  }
  return sets;
}

// Errors of green relative to what the sets send on average, and the sum's error: filters must not make or lose light.
struct Errors {
  double median = 0, nine_tenths = 0, ninety_nine = 0, root_mean_square = 0, bias = 0;
};

template <typename Value>
Errors errors_of(const std::vector<AgaaTestResult>& results, Value value) {
  double sum = 0, difference = 0, squares = 0;
  for (const auto& r : results) sum += static_cast<double>(r.brute.g);
  const double mean = sum / static_cast<double>(results.size());
  std::vector<double> errors;
  for (const auto& r : results) {
    const double d = static_cast<double>(value(r) - r.brute.g);
    difference += d;
    squares += d * d;
    errors.push_back(std::abs(d) / mean);
  }
  std::ranges::sort(errors);
  const auto at = [&](double part) {
    return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size() - 1))];
  };
  return {at(0.5), at(0.9), at(0.99), std::sqrt(squares / static_cast<double>(results.size())) / mean,
          difference / sum};
}

struct Comparison {
  Errors filtered, plain;
};

Comparison compare(const std::string& name, const Sets& sets, std::uint32_t options, bool blinn_phong = false) {
  const auto results = run_on_device(sets, options, blinn_phong);
  for (const auto& r : results) {
    EXPECT_TRUE(std::isfinite(r.filtered.g) && r.filtered.g >= 0);
  }
  const Comparison c{errors_of(results, [](const auto& r) { return r.filtered.g; }),
                     errors_of(results, [](const auto& r) { return r.plain.g; })};
  const auto print = [&](const char* what, const Errors& e) {
    std::printf("%-32s %-8s median %.3f  90%% %.3f  99%% %.3f  rms %.3f  bias %+.3f\n", name.c_str(), what, e.median,
                e.nine_tenths, e.ninety_nine, e.root_mean_square, e.bias);
  };
  print("filtered", c.filtered);
  print("mean", c.plain);
  return c;
}

// Bounds are somewhat above what was measured; what matters is how far they are from shading the mean normal.
void expect_filtered(const Comparison& c, double median, double nine_tenths, double bias) {
  EXPECT_LT(c.filtered.median, median);
  EXPECT_LT(c.filtered.nine_tenths, nine_tenths);
  EXPECT_LT(std::abs(c.filtered.bias), bias);
  EXPECT_LT(c.filtered.median, 0.7 * c.plain.median);
  EXPECT_LT(c.filtered.root_mean_square, 0.6 * c.plain.root_mean_square);
}

TEST(AgaaShading, IsCloseToShadingEverySurfaceOfIsotropicSets) {
  const Sets dielectric = random_sets(5000, 8, 0.5, false, 0, 0.2, 1),
             metal = random_sets(5000, 8, 0.5, false, 1, 0.2, 2);
  for (const std::uint32_t ndf : {0u, AGAA_SGGX, AGAA_LEAN}) {
    const std::string name = ndf == 0 ? "isotropic toksvig " : ndf == AGAA_SGGX ? "isotropic sggx " : "isotropic lean ";
    const Comparison d = compare(name + "dielectric", dielectric, AGAA_FLOAT | ndf);
    const Comparison m = compare(name + "metal", metal, AGAA_FLOAT | ndf);
    expect_filtered(d, 0.03, 0.18, 0.03);
    expect_filtered(m, 0.09, 0.8, 0.06);
  }
}

TEST(AgaaShading, IsCloseToShadingEverySurfaceOfAnisotropicSets) {
  const Sets dielectric = random_sets(5000, 8, 0.5, true, 0, 0.2, 3),
             metal = random_sets(5000, 8, 0.5, true, 1, 0.2, 4);
  const Comparison d[] = {compare("anisotropic toksvig dielectric", dielectric, AGAA_FLOAT),
                          compare("anisotropic sggx dielectric", dielectric, AGAA_FLOAT | AGAA_SGGX),
                          compare("anisotropic lean dielectric", dielectric, AGAA_FLOAT | AGAA_LEAN)};
  const Comparison m[] = {compare("anisotropic toksvig metal", metal, AGAA_FLOAT),
                          compare("anisotropic sggx metal", metal, AGAA_FLOAT | AGAA_SGGX),
                          compare("anisotropic lean metal", metal, AGAA_FLOAT | AGAA_LEAN)};
  expect_filtered(d[0], 0.03, 0.18, 0.03);
  expect_filtered(d[1], 0.02, 0.15, 0.03);
  expect_filtered(m[0], 0.06, 0.8, 0.12);
  expect_filtered(m[1], 0.04, 0.5, 0.06);
  expect_filtered(d[2], 0.02, 0.15, 0.03);
  expect_filtered(m[2], 0.04, 0.5, 0.06);
  // What second moments are kept for.
  for (const auto& c : {d, m})
    for (const int anisotropic : {1, 2}) {
      EXPECT_LT(c[anisotropic].filtered.median, c[0].filtered.median);
      EXPECT_LT(c[anisotropic].filtered.root_mean_square, c[0].filtered.root_mean_square);
    }
}

TEST(AgaaShading, FiltersBlinnPhong) {
  for (const bool anisotropic : {false, true}) {
    const Sets sets = random_sets(3000, 8, 0.5, anisotropic, 0, 0.2, 5);
    for (const std::uint32_t ndf : {0u, AGAA_SGGX, AGAA_LEAN})
      expect_filtered(
          compare(anisotropic ? "blinn-phong anisotropic" : "blinn-phong isotropic", sets, AGAA_FLOAT | ndf, true),
          0.05, 0.16, 0.06);
  }
}

TEST(AgaaShading, OneNormalIsLitAsASurface) {
  for (const std::uint32_t ndf : {0u, AGAA_SGGX, AGAA_LEAN})
    for (const bool blinn_phong : {false, true}) {
      const Sets sets = random_sets(2000, 4, 0, false, 0.5, 0.1, 6);
      const auto results = run_on_device(sets, AGAA_FLOAT | AGAA_LIGHT_VARIANCE | ndf, blinn_phong);
      for (std::size_t i = 0; i < results.size(); ++i) {
        // Slopes end at 76 degrees from the eye.
        const glm::vec3 normal(sets.surfaces[i * sets.samples].normal_roughness);
        if (ndf == AGAA_LEAN && glm::dot(normal, glm::vec3(sets.views[i])) < 0.25f) continue;
        ASSERT_NEAR(results[i].filtered.g, results[i].brute.g, 4e-3f * (1 + results[i].brute.g));
      }
    }
}

TEST(AgaaShading, ColoursTimesTheirShadowAreExactForOneNormal) {
  // Each surface has a colour and a shadow of its own, red ones the light and blue ones the shadow: light is linear in
  // colours times shadows, and colour and shadow averaged apart are not.
  Sets sets = random_sets(2000, 8, 0, false, 0, 0.2, 7);
  Random random(8);
  for (auto& s : sets.surfaces) {
    const auto lit = static_cast<float>(random.unit());
    s.albedo_metallic = {lit, random.unit(), 1 - lit, 0};
    s.emission = {0, 0, 0, lit};
  }
  constexpr std::uint32_t kFeatures = FEATURE_SUN | FEATURE_SHADOWS | FEATURE_METAL | FEATURE_VARYING_ROUGHNESS;
  double worst = 0, apart = 0;
  for (const auto& r : run_on_device(sets, AGAA_FLOAT | AGAA_LIT, false, kFeatures))
    for (int c = 0; c < 3; ++c)
      worst = std::max(
          worst, std::abs(static_cast<double>(r.filtered[c] - r.brute[c])) / (1e-2 + static_cast<double>(r.brute[c])));
  for (const auto& r : run_on_device(sets, AGAA_FLOAT, false, kFeatures))
    for (int c = 0; c < 3; ++c)
      apart = std::max(
          apart, std::abs(static_cast<double>(r.filtered[c] - r.brute[c])) / (1e-2 + static_cast<double>(r.brute[c])));
  std::printf("one normal, colours times shadows: worst error %.4f; apart %.4f\n", worst, apart);
  EXPECT_LT(worst, 0.1);
  EXPECT_GT(apart, 0.4);
}

TEST(AgaaShading, TheSpreadOfALightsDirectionsWidensTheNormals) {
  // One normal in places along a line, which a near light reaches from different directions.
  for (const std::uint32_t ndf : {0u, AGAA_SGGX, AGAA_LEAN}) {
    Sets sets = random_sets(4000, 8, 0, false, 0, 0.2, 9);
    sets.light_distance = 3;
    Random random(10);
    for (std::size_t i = 0; i < sets.views.size(); ++i) {
      const glm::dvec3 line = glm::normalize(glm::cross(glm::dvec3(kLight), random.direction()));
      const double reach = random.between(0, 1.2);
      for (std::size_t k = 0; k < sets.samples; ++k)
        sets.surfaces[i * sets.samples + k].position =
            glm::vec4(glm::vec3(line * (reach * (static_cast<double>(k) / 3.5 - 1))), 0);
    }
    constexpr std::uint32_t kFeatures = FEATURE_POINT_LIGHTS | FEATURE_METAL | FEATURE_VARYING_ROUGHNESS;
    const auto value = [](const auto& r) { return r.filtered.g; };
    const Errors mean = errors_of(run_on_device(sets, AGAA_FLOAT | ndf, false, kFeatures), value);
    const Errors spread =
        errors_of(run_on_device(sets, AGAA_FLOAT | AGAA_LIGHT_VARIANCE | ndf, false, kFeatures), value);
    std::printf("light directions, ndf %u: mean median %.3f rms %.3f bias %+.3f; spread %.3f %.3f %+.3f\n", ndf,
                mean.median, mean.root_mean_square, mean.bias, spread.median, spread.root_mean_square, spread.bias);
    EXPECT_LT(spread.root_mean_square, 0.8 * mean.root_mean_square);
    EXPECT_LT(std::abs(spread.bias), 0.5 * std::abs(mean.bias));
  }
}

// Random surfaces without any relation.
Sets random_surfaces(std::uint32_t count, std::uint32_t samples, std::uint64_t seed, float largest_emission) {
  Random random(seed);
  Sets sets;
  sets.samples = samples;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t k = 0; k < samples; ++k) {
      const auto value = [&] {
        return static_cast<float>(random.unit() < 0.1 ? std::round(random.unit()) : random.unit());
      };
      sets.surfaces.push_back(
          {glm::vec4(glm::vec3(random.direction()), value()), glm::vec4(value(), value(), value(), value()),
           glm::vec4(largest_emission * glm::vec3(value(), value(), value()), value()), glm::vec4(0)});
    }
    sets.views.emplace_back(glm::vec3(random.direction()), 0);
  }
  return sets;
}

// Mean attributes in doubles.
struct Means {
  glm::dvec3 normal{0}, diffuse{0}, reflectance{0}, emission{0}, moments{0}, mixed{0}, lit_diffuse{0},
      lit_reflectance{0};
  glm::dvec2 slope{0};  // on tangents of our own choice
  glm::dmat2 slope_moments{0};
  double roughness = 0;
};

Means means_of(const Sets& sets, std::size_t index) {
  Means m;
  for (std::size_t k = 0; k < sets.samples; ++k) {
    const AgaaTestSurface& s = sets.surfaces[index * sets.samples + k];
    const glm::dvec3 n(s.normal_roughness), albedo(s.albedo_metallic);
    const double metallic = s.albedo_metallic.w;
    m.normal += n;
    m.moments += n * n;
    m.mixed += glm::dvec3(n.x * n.y, n.x * n.z, n.y * n.z);
    m.diffuse += albedo * (1 - metallic);
    m.reflectance += glm::mix(glm::dvec3(0.04), albedo, metallic);
    m.emission += glm::dvec3(s.emission);
    m.lit_diffuse += albedo * ((1 - metallic) * static_cast<double>(s.emission.w));
    m.lit_reflectance += glm::mix(glm::dvec3(0.04), albedo, metallic) * static_cast<double>(s.emission.w);
    // Olano and Baker 2010, section 3: slopes and their second moments, of at most 76 degrees here.
    const glm::dvec3 eye = glm::normalize(glm::dvec3(sets.views[index]));
    const glm::dvec3 t = glm::normalize(glm::cross(eye, glm::dvec3(0.3, -0.8, 0.5))), b = glm::cross(eye, t);
    const glm::dvec2 across(glm::dot(n, t), glm::dot(n, b));
    const double along = std::max(glm::dot(n, eye), glm::length(across) / 4);
    const glm::dvec2 slope = across / along;
    m.slope += slope;
    m.slope_moments += glm::outerProduct(slope, slope);
    m.roughness += static_cast<double>(s.normal_roughness.w);
  }
  const double n = sets.samples;
  for (glm::dvec3* v :
       {&m.normal, &m.diffuse, &m.reflectance, &m.emission, &m.moments, &m.mixed, &m.lit_diffuse, &m.lit_reflectance})
    *v /= n;
  m.slope /= n;
  m.slope_moments /= n;
  m.roughness /= n;
  return m;
}

double largest(const glm::vec4& got, const glm::dvec3& expected) {
  const glm::dvec3 d = glm::abs(glm::dvec3(got) - expected);
  return std::max({d.x, d.y, d.z});
}

TEST(AgaaAggregate, KeepsTheMeansOfItsSurfacesToTheRoundingOfItsFields) {
  for (const std::uint32_t samples : {4u, 8u, 16u, 32u})
    for (const std::uint32_t storage : {0u, AGAA_FLOAT}) {
      constexpr float kEmission = 50;
      const Sets sets = random_surfaces(2000, samples, samples, kEmission);
      const auto results = run_on_device(sets, storage | AGAA_SGGX, false, kAllFeatures, kEmission);
      // A sum of n fragments, each rounded by up to a unit; the chroma of a colour comes back through factors
      // below 1.9.
      const auto unit = [&](int bits) {
        return storage ? 1e-6 : samples / std::floor((std::exp2(bits) - 1 - samples) / (2 * samples)) / (2 * samples);
      };
      double worst[6] = {}, bias = 0;
      for (std::size_t i = 0; i < results.size(); ++i) {
        const Means m = means_of(sets, i);
        const AgaaTestResult& r = results[i];
        ASSERT_EQ(std::bit_cast<std::uint32_t>(r.diffuse_mask.w), samples == 32 ? ~0u : (1u << samples) - 1);
        const double errors[6] = {
            largest(r.normal_roughness, m.normal) / (2 * unit(16)),
            largest(r.diffuse_mask, m.diffuse) / unit(10),
            largest(r.reflectance, m.reflectance) / (2.4 * unit(8)),
            std::abs(static_cast<double>(r.normal_roughness.w) - m.roughness) / unit(8),
            largest(r.emission, m.emission) / (kEmission * unit(22)),
            std::max(largest(r.moments, m.moments), largest(r.mixed_moments, m.mixed)) / (2 * unit(16))};
        for (std::size_t k = 0; k < 6; ++k) worst[k] = std::max(worst[k], errors[k]);
        bias += static_cast<double>(r.diffuse_mask.y) - m.diffuse.y;
      }
      for (std::size_t k = 0; k < 6; ++k)
        EXPECT_LT(worst[k], 1.0) << "attribute " << k << ", " << samples << " samples";
      // Rounding of many fragments is not to one side.
      EXPECT_LT(std::abs(bias / static_cast<double>(results.size())), 0.1 * unit(10));
    }
}

TEST(AgaaAggregate, KeepsMomentsOfSlopesAndColoursTimesTheirShadow) {
  for (const std::uint32_t samples : {4u, 8u, 32u})
    for (const std::uint32_t storage : {0u, AGAA_FLOAT}) {
      const Sets sets = random_surfaces(2000, samples, samples, 1);
      const auto results = run_on_device(sets, storage | AGAA_LEAN | AGAA_LIT);
      const auto unit = [&](int bits) {
        return storage ? 1e-5 : samples / std::floor((std::exp2(bits) - 1 - samples) / (2 * samples)) / (2 * samples);
      };
      double worst[4] = {};
      for (std::size_t i = 0; i < results.size(); ++i) {
        const Means m = means_of(sets, i);
        const AgaaTestResult& r = results[i];
        // What does not depend on the choice of tangents.
        const glm::dvec2 slope(r.slopes);
        const glm::dmat2 moments(r.slope_moments.x, r.slope_moments.y, r.slope_moments.y, r.slope_moments.z);
        const auto trace = [](const glm::dmat2& of) { return of[0][0] + of[1][1]; };
        const double first = std::abs(glm::length(slope) - glm::length(m.slope));
        const double second =
            std::max(std::abs(trace(moments) - trace(m.slope_moments)),
                     std::abs(trace(moments * moments) - trace(m.slope_moments * m.slope_moments)) / 64);
        const double both = std::abs(glm::dot(slope, moments * slope) - glm::dot(m.slope, m.slope_moments * m.slope));
        const double errors[4] = {first / (12 * unit(16)), std::max(second / (64 * unit(22)), both / (1000 * unit(16))),
                                  largest(r.lit_diffuse, m.lit_diffuse) / unit(10),
                                  largest(r.lit_reflectance, m.lit_reflectance) / (2.4 * unit(8))};
        for (std::size_t k = 0; k < 4; ++k) worst[k] = std::max(worst[k], errors[k]);
      }
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_LT(worst[k], 1.0) << "attribute " << k << ", " << samples << " samples, storage " << storage;
    }
}

TEST(AgaaAggregate, FieldsDoNotCarry) {
  // Every field at its largest in every sample, and again at its least.
  for (const std::uint32_t samples : {4u, 8u, 16u, 32u})
    for (const float value : {0.0f, 1.0f}) {
      Sets sets;
      sets.samples = samples;
      sets.surfaces.assign(
          samples, {glm::vec4(0, 0, 1, value), glm::vec4(value, value, value, value), glm::vec4(value), glm::vec4(0)});
      sets.views.assign(1, glm::vec4(0, 0, 1, 0));
      const AgaaTestResult r = run_on_device(sets, AGAA_SGGX)[0];
      EXPECT_NEAR(r.normal_roughness.x, 0, 1e-6f);
      EXPECT_NEAR(r.normal_roughness.z, 1, 1e-6f);
      EXPECT_NEAR(r.normal_roughness.w, value, 1e-6f);
      EXPECT_NEAR(r.diffuse_mask.x, 0, 1e-6f);
      EXPECT_NEAR(r.reflectance.x, value > 0 ? 1 : 0.04f, 1e-3f);
      EXPECT_NEAR(r.emission.x, value, 1e-6f);
      EXPECT_NEAR(r.moments.z, 1, 1e-6f);
      EXPECT_NEAR(r.mixed_moments.x, 0, 1e-6f);
      const AgaaTestResult lean = run_on_device(sets, AGAA_LEAN | AGAA_LIT)[0];
      EXPECT_NEAR(lean.normal_roughness.z, 1, 1e-6f);
      EXPECT_NEAR(lean.slopes.x, 0, 1e-6f);
      EXPECT_NEAR(lean.slope_moments.x, 0, 1e-6f);
      EXPECT_NEAR(lean.slope_moments.y, 0, 1e-6f);
      EXPECT_NEAR(lean.lit_reflectance.x, value, 1e-3f);
    }
}

TEST(AgaaAggregate, NumericalCases) {
  // Normals that cancel, of mirrors and of the roughest; normals along every axis; nothing may leave the range of
  // colours.
  const glm::vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  Sets sets;
  sets.samples = 4;
  for (const float roughness : {0.0f, 1.0f})
    for (const std::vector<glm::vec3>& normals :
         {std::vector{z, -z, z, -z}, std::vector{x, -x, y, -y}, std::vector{-z, -z, -z, -z}, std::vector{z, z, z, z},
          std::vector{z, z, z, -z}, std::vector{glm::vec3(0), z, z, z}}) {
      for (const glm::vec3& n : normals)
        sets.surfaces.push_back({glm::vec4(n, roughness), glm::vec4(1, 1, 1, 1), kLit, glm::vec4(0)});
      sets.views.emplace_back(0, 0, 1, 0);
    }
  for (std::uint32_t options = 0; options < 2 * AGAA_LIT; ++options)
    for (const bool blinn_phong : {false, true})
      if ((options & (AGAA_SGGX | AGAA_LEAN)) != (AGAA_SGGX | AGAA_LEAN) && (options & AGAA_DISTANCE_ALONG_VIEW) == 0)
        for (const auto& r : run_on_device(sets, options, blinn_phong))
          for (int c = 0; c < 3; ++c) {
            ASSERT_TRUE(std::isfinite(r.filtered[c]) && r.filtered[c] >= 0 && r.filtered[c] <= 60000) << options;
            ASSERT_TRUE(std::isfinite(r.normal_roughness[c]));
          }
}

}  // namespace
}  // namespace subpixel::replay
