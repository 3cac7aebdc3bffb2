// A scene put together from model files by a JSON document (docs/scenes.md gives its fields): what it says, checked.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

using Rectangle = std::array<double, 4>;  // x from, z from, x to, z to; metres

struct GroundMaterial {
  enum class Pattern { plain, noise, bricks } pattern = Pattern::plain;
  glm::dvec3 low{128, 128, 128}, high{160, 160, 160};  // sRGB 0 to 255; bricks: of the stones
  BrickPattern bricks;
  std::uint32_t cells = 16;  // of the noise, along a tile
  double tile_m = 2;         // the texture repeats after
  double roughness = 0.9;
};

struct GroundPiece {
  std::string material;
  double y = 0;
  std::optional<Rectangle> rectangle;  // or else:
  std::vector<glm::dvec2> path;        // x, z; a smooth strip through these
  double width_m = 2;
};

struct GrassCover {
  Rectangle rectangle{};
  double patch_m = 0.5;
  std::uint32_t blades_per_patch = 30;
  double height_m = 0.12, width_m = 0.006;
  std::uint64_t seed = 1;
};

struct ModelReference {
  std::string archive;  // empty: `file` is relative to the description
  std::string file;
  std::array<double, 3> size_m{};  // width x, height y, depth z; the first that is not 0 sets the uniform scale
  bool all_two_sided = false;
  std::vector<std::string> two_sided;          // names of materials
  std::map<std::string, glm::dvec3> emissive;  // radiance by material name, for lamps whose files know none
  std::optional<PointLight> light;             // position relative to the placed model's foot
};

struct Placement {
  std::string model;
  glm::dvec3 position{0, 0, 0};
  glm::dvec3 rotation_degrees{0, 0, 0};
  double scale = 1;
};

struct SceneDescription {
  std::string title, licence;
  std::uint32_t frames = 10, width = 1280, height = 720;
  double frames_per_second = 30;
  Frame environment;  // lights, sky, ambient, exposure
  std::vector<CameraKey> camera;
  double near_m = 0.1;
  std::map<std::string, GroundMaterial> materials;
  std::vector<GroundPiece> ground;
  std::vector<GrassCover> grass;
  std::map<std::string, ModelReference> models;
  std::vector<Placement> placements;  // repeats and scatters written out
};

// Throws InputError naming line and column of broken JSON, or the field that is wrong, missing or unknown.
SceneDescription read_scene_description(const std::filesystem::path& path);

// A camera on its own: {"near_m": 0.1, "keys": [{"time_s", "eye", "target", "fov_degrees"}, ...]}.
CameraPath read_camera_file(const std::filesystem::path& path);

}  // namespace subpixel::capture
