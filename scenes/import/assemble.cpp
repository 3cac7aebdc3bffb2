#include "scenes/import/assemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <system_error>

#include "base/error.hpp"
#include "scenes/generate/grass_blades.hpp"
#include "scenes/generate/random.hpp"

namespace subpixel::capture {
namespace {

// Opens each archive and folder once.
class Sources {
 public:
  explicit Sources(const std::vector<std::filesystem::path>& folders) : folders_(folders) {}

  const AssetSource& of(const ModelReference& model) {
    std::string searched;
    for (const std::filesystem::path& folder : folders_) {
      const std::filesystem::path path = folder / (model.archive.empty() ? model.file : model.archive);
      std::error_code error;
      if (std::filesystem::is_regular_file(path, error)) {
        return model.archive.empty() ? opened(folder, &open_folder) : opened(path, &open_archive);
      }
      searched += (searched.empty() ? "" : ", ") + folder.string();
    }
    const std::string& wanted = model.archive.empty() ? model.file : model.archive;
    throw InputError("can't import the scene", "the file " + wanted + " is missing", "looked for in " + searched);
  }

 private:
  const AssetSource& opened(const std::filesystem::path& path,
                            std::unique_ptr<AssetSource> (*open)(const std::filesystem::path&)) {
    std::unique_ptr<AssetSource>& source = sources_[path.string()];
    if (!source) source = open(path);
    return *source;
  }

  const std::vector<std::filesystem::path>& folders_;
  std::map<std::string, std::unique_ptr<AssetSource>> sources_;
};

// To metres, its foot's middle at the origin.
glm::dmat4 normal_placement(const Model& model, const ModelReference& reference) {
  const glm::dvec3 size = model.high - model.low;
  double scale = 1;
  for (int axis = 2; axis >= 0; --axis) {
    const double wanted = reference.size_m[static_cast<std::size_t>(axis)];
    if (wanted > 0 && size[axis] > 0) scale = wanted / size[axis];
  }
  const glm::dvec3 foot((model.low.x + model.high.x) / 2, model.low.y, (model.low.z + model.high.z) / 2);
  return scaling({scale, scale, scale}) * translation(-foot);
}

Material& material_named(Model& model, const std::string& name) {
  const auto found = std::find_if(model.materials.begin(), model.materials.end(),
                                  [&](const Material& material) { return material.name == name; });
  if (found != model.materials.end()) return *found;
  std::string known;
  for (const Material& material : model.materials) known += (known.empty() ? "" : ", ") + material.name;
  throw InputError("can't import the scene", "the model has no material " + name + ", only " + known, model.name);
}

void change_materials(Model& model, const ModelReference& reference) {
  for (Material& material : model.materials) material.two_sided = material.two_sided || reference.all_two_sided;
  for (const std::string& name : reference.two_sided) material_named(model, name).two_sided = true;
  for (const auto& [name, radiance] : reference.emissive) {
    material_named(model, name).emissive = {static_cast<float>(radiance.x), static_cast<float>(radiance.y),
                                            static_cast<float>(radiance.z)};
  }
}

void draw_placed_model(SceneBuilder& scene, const std::string& name, Model& model, const ModelReference& reference,
                       const std::vector<Placement>& placements) {
  change_materials(model, reference);
  merge_parts(model);
  const glm::dmat4 normal = normal_placement(model, reference);
  std::vector<glm::dmat4> places;
  for (const Placement& placement : placements) {
    const double s = placement.scale;
    const glm::dmat4 place = translation(placement.position) * euler_rotation_degrees(placement.rotation_degrees);
    places.push_back(place * scaling({s, s, s}) * normal);
    if (reference.light) {
      PointLight light = *reference.light;
      const glm::dvec3 offset(light.position[0], light.position[1], light.position[2]);
      const glm::dvec3 at(place * glm::dvec4(offset * s, 1));
      light.position = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
      scene.environment.point_lights.push_back(light);
    }
  }
  const std::vector<std::uint32_t> materials = add_materials(scene, model);
  for (const ModelPart& part : model.parts) {
    const std::string part_name = name + ", " + part.name;
    scene.draw_instances(scene.add_mesh(part_name, part.mesh), part_name, materials[part.material], places);
  }
}

std::uint32_t add_ground_material(SceneBuilder& scene, const std::string& name, const GroundMaterial& from) {
  constexpr std::uint32_t kSide = 512;
  constexpr std::uint64_t kSeed = 1;
  Material material;
  material.name = name;
  material.roughness = static_cast<float>(from.roughness);
  switch (from.pattern) {
    case GroundMaterial::Pattern::plain:
      material.base_colour_texture = scene.add_texture(noise_texture(name, 4, 1, from.low, from.low, kSeed));
      break;
    case GroundMaterial::Pattern::noise:
      material.base_colour_texture =
          scene.add_texture(noise_texture(name, kSide, from.cells, from.low, from.high, kSeed));
      break;
    case GroundMaterial::Pattern::bricks: {
      BrickPattern pattern = from.bricks;
      pattern.brick = from.low;
      pattern.brick_other = from.high;
      material.base_colour_texture = scene.add_texture(brick_texture(name, kSide, pattern, kSeed));
      material.normal_texture =
          scene.add_texture(brick_normal_texture(name + " normals", kSide, pattern, 0.006, kSeed));
      break;
    }
  }
  return scene.add_material(material);
}

// A flat strip of given width along a Catmull-Rom curve through the points.
Mesh strip(const GroundPiece& piece, double uv_scale) {
  constexpr std::uint32_t kPieces = 12;  // between two points
  std::vector<CameraKey> keys;           // the camera's spline serves for the path as well
  for (const glm::dvec2& point : piece.path) {
    keys.push_back({static_cast<double>(keys.size()), {point.x, piece.y, point.y}, {0, 0, 0}, 0});
  }
  const CameraPath curve(keys);
  const auto steps = static_cast<std::uint32_t>(piece.path.size() - 1) * kPieces;
  Mesh mesh;
  double length = 0;
  for (std::uint32_t i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / kPieces;
    const glm::dvec3 at = curve.at(t).eye;
    const glm::dvec3 ahead = curve.at(std::min(t + 0.02, keys.back().time_s)).eye;
    const glm::dvec3 behind = curve.at(std::max(t - 0.02, 0.0)).eye;
    const glm::dvec3 along = glm::normalize(ahead - behind);
    const glm::dvec3 across = glm::dvec3(-along.z, 0, along.x) * (piece.width_m / 2);  // to the right
    if (i > 0) length += glm::length(at - curve.at(t - 1.0 / kPieces).eye);
    mesh.add_vertex(at - across, {0, 1, 0}, {0, length * uv_scale});
    mesh.add_vertex(at + across, {0, 1, 0}, {piece.width_m * uv_scale, length * uv_scale});
    if (i == 0) continue;
    const std::uint32_t left = 2 * i - 2;
    mesh.add_triangle(left, left + 1, left + 3);
    mesh.add_triangle(left, left + 3, left + 2);
  }
  return mesh;
}

void draw_ground(SceneBuilder& scene, const SceneDescription& description) {
  std::map<std::string, std::uint32_t> materials;
  for (std::size_t i = 0; i < description.ground.size(); ++i) {
    const GroundPiece& piece = description.ground[i];
    const GroundMaterial& material = description.materials.at(piece.material);
    if (!materials.contains(piece.material)) {
      materials[piece.material] = add_ground_material(scene, piece.material, material);
    }
    Mesh mesh;
    if (piece.rectangle) {
      const auto& [x0, z0, x1, z1] = *piece.rectangle;
      add_quad(mesh, {x0, piece.y, z1}, {x1 - x0, 0, 0}, {0, 0, z0 - z1}, 1 / material.tile_m);
    } else {
      mesh = strip(piece, 1 / material.tile_m);
    }
    if (material.pattern == GroundMaterial::Pattern::bricks) compute_tangents(mesh);
    const std::string name = fmt::format("ground {}, {}", i, piece.material);
    scene.draw(scene.add_mesh(name, mesh), name, materials[piece.material]);
  }
}

void draw_grass(SceneBuilder& scene, const GrassCover& cover, std::size_t number) {
  constexpr std::uint32_t kVariants = 4;
  Random random(cover.seed);
  const std::uint32_t material = add_grass_material(scene, fmt::format("lawn {}", number), {34, 62, 20}, {96, 136, 50});
  const BladeShape shape{3, cover.height_m, cover.width_m, cover.patch_m};
  std::vector<std::vector<glm::dmat4>> places(kVariants);
  const auto& [x0, z0, x1, z1] = cover.rectangle;
  const auto rows = static_cast<std::uint32_t>(std::ceil((z1 - z0) / cover.patch_m));
  const auto columns = static_cast<std::uint32_t>(std::ceil((x1 - x0) / cover.patch_m));
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const glm::dmat4 turned = rotation({0, 1, 0}, random.between(0, 2 * kPi));
      const glm::dvec3 at{x0 + (column + random.unit()) * cover.patch_m, 0, z0 + (row + random.unit()) * cover.patch_m};
      places[random.below(kVariants)].push_back(translation(at) * turned);
    }
  }
  for (std::uint32_t v = 0; v < kVariants; ++v) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < cover.blades_per_patch; ++i) add_blade(mesh, shape, random);
    const std::string name = fmt::format("lawn {}, patch {}", number, v);
    scene.draw_instances(scene.add_mesh(name, mesh), name, material, places[v]);
  }
}

}  // namespace

std::vector<std::uint32_t> add_materials(SceneBuilder& scene, const Model& model) {
  std::vector<std::uint32_t> textures;
  for (const Texture& texture : model.textures) textures.push_back(scene.add_texture(texture));
  std::vector<std::uint32_t> numbers;
  for (Material material : model.materials) {
    for (std::uint32_t* texture : {&material.base_colour_texture, &material.metallic_roughness_texture,
                                   &material.normal_texture, &material.emissive_texture}) {
      if (*texture != kNone) *texture = textures[*texture];
    }
    numbers.push_back(scene.add_material(std::move(material)));
  }
  return numbers;
}

void assemble(SceneBuilder& scene, const SceneDescription& description,
              const std::vector<std::filesystem::path>& folders,
              const std::function<void(const std::string&)>& progress) {
  draw_ground(scene, description);
  Sources sources(folders);
  for (const auto& [name, reference] : description.models) {
    std::vector<Placement> placements;
    std::copy_if(description.placements.begin(), description.placements.end(), std::back_inserter(placements),
                 [&, &model_name = name](const Placement& placement) { return placement.model == model_name; });
    if (placements.empty()) continue;
    Model model = load_model(sources.of(reference), reference.file);
    if (progress) {
      progress(fmt::format("{}: {} placed from {}", name, placements.size(), reference.file));
      for (const std::string& notice : model.notices) progress(fmt::format("{}: {}", name, notice));
    }
    draw_placed_model(scene, name, model, reference, placements);
  }
  for (std::size_t i = 0; i < description.grass.size(); ++i) draw_grass(scene, description.grass[i], i);
}

}  // namespace subpixel::capture
