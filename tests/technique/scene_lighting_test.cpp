// shade() on the device against the same equations written anew in doubles, over ordinary and extreme surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "replay/gpu/pass_recorder.hpp"
#include "replay/scene/gpu_scene.hpp"
#include "shaders/tests/test_interface.h"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Probe {
  glm::vec4 position_roughness{0, 0, 0, 0.5f}, normal_metallic{0, 0, 1, 0}, albedo_occlusion{0.5f, 0.5f, 0.5f, 1},
      emissive{0}, view{0, 0, 1, 0};
};

enum class Model : std::uint32_t { ggx = SHADING_MODEL_GGX, blinn_phong = SHADING_MODEL_BLINN_PHONG };

// Sun, two point lights, a spot light and an ambient term; no shadows.
capture::Capture lit_capture() {
  auto capture = flat_capture(16, 16);
  auto& frame = capture.frames[0];
  frame.ambient = {0.2f, 0.3f, 0.4f};
  frame.sun = capture::DirectionalLight{{-0.3f, -0.2f, -0.9f}, {2, 2.5f, 3}, false};
  frame.point_lights = {{{1, 2, 3}, {5, 4, 3}, 8}, {{-2, 0, 1}, {1, 2, 6}, 4}, {{2, -1, 0}, {3, 5, 2}, 9}};
  frame.point_lights[2].cone = capture::SpotCone{{-1, 0.5f, 0.25f}, 0.8f, -0.3f};
  capture::Material material;  // needs every part of shade()
  material.emissive = {1, 1, 1};
  material.metallic = 0.5f;
  capture.materials.push_back(material);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), 0);
  return capture;
}

std::vector<glm::vec4> shade_on_device(const capture::Capture& capture, const std::vector<Probe>& probes, Model model) {
  auto& device = test_device();
  GpuScene scene(device, capture, {});
  scene.set_frame(0, 16, 16);
  gpu::PassRecorder recorder(device);
  gpu::Buffer& in = recorder.buffer("probes", probes.size() * sizeof(Probe));
  gpu::Buffer& out = recorder.buffer("radiances", probes.size() * sizeof(glm::vec4));
  std::copy(probes.begin(), probes.end(), in.as<Probe>().begin());
  gpu::ComputePass pass;
  pass.name = "probe";
  pass.shader = "tests/shade_probe.comp";
  pass.constants = {{CONSTANT_FEATURES, scene.features().bits},
                    {CONSTANT_SHADING_MODEL, static_cast<std::uint32_t>(model)}};
  pass.bindings = {gpu::uniform(scene.frame_constants),
                   gpu::reads(TEST_SLOT_PROBES, in),
                   gpu::writes(TEST_SLOT_RADIANCES, out),
                   gpu::reads(FRAME_SLOT_SPOT_CONES, scene.spot_cones),
                   gpu::reads(FRAME_SLOT_LIGHT_CELLS, scene.light_cells),
                   gpu::samples(FRAME_SLOT_SHADOW_MAP, scene.shadow_map, &scene.shadow_sampler)};
  const auto count = static_cast<std::uint32_t>(probes.size());
  pass.push = gpu::PushConstants(gpu_types::ProbeTestPush{count});
  pass.groups = {(count + 63) / 64, 1, 1};
  recorder.compute(pass);
  recorder.run();
  const auto values = out.as<glm::vec4>();
  return {values.begin(), values.begin() + count};
}

// The lighting equation in its textbook form: explicit half vector, one term after the other.
class Textbook {
 public:
  Textbook(const Probe& probe, Model model)
      : model_(model),
        n_(glm::normalize(glm::dvec3(probe.normal_metallic))),
        v_(glm::dvec3(probe.view)),
        albedo_(probe.albedo_occlusion),
        metallic_(probe.normal_metallic.w),
        roughness_(std::clamp<double>(probe.position_roughness.w, 0.089, 1.0)),
        normal_view_(std::clamp(glm::dot(n_, v_), 1e-3, 1.0)),
        diffuse_(albedo_ * (1 - metallic_)),
        f0_(glm::mix(glm::dvec3(0.04), albedo_, metallic_)) {}

  glm::dvec3 reflected(const glm::dvec3& light) const {
    const double normal_light = std::max(0.0, glm::dot(n_, light));
    const glm::dvec3 half = glm::normalize(light + v_);
    const double normal_half = glm::clamp(glm::dot(n_, half), 0.0, 1.0);
    const double alpha = roughness_ * roughness_, a2 = alpha * alpha;
    if (model_ == Model::blinn_phong) {
      const double exponent = 2 / a2 - 2;
      return (diffuse_ / kPi + f0_ * ((exponent + 8) / (8 * kPi) * std::pow(normal_half, exponent))) * normal_light;
    }
    const double d_term = normal_half * normal_half * (a2 - 1) + 1;
    const double distribution = a2 / (kPi * d_term * d_term);
    const double visibility = 0.5 / (normal_light * std::sqrt(normal_view_ * normal_view_ * (1 - a2) + a2) +
                                     normal_view_ * std::sqrt(normal_light * normal_light * (1 - a2) + a2));
    const glm::dvec3 fresnel = f0_ + (1.0 - f0_) * std::pow(1 - std::clamp(glm::dot(v_, half), 0.0, 1.0), 5);
    return (diffuse_ / kPi * (1.0 - fresnel) + fresnel * (distribution * visibility)) * normal_light;
  }

  glm::dvec3 ambient() const {
    const glm::dvec4 r = roughness_ * glm::dvec4(-1, -0.0275, -0.572, 0.022) + glm::dvec4(1, 0.0425, 1.04, -0.04);
    const double a004 = std::min(r.x * r.x, std::exp2(-9.28 * normal_view_)) * r.x + r.y;
    const glm::dvec3 specular = glm::clamp(f0_ * (-1.04 * a004 + r.z) + (1.04 * a004 + r.w), 0.0, 1.0);
    return diffuse_ * (1.0 - specular) + specular;
  }

 private:
  Model model_;
  glm::dvec3 n_, v_, albedo_;
  double metallic_, roughness_, normal_view_;
  glm::dvec3 diffuse_, f0_;
};

glm::dvec3 expected_radiance(const capture::Frame& frame, const Probe& probe, Model model) {
  const auto vec = [](const capture::Float3& v) { return glm::dvec3(v[0], v[1], v[2]); };
  const Textbook brdf(probe, model);
  glm::dvec3 radiance =
      vec(frame.ambient) * brdf.ambient() * static_cast<double>(probe.albedo_occlusion.w) + glm::dvec3(probe.emissive);
  radiance += vec(frame.sun->irradiance) * brdf.reflected(-glm::normalize(vec(frame.sun->direction)));
  for (const auto& light : frame.point_lights) {
    const glm::dvec3 to_light = vec(light.position) - glm::dvec3(probe.position_roughness);
    const double distance = glm::length(to_light), range = light.range;
    const double window = std::max(0.0, 1 - std::pow(distance / range, 4));
    const double nearest = std::max(distance, 0.01 * range);
    double cone = 1;
    if (light.cone) {
      const double cosine = -glm::dot(to_light / distance, glm::normalize(vec(light.cone->direction)));
      const double inner = light.cone->inner_cosine, outer = light.cone->outer_cosine;
      cone = std::pow(std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0), 2);
    }
    radiance +=
        vec(light.intensity) * (cone * window * window / (nearest * nearest)) * brdf.reflected(to_light / distance);
  }
  return radiance;
}

std::vector<Probe> random_probes(std::uint32_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0, 1), signed_unit(-1, 1);
  const auto direction = [&] {
    glm::vec3 v;
    do v = {signed_unit(random), signed_unit(random), signed_unit(random)};
    while (glm::dot(v, v) > 1 || glm::dot(v, v) < 0.01f);
    return glm::normalize(v);
  };
  std::vector<Probe> probes(count);
  for (auto& probe : probes) {
    probe.position_roughness = {3 * signed_unit(random), 3 * signed_unit(random), 3 * signed_unit(random),
                                unit(random)};
    probe.normal_metallic = glm::vec4(direction(), unit(random) < 0.3f ? 1.0f : unit(random));
    probe.albedo_occlusion = {unit(random), unit(random), unit(random), unit(random)};
    probe.emissive = {unit(random), 0, 2 * unit(random), 0};
    probe.view = glm::vec4(direction(), 0);
  }
  return probes;
}

class SceneLighting : public testing::TestWithParam<Model> {};

TEST_P(SceneLighting, EqualsTheEquationInDoubles) {
  const auto capture = lit_capture();
  const auto probes = random_probes(20000);
  const auto found = shade_on_device(capture, probes, GetParam());
  double worst = 0;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const glm::dvec3 expected = expected_radiance(capture.frames[0], probes[i], GetParam());
    for (int c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(found[i][c] - expected[c]) / (0.05 + std::abs(expected[c])));
  }
  // Highlights of the smoothest surfaces lose digits where 1 - (n.h)^2 cancels in float.
  EXPECT_LT(worst, 0.02);
}

TEST_P(SceneLighting, IsFiniteAndNotNegativeForEveryFiniteSurface) {
  const float values[] = {0.0f,
                          -0.0f,
                          1e-30f,
                          1e-6f,
                          0.5f,
                          1.0f,
                          -1.0f,
                          3.0f,
                          1e10f,
                          -1e10f,
                          1e30f,
                          std::numeric_limits<float>::max(),
                          -std::numeric_limits<float>::max(),
                          std::numeric_limits<float>::denorm_min()};
  std::mt19937 random(11);
  auto probes = random_probes(40000);
  const auto wild = [&] { return values[random() % std::size(values)]; };
  for (auto& probe : probes) {
    // One to all of the inputs are replaced by something extreme; the view direction stays unit, as passes make it.
    for (glm::vec4* vector :
         {&probe.position_roughness, &probe.normal_metallic, &probe.albedo_occlusion, &probe.emissive})
      for (int c = 0; c < 4; ++c)
        if (random() % 3 == 0) (*vector)[c] = wild();
    if (random() % 4 == 0) probe.view = -probe.normal_metallic;
    const float length = glm::length(glm::vec3(probe.view));
    probe.view = length > 1e-3f && length < 1e3f ? probe.view / length : glm::vec4(0, 0, 1, 0);
  }
  const auto found = shade_on_device(lit_capture(), probes, GetParam());
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      ASSERT_TRUE(std::isfinite(found[i][c])) << "probe " << i;
      ASSERT_GE(found[i][c], 0.0f) << "probe " << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Models, SceneLighting, testing::Values(Model::ggx, Model::blinn_phong),
                         [](const auto& tested) { return tested.param == Model::ggx ? "ggx" : "blinn_phong"; });

TEST(SceneLightingEnergy, NoSurfaceReflectsMoreThanItGets) {
  // Under a uniform environment the ambient term must not exceed it; a sun of irradiance pi on a facing diffuse surface
  // returns about its albedo; integrated over all light directions the lobe stays at or below 1.
  const int kSteps = 64;
  for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f})
    for (const float cosine : {1.0f, 0.5f, 0.1f}) {
      Probe probe;
      probe.position_roughness.w = roughness;
      probe.normal_metallic.w = 1;
      probe.albedo_occlusion = {1, 1, 1, 1};
      probe.view = {std::sqrt(1 - cosine * cosine), 0, cosine, 0};
      const Textbook brdf(probe, Model::ggx);
      EXPECT_LE(brdf.ambient().x, 1.0 + 1e-9);
      if (roughness < 0.3f) continue;  // too narrow for these steps
      double sum = 0;
      for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < 4 * kSteps; ++j) {
          const double z = (i + 0.5) / kSteps, phi = 2 * kPi * (j + 0.5) / (4 * kSteps), r = std::sqrt(1 - z * z);
          sum += brdf.reflected({r * std::cos(phi), r * std::sin(phi), z}).x;
        }
      sum *= 2 * kPi / (4.0 * kSteps * kSteps);
      EXPECT_LE(sum, 1.02) << "roughness " << roughness << ", cosine " << cosine;
      EXPECT_GE(sum, 0.3);
    }
}

TEST(SceneLightingTone, RisesSmoothlyFromBlackToWhite) {
  auto capture = lit_capture();
  capture.frames[0].sun.reset();
  capture.frames[0].point_lights.clear();
  capture.frames[0].ambient = {0, 0, 0};
  std::vector<Probe> probes(2000);
  for (std::size_t i = 0; i < probes.size(); ++i) probes[i].emissive.g = static_cast<float>(std::pow(1.012, i) * 1e-6);
  const auto found = shade_on_device(capture, probes, Model::ggx);
  EXPECT_LT(found.front().w, 0.001f);
  EXPECT_GT(found.back().w, 0.995f);
  for (std::size_t i = 1; i < found.size(); ++i) {
    ASSERT_GE(found[i].w, found[i - 1].w);
    ASSERT_LT(found[i].w - found[i - 1].w, 0.01f);
  }
}

}  // namespace
}  // namespace subpixel::replay
