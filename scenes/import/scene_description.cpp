#include "scenes/import/scene_description.hpp"

#include <fmt/format.h>

#include <cmath>

#include "capture_format/limits.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/import/json_fields.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint32_t kMaxPlacements = 1u << 20;

Float3 to_float3(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Rectangle read_rectangle(JsonFields& fields) {
  const std::vector<double> corners = fields.numbers("rectangle", 4);
  if (corners[2] <= corners[0] || corners[3] <= corners[1])
    fields.fail("rectangle", "its second corner is not beyond its first");
  return {corners[0], corners[1], corners[2], corners[3]};
}

std::pair<std::vector<CameraKey>, double> read_camera(JsonFields fields) {
  std::vector<CameraKey> keys;
  const double near_m = fields.number_between("near_m", 1e-4, 1e4, 0.1);
  for (JsonFields& key : fields.objects("keys")) {
    keys.push_back(
        {key.number("time_s"), key.vec3("eye"), key.vec3("target"), key.number_between("fov_degrees", 1, 170, 50)});
    if (keys.size() > 1 && keys[keys.size() - 2].time_s >= keys.back().time_s) {
      key.fail("time_s", "not after the key before");
    }
    if (keys.back().eye == keys.back().target) key.fail("target", "the same point as eye");
    key.finish();
  }
  if (keys.empty()) fields.fail("keys", "there is none");
  fields.finish();
  return {keys, near_m};
}

PointLight read_light(JsonFields& fields, const std::string& place) {
  PointLight light;
  light.position = to_float3(fields.vec3(place));
  light.intensity = to_float3(fields.light("intensity"));
  light.range = static_cast<float>(fields.number_between("range", 1e-3, 1e6));
  fields.finish();
  return light;
}

void read_environment(JsonFields& fields, Frame& frame) {
  frame.exposure = static_cast<float>(fields.number_between("exposure", 0, 1e6, 1.0));
  if (fields.has("sky")) frame.sky = to_float3(fields.light("sky"));
  if (fields.has("ambient")) frame.ambient = to_float3(fields.light("ambient"));
  if (fields.has("sun")) {
    JsonFields sun = fields.object("sun");
    frame.sun = DirectionalLight{to_float3(sun.vec3("direction")), to_float3(sun.light("irradiance")),
                                 sun.flag("shadows", true)};
    if (frame.sun->direction == Float3{0, 0, 0}) sun.fail("direction", "of length 0");
    sun.finish();
  }
  for (JsonFields& light : fields.objects("point_lights")) {
    frame.point_lights.push_back(read_light(light, "position"));
  }
}

GroundMaterial read_material(JsonFields& fields) {
  GroundMaterial material;
  const std::string pattern = fields.text("pattern", "plain");
  if (pattern == "noise") {
    material.pattern = GroundMaterial::Pattern::noise;
    material.cells = fields.whole("cells", 1, 256, material.cells);
  } else if (pattern == "bricks") {
    material.pattern = GroundMaterial::Pattern::bricks;
    material.bricks.columns = fields.whole("columns", 1, 256, material.bricks.columns);
    material.bricks.rows = fields.whole("rows", 2, 256, material.bricks.rows);
    material.bricks.mortar = fields.number_between("mortar", 0, 0.5, material.bricks.mortar);
    material.bricks.joint = fields.vec3("joint", material.bricks.joint);
  } else if (pattern != "plain") {
    fields.fail("pattern", "not one of plain, noise, bricks");
  }
  material.low = fields.vec3("low", material.low);
  material.high = fields.vec3("high", material.low);
  material.tile_m = fields.number_between("tile_m", 1e-3, 1e4, material.tile_m);
  material.roughness = fields.number_between("roughness", 0, 1, material.roughness);
  fields.finish();
  return material;
}

GroundPiece read_ground(JsonFields& fields, const SceneDescription& scene) {
  GroundPiece piece;
  piece.material = fields.text("material");
  if (!scene.materials.contains(piece.material)) fields.fail("material", "no material is named " + piece.material);
  piece.y = fields.number("y", 0.0);
  if (fields.has("path")) {
    piece.path = fields.points2("path");
    if (piece.path.size() < 2) fields.fail("path", "fewer than 2 points");
    piece.width_m = fields.number_between("width_m", 0.01, 1000, piece.width_m);
  } else {
    piece.rectangle = read_rectangle(fields);
  }
  fields.finish();
  return piece;
}

GrassCover read_grass(JsonFields& fields) {
  GrassCover grass;
  grass.rectangle = read_rectangle(fields);
  grass.patch_m = fields.number_between("patch_m", 0.05, 100, grass.patch_m);
  grass.blades_per_patch = fields.whole("blades_per_patch", 1, 10000, grass.blades_per_patch);
  grass.height_m = fields.number_between("height_m", 0.001, 10, grass.height_m);
  grass.width_m = fields.number_between("width_m", 0.0001, 1, grass.width_m);
  grass.seed = fields.whole("seed", 0, 0x7fffffff, 1);
  const Rectangle& area = grass.rectangle;
  if ((area[2] - area[0]) / grass.patch_m * ((area[3] - area[1]) / grass.patch_m) > kMaxPlacements) {
    fields.fail("patch_m", fmt::format("more than {} patches in the rectangle", kMaxPlacements));
  }
  fields.finish();
  return grass;
}

ModelReference read_model(JsonFields& fields) {
  ModelReference model;
  model.archive = fields.text("archive", "");
  model.file = fields.text("file");
  model.size_m = {fields.number_between("width_m", 0, 1e4, 0.0), fields.number_between("height_m", 0, 1e4, 0.0),
                  fields.number_between("depth_m", 0, 1e4, 0.0)};
  if (const nlohmann::json* value = fields.value("two_sided"); value != nullptr && value->is_boolean()) {
    model.all_two_sided = value->get<bool>();
  } else if (value != nullptr) {
    model.two_sided = fields.texts("two_sided");
  }
  if (const nlohmann::json* emissive = fields.value("emissive")) {
    if (!emissive->is_object()) fields.fail("emissive", "not an object of radiances by material name");
    JsonFields radiances = fields.object("emissive");
    for (const auto& [name, radiance] : emissive->items()) model.emissive[name] = radiances.light(name);
  }
  if (fields.has("light")) {
    JsonFields light = fields.object("light");
    model.light = read_light(light, "offset");
  }
  fields.finish();
  return model;
}

glm::dvec3 read_rotation(JsonFields& fields) {
  const nlohmann::json* value = fields.value("rotation_degrees");
  if (value == nullptr) return {0, 0, 0};
  if (value->is_number()) return {0, fields.number("rotation_degrees"), 0};  // a turn about the upright axis
  return fields.vec3("rotation_degrees");
}

// The same model again and again, each a step and a turn further.
void add_repeats(JsonFields fields, Placement placement, std::vector<Placement>& placements) {
  const std::uint32_t count = fields.whole("count", 1, kMaxPlacements);
  const glm::dvec3 step = fields.vec3("step");
  const double turn = fields.number("turn_degrees", 0.0);
  for (std::uint32_t i = 0; i < count; ++i) {
    placements.push_back(placement);
    placement.position += step;
    placement.rotation_degrees.y += turn;
  }
  fields.finish();
}

// Random places in a rectangle, at least a spacing apart; a place that finds no room after some tries is left out.
void add_scatter(JsonFields fields, const Placement& placement, std::vector<Placement>& placements) {
  const std::uint32_t count = fields.whole("count", 1, 100000);
  const Rectangle area = read_rectangle(fields);
  const double spacing = fields.number_between("spacing_m", 0, 1e4, 0.0);
  const double scale_low = fields.number_between("scale_from", 1e-3, 1e3, 1.0);
  const double scale_high = fields.number_between("scale_to", scale_low, 1e3, scale_low);
  Random random(fields.whole("seed", 0, 0x7fffffff, 1));
  const std::size_t first = placements.size();
  for (std::uint32_t i = 0; i < count; ++i) {
    constexpr int kTries = 20;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      Placement scattered = placement;
      scattered.position += glm::dvec3{random.between(area[0], area[2]), 0, random.between(area[1], area[3])};
      scattered.rotation_degrees.y += random.between(0, 360);
      scattered.scale *= random.between(scale_low, scale_high);
      bool is_free = true;
      for (std::size_t k = first; k < placements.size() && is_free; ++k) {
        const glm::dvec3 apart = placements[k].position - scattered.position;
        is_free = apart.x * apart.x + apart.z * apart.z >= spacing * spacing;
      }
      if (!is_free) continue;
      placements.push_back(scattered);
      break;
    }
  }
  fields.finish();
}

void read_placement(JsonFields& fields, SceneDescription& scene) {
  Placement placement;
  placement.model = fields.text("model");
  if (!scene.models.contains(placement.model)) fields.fail("model", "no model is named " + placement.model);
  placement.position = fields.vec3("position", glm::dvec3(0, 0, 0));
  placement.rotation_degrees = read_rotation(fields);
  placement.scale = fields.number_between("scale", 1e-6, 1e6, 1.0);
  if (fields.has("repeat") && fields.has("scatter")) fields.fail("scatter", "beside repeat");
  if (fields.has("repeat")) {
    add_repeats(fields.object("repeat"), placement, scene.placements);
  } else if (fields.has("scatter")) {
    add_scatter(fields.object("scatter"), placement, scene.placements);
  } else {
    scene.placements.push_back(placement);
  }
  if (scene.placements.size() > kMaxPlacements) fields.fail("model", "too many placements");
  fields.finish();
}

}  // namespace

SceneDescription read_scene_description(const std::filesystem::path& path) {
  const nlohmann::json document = parse_json_file(path);
  JsonFields fields(document, path.string(), "");
  SceneDescription scene;
  scene.title = fields.text("title", path.stem().string());
  scene.licence = fields.text("licence", "");
  scene.frames = fields.whole("frames", 1, kMaxFrames, scene.frames);
  scene.frames_per_second = fields.number_between("frames_per_second", 0.01, 1e4, scene.frames_per_second);
  if (fields.has("size")) {
    const std::vector<double> size = fields.numbers("size", 2);
    for (const double side : size) {
      if (side < 1 || side > kMaxFrameSide || side != std::floor(side)) fields.fail("size", "not a picture's size");
    }
    scene.width = static_cast<std::uint32_t>(size[0]);
    scene.height = static_cast<std::uint32_t>(size[1]);
  }
  read_environment(fields, scene.environment);
  std::tie(scene.camera, scene.near_m) = read_camera(fields.object("camera"));
  for (auto& [name, material] : fields.named_objects("materials")) scene.materials[name] = read_material(material);
  for (JsonFields& ground : fields.objects("ground")) scene.ground.push_back(read_ground(ground, scene));
  for (JsonFields& grass : fields.objects("grass")) scene.grass.push_back(read_grass(grass));
  for (auto& [name, model] : fields.named_objects("models")) scene.models[name] = read_model(model);
  for (JsonFields& placement : fields.objects("placements")) read_placement(placement, scene);
  fields.finish();
  return scene;
}

CameraPath read_camera_file(const std::filesystem::path& path) {
  const nlohmann::json document = parse_json_file(path);
  auto [keys, near_m] = read_camera(JsonFields(document, path.string(), ""));
  return CameraPath(std::move(keys), near_m);
}

}  // namespace subpixel::capture
