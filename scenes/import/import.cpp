#include "scenes/import/import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/error.hpp"
#include "capture_format/limits.hpp"
#include "scenes/import/assemble.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr const char* kDefaultAssets = "/usr/share/sweethome3d/furniture";
constexpr const char* kTool = "subpixel importer 1";  // counts up when it makes other captures of the same files

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::vector<std::filesystem::path> asset_folders(const std::filesystem::path& description,
                                                 const ImportOptions& options) {
  std::vector<std::filesystem::path> folders{description.has_parent_path() ? description.parent_path() : "."};
  if (!options.asset_folders.empty()) {
    folders.insert(folders.end(), options.asset_folders.begin(), options.asset_folders.end());
    return folders;
  }
  const char* variable = std::getenv("SUBPIXEL_ASSETS");
  if (variable == nullptr || *variable == '\0') {
    folders.emplace_back(kDefaultAssets);
    return folders;
  }
  std::string list = variable;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t end = std::min(list.find(':', at), list.size());
    if (end > at) folders.emplace_back(list.substr(at, end - at));
    at = end + 1;
  }
  return folders;
}

// A quarter of a degree a frame moves what is nearest by a few pixels; 20 degrees above, the whole model in sight.
CameraPath orbit(const Model& model, std::uint32_t frames, double frames_per_second, double aspect) {
  constexpr double kFov = 45;
  constexpr double kStepDegrees = 0.25;
  const glm::dvec3 centre = (model.low + model.high) * 0.5;
  const double radius = std::max(glm::length(model.high - model.low) * 0.5, 1e-6);
  const double narrower = std::min(1.0, aspect);
  const double distance = 1.05 * radius / (sine(kFov * kPi / 360) * narrower);
  std::vector<CameraKey> keys;
  for (std::uint32_t i = 0; i < std::max(frames, 2u); ++i) {
    const double turn = (30 + kStepDegrees * i) * kPi / 180;
    const double rise = 20 * kPi / 180;
    const glm::dvec3 away(cosine(rise) * sine(turn), sine(rise), cosine(rise) * cosine(turn));
    keys.push_back({i / frames_per_second, centre + away * distance, centre, kFov});
  }
  return CameraPath(keys, distance * 1e-3);
}

// Places the frame's camera: reversed depth with the far plane at infinity, near a thousandth of the model's distance
// where the file has no other. A parallel projection is seen from a thousand diagonals away, so that all directions to
// the eye are parallel to a thousandth.
void set_camera(Frame& frame, const ModelCamera& camera, const Model& model, std::uint32_t width,
                std::uint32_t height) {
  const double diagonal = std::max(glm::length(model.high - model.low), 1e-6);
  const double aspect = static_cast<double>(width) / height;
  frame.clip_depth = ClipDepth::one_to_zero;
  frame.clip_y_up = false;
  frame.width = width;
  frame.height = height;
  glm::dmat4 world = camera.world;
  if (!camera.orthographic) {
    const double reach = glm::length(glm::dvec3(world[3]) - (model.low + model.high) * 0.5) + diagonal;
    const double near = camera.near.value_or(std::min(0.1, reach * 1e-3));
    frame.projection = to_matrix4(perspective(camera.vertical_fov_degrees, aspect, near));
  } else {
    const double back = 1e3 * diagonal;
    world[3] += world[2] * back;
    const double near = back + camera.near.value_or(0);
    const double far = back + camera.far.value_or(2 * diagonal);
    glm::dmat4 projection(1.0);
    projection[0][0] = 1 / (camera.half_height * aspect);
    projection[1][1] = -1 / camera.half_height;
    projection[2][2] = 1 / (far - near);
    projection[3][2] = far / (far - near);
    frame.projection = to_matrix4(projection);
  }
  frame.view = to_matrix4(glm::inverse(world));
}

// Whether the model's bounds are not wholly on the outer side of one side of the camera's view, whatever its width.
bool may_see(const ModelCamera& camera, const Model& model, double aspect) {
  const glm::dmat4 view = glm::inverse(camera.world);
  const double half = camera.vertical_fov_degrees * kPi / 360;
  const double tangent = camera.orthographic ? 0 : sine(half) / cosine(half);
  int outside[5] = {};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? model.high.x : model.low.x, (corner & 2) != 0 ? model.high.y : model.low.y,
                        (corner & 4) != 0 ? model.high.z : model.low.z);
    const glm::dvec3 seen(view * glm::dvec4(at, 1));
    const double ahead = -seen.z;
    const double high = camera.orthographic ? camera.half_height : ahead * tangent;
    const double wide = high * aspect;
    outside[0] += ahead < 0 ? 1 : 0;
    outside[1] += seen.y > high ? 1 : 0;
    outside[2] += seen.y < -high ? 1 : 0;
    outside[3] += seen.x > wide ? 1 : 0;
    outside[4] += seen.x < -wide ? 1 : 0;
  }
  return std::none_of(std::begin(outside), std::end(outside), [](int corners) { return corners == 8; });
}

void draw_model(SceneBuilder& scene, const Model& model, const std::vector<std::uint32_t>& materials) {
  for (const ModelPart& part : model.parts) {
    const Draw mesh = scene.add_mesh(part.name, part.mesh);
    if (part.instanced) {
      scene.draw_instances(mesh, part.name, materials[part.material], part.placements);
      continue;
    }
    // Each place is a draw call of its own, as the application that the file stands for would make it.
    for (const glm::dmat4& place : part.placements) scene.draw(mesh, part.name, materials[part.material], place);
  }
}

void light_model(SceneBuilder& scene, const Model& model) {
  scene.environment.sun = model.sun;
  scene.environment.point_lights = model.point_lights;
  if (!model.sun && model.point_lights.empty()) {
    scene.environment.sun = DirectionalLight{{-0.45f, -0.75f, -0.5f}, {3, 3, 3}, true};
  }
}

Capture import_model(const std::filesystem::path& path, const ImportOptions& options) {
  ModelArchive from{nullptr, path.filename().string()};
  if (lower_extension(path) == ".zip")
    from = open_model_archive(path);
  else
    from.source = open_folder(path.parent_path());
  Model model = load_model(*from.source, from.model);
  const std::uint32_t width = options.width.value_or(1280);
  const std::uint32_t height = options.height.value_or(720);
  if (model.camera && options.camera.empty() && !may_see(*model.camera, model, static_cast<double>(width) / height)) {
    model.camera.reset();
    model.notices.emplace_back("ignored: the file's camera, which sees nothing of the model");
  }
  const bool has_own_camera = model.camera.has_value();
  Metadata metadata;
  metadata.title = to_utf8(path.stem().string());
  metadata.application = to_utf8(path.filename().string());
  metadata.tool = kTool;
  metadata.notices = model.notices;
  for (const std::string& notice : model.notices) {
    if (options.progress) options.progress(notice);
  }
  SceneBuilder scene(metadata);
  const std::vector<std::uint32_t> materials = add_materials(scene, model);
  const std::uint32_t frames = options.frames.value_or(10);
  constexpr double kFramesPerSecond = 30;
  if (model.animation) model.animation->pose(0, model);
  std::optional<CameraPath> path_of_camera;
  if (!options.camera.empty() && options.camera != "orbit") {
    path_of_camera = read_camera_file(options.camera);
  } else if (options.camera == "orbit" || !has_own_camera) {
    path_of_camera = orbit(model, frames, kFramesPerSecond, static_cast<double>(width) / height);
  }
  for (std::uint32_t i = 0; i < frames; ++i) {
    const double time_s = i / kFramesPerSecond;
    if (i == 0 || model.animation) {
      if (model.animation) model.animation->pose(std::min(time_s, model.animation->duration_s()), model);
      scene.clear_draws();
      light_model(scene, model);
      draw_model(scene, model, materials);
    }
    Frame frame = scene.environment;
    frame.name = "frame " + std::to_string(i);
    frame.time_s = time_s;
    if (path_of_camera) {
      path_of_camera->set(frame, time_s, width, height);
    } else {
      set_camera(frame, *model.camera, model, width, height);
    }
    scene.record_frame(std::move(frame));
  }
  return scene.take();
}

Capture import_description(const std::filesystem::path& path, const ImportOptions& options) {
  const SceneDescription description = read_scene_description(path);
  Metadata metadata;
  metadata.title = description.title;
  metadata.application = to_utf8(path.filename().string());
  metadata.tool = kTool;
  metadata.licence = description.licence;
  SceneBuilder scene(metadata);
  scene.environment = description.environment;
  assemble(scene, description, asset_folders(path, options), options.progress);
  const CameraPath camera =
      options.camera.empty() ? CameraPath(description.camera, description.near_m) : read_camera_file(options.camera);
  return scene.finish(camera, options.frames.value_or(description.frames), options.width.value_or(description.width),
                      options.height.value_or(description.height), description.frames_per_second);
}

void require_range(const char* name, const std::optional<std::uint32_t>& value, std::uint32_t most) {
  if (value && (*value < 1 || *value > most)) {
    throw UsageError("can't import the file", fmt::format("{} is outside 1 to {}", *value, most), name);
  }
}

}  // namespace

Capture import_file(const std::filesystem::path& path, const ImportOptions& options) {
  require_range("frames", options.frames, kMaxFrames);
  require_range("width", options.width, kMaxFrameSide);
  require_range("height", options.height, kMaxFrameSide);
  const std::string extension = lower_extension(path);
  if (extension == ".rdc") {
    throw UsageError("RenderDoc captures can't be read",
                     "models are read here; `subpixel import` and python/subpixel_renderdoc read frames",
                     path.string());
  }
  const bool is_description = extension == ".json";
  if (is_description && options.camera == "orbit") {
    throw UsageError("can't import the scene", "a scene description has a camera of its own, orbit is for models",
                     "camera");
  }
  try {
    return is_description ? import_description(path, options) : import_model(path, options);
  } catch (const UsageError& error) {
    // What the recorder refuses here is the file's, not the caller's.
    throw InputError(is_description ? "can't import the scene" : "can't import the model", error.what(), path.string());
  }
}

}  // namespace subpixel::capture
