#include "scenes/import/assimp_lights.hpp"

#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "scenes/import/assimp_values.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

Float3 to_float3(const aiColor3D& colour, double scale) {
  const auto channel = [&](float value) {
    const double scaled = value * scale;
    return std::isfinite(scaled) ? static_cast<float>(std::clamp(scaled, 0.0, 1e9)) : 0.0f;
  };
  return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

Float3 to_float3(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::optional<glm::dvec3> unit_direction(const glm::dvec3& direction) {
  const double length = glm::length(direction);
  return length > 0 && std::isfinite(length) ? std::optional(direction / length) : std::nullopt;
}

// From assimp's colour to radiant intensity. A fall-off by the square alone is physical, and so is the brightness.
double intensity_scale(const aiLight& light, double distance_to_model) {
  const double constant = light.mAttenuationConstant, linear = light.mAttenuationLinear;
  const double square = light.mAttenuationQuadratic;
  if (constant == 0 && linear == 0 && square > 0) return 1 / square;
  const double d = std::max(distance_to_model, 1e-6);
  const double fall_off = constant + linear * d + square * d * d;
  return kPi * d * d / (fall_off > 0 ? fall_off : 1);
}

// assimp gives whole angles.
std::optional<SpotCone> cone_of(const aiLight& light, const glm::dmat4& place) {
  const std::optional<glm::dvec3> direction = unit_direction(glm::dmat3(place) * to_vec3(light.mDirection));
  if (!direction) return std::nullopt;
  SpotCone cone;
  cone.direction = to_float3(*direction);
  const double outer = std::clamp(std::max(light.mAngleOuterCone, light.mAngleInnerCone) / 2.0, 1e-3, kPi / 2);
  const double inner = std::clamp(light.mAngleInnerCone / 2.0, 0.0, outer - 1e-3);
  cone.outer_cosine = static_cast<float>(cosine(outer));
  cone.inner_cosine = static_cast<float>(cosine(inner));
  return cone.inner_cosine > cone.outer_cosine ? std::optional(cone) : std::nullopt;
}

void add_point_light(const aiLight& light, const glm::dmat4& place, Model& model) {
  const glm::dvec3 at(place * glm::dvec4(to_vec3(light.mPosition), 1));
  PointLight point;
  point.position = to_float3(at);
  point.intensity =
      to_float3(light.mColorDiffuse, intensity_scale(light, glm::length(at - (model.low + model.high) * 0.5)));
  if (light.mType == aiLightSource_SPOT) point.cone = cone_of(light, place);
  // Far enough that the window hides less than 1% of what the sun of a default scene gives.
  const float brightest = std::max({point.intensity[0], point.intensity[1], point.intensity[2], 1e-6f});
  point.range = std::sqrt(brightest / 0.03f);
  model.point_lights.push_back(point);
}

}  // namespace

void add_assimp_lights(const aiScene& scene, Model& model) {
  for (unsigned i = 0; i < scene.mNumLights; ++i) {
    const aiLight& light = *scene.mLights[i];
    const glm::dmat4 place = place_of(scene.mRootNode->FindNode(light.mName));
    if (light.mType == aiLightSource_DIRECTIONAL) {
      const std::optional<glm::dvec3> direction = unit_direction(glm::dmat3(place) * to_vec3(light.mDirection));
      if (direction) model.sun = DirectionalLight{to_float3(*direction), to_float3(light.mColorDiffuse, kPi), true};
    } else if (light.mType == aiLightSource_POINT || light.mType == aiLightSource_SPOT) {
      add_point_light(light, place, model);
    } else {
      model.notices.push_back("ignored: light " + to_utf8(light.mName.C_Str()) +
                              ", which is neither directional nor a point nor a spot");
    }
  }
}

void add_assimp_camera(const aiScene& scene, Model& model) {
  if (scene.mNumCameras == 0) return;
  const aiCamera& camera = *scene.mCameras[0];
  const glm::dmat4 place = place_of(scene.mRootNode->FindNode(camera.mName));
  const glm::dvec3 eye(place * glm::dvec4(to_vec3(camera.mPosition), 1));
  const glm::dvec3 ahead = glm::dmat3(place) * to_vec3(camera.mLookAt);
  const glm::dvec3 up = glm::dmat3(place) * to_vec3(camera.mUp);
  const glm::dvec3 across = glm::cross(ahead, up);
  if (!unit_direction(across) || !unit_direction(ahead)) return;
  ModelCamera found;
  found.world[0] = glm::dvec4(*unit_direction(across), 0);
  found.world[1] = glm::dvec4(*unit_direction(glm::cross(across, ahead)), 0);
  found.world[2] = glm::dvec4(-*unit_direction(ahead), 0);
  found.world[3] = glm::dvec4(eye, 1);
  // The whole horizontal angle, in spite of assimp's documentation.
  const double aspect = camera.mAspect > 0 ? camera.mAspect : 1.0;
  const double vertical = 2 * std::atan(std::tan(static_cast<double>(camera.mHorizontalFOV) / 2) / aspect);
  found.vertical_fov_degrees = std::clamp(vertical * 180 / kPi, 5.0, 120.0);
  if (!std::isfinite(glm::length(eye)) || !std::isfinite(found.vertical_fov_degrees)) return;
  model.camera = found;
}

}  // namespace subpixel::capture
