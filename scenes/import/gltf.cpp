#include "scenes/import/gltf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>

#include "base/error.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/import/gltf_document.hpp"
#include "scenes/import/gltf_materials.hpp"
#include "scenes/import/gltf_mesh.hpp"
#include "scenes/import/gltf_scene.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr std::string_view kSupported[] = {"EXT_mesh_gpu_instancing",
                                           "EXT_meshopt_compression",
                                           "EXT_texture_webp",
                                           "KHR_draco_mesh_compression",
                                           "KHR_lights_punctual",
                                           "KHR_materials_emissive_strength",
                                           "KHR_materials_pbrSpecularGlossiness",
                                           "KHR_materials_unlit",
                                           "KHR_mesh_quantization",
                                           "KHR_meshopt_compression",
                                           "KHR_texture_transform",
                                           "MSFT_texture_dds"};

Float3 float3(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

struct Skin {
  std::vector<std::size_t> joints;  // nodes
  std::vector<glm::dmat4> inverse_bind;
};

class GltfScene final : public ModelAnimation {
 public:
  GltfScene(const AssetSource& source, const std::string& name) : document_(source, name, kSupported) {}

  void load(Model& model);
  bool moves() const { return animation_.has_value(); }
  double duration_s() const override { return animation_ ? animation_->duration_s() : 0; }
  void pose(double time_s, Model& model) const override;

 private:
  struct Part {
    std::size_t mesh = 0, primitive = 0;
    std::vector<std::size_t> places;  // placed nodes that draw it; one where it is deformed
    std::optional<std::size_t> skin;
    bool is_instanced = false;
  };

  void read_meshes(Model& model);
  void read_skins();
  void list_parts(const std::vector<GltfPlace>& places);
  std::vector<glm::dmat4> instances_of(std::size_t node) const;
  std::vector<double> weights_of(const GltfNode& node, std::size_t mesh) const;
  void place_lights(const std::vector<GltfPlace>& places, Model& model) const;
  void place_camera(const std::vector<GltfPlace>& places, Model& model) const;
  void note_what_is_ignored(Model& model) const;

  GltfDocument document_;
  std::vector<GltfNode> nodes_;
  std::vector<std::size_t> roots_;
  std::vector<std::vector<GltfPrimitive>> meshes_;
  std::vector<std::vector<double>> mesh_weights_;
  std::map<std::optional<std::size_t>, std::uint32_t> material_numbers_;
  std::vector<GltfMaterial> materials_;
  std::vector<Skin> skins_;
  std::vector<std::optional<std::size_t>> mesh_of_node_, skin_of_node_, camera_of_node_, light_of_node_;
  std::vector<std::vector<glm::dmat4>> instances_of_node_;
  std::vector<Part> parts_;
  std::optional<GltfAnimation> animation_;
};

void GltfScene::read_meshes(Model& model) {
  GltfMaterials reader(document_, model.textures, model.notices);
  std::vector<bool> is_drawn(document_.count("meshes"));
  for (const GltfPlace& place : placed_nodes(document_, nodes_, roots_)) {
    if (mesh_of_node_[place.node]) is_drawn[*mesh_of_node_[place.node]] = true;
  }
  std::size_t left_out = 0;
  for (std::size_t m = 0; m < is_drawn.size(); ++m) {
    meshes_.emplace_back();
    mesh_weights_.emplace_back();
    if (!is_drawn[m]) continue;
    const GltfElement mesh = document_.item("meshes", m);
    if (const auto weights = mesh.find("weights")) mesh_weights_[m] = mesh.numbers("weights", weights->size());
    const std::string name = to_utf8(mesh.text("name", ""));
    for (const GltfElement& from : mesh.elements("primitives")) {
      const auto material = from.find_index("material", document_.count("materials"));
      const auto [number, is_new] =
          material_numbers_.try_emplace(material, static_cast<std::uint32_t>(materials_.size()));
      if (is_new) {
        materials_.push_back(reader.read(material));
        model.materials.push_back(materials_.back().material);
      }
      std::optional<GltfPrimitive> primitive = read_primitive(document_, from, materials_[number->second]);
      if (!primitive) ++left_out;
      if (!primitive || primitive->mesh.indices.empty()) continue;
      primitive->name = name.empty() ? model.name : name;
      primitive->material = material;
      meshes_[m].push_back(std::move(*primitive));
    }
  }
  if (left_out > 0) model.notices.push_back(fmt::format("ignored: {} primitives of points or lines", left_out));
}

void GltfScene::read_skins() {
  static constexpr std::string_view kMatrix[] = {"MAT4"};
  for (std::size_t i = 0; i < document_.count("skins"); ++i) {
    const GltfElement from = document_.item("skins", i);
    Skin skin;
    for (const GltfElement& joint : from.elements("joints")) skin.joints.push_back(joint.as_index(nodes_.size()));
    skin.inverse_bind.assign(skin.joints.size(), glm::dmat4(1.0));
    if (const auto accessor = from.find_index("inverseBindMatrices", document_.count("accessors"))) {
      const GltfValues values = document_.values(*accessor, from.member("inverseBindMatrices"), kMatrix);
      if (values.count < skin.joints.size()) {
        from.fail(fmt::format("{} inverse bind matrices for {} joints", values.count, skin.joints.size()));
      }
      for (std::size_t j = 0; j < skin.joints.size(); ++j) {
        for (int k = 0; k < 16; ++k) skin.inverse_bind[j][k / 4][k % 4] = values.at(j)[k];
      }
    }
    skins_.push_back(std::move(skin));
  }
}

// EXT_mesh_gpu_instancing: one placement relative to the node for each element of its accessors.
std::vector<glm::dmat4> GltfScene::instances_of(std::size_t node) const {
  static constexpr std::string_view kVec3[] = {"VEC3"}, kVec4[] = {"VEC4"};
  const GltfElement from = document_.item("nodes", node);
  const std::optional<GltfElement> extension = from.extension("EXT_mesh_gpu_instancing");
  if (!extension) return {};
  const GltfElement attributes = extension->member("attributes");
  const auto find = [&](const char* key, std::span<const std::string_view> types) -> std::optional<GltfValues> {
    const auto accessor = attributes.find_index(key, document_.count("accessors"));
    return accessor ? std::optional(document_.values(*accessor, attributes.member(key), types)) : std::nullopt;
  };
  const std::optional<GltfValues> move = find("TRANSLATION", kVec3), turn = find("ROTATION", kVec4),
                                  scale = find("SCALE", kVec3);
  std::optional<std::size_t> count;
  for (const std::optional<GltfValues>* values : {&move, &turn, &scale}) {
    if (!*values) continue;
    if (count && *count != (*values)->count) attributes.fail("its accessors differ in their number of instances");
    count = (*values)->count;
  }
  if (!count) attributes.fail("neither TRANSLATION, ROTATION nor SCALE");
  std::vector<glm::dmat4> instances;
  for (std::size_t i = 0; i < *count; ++i) {
    GltfNode instance;
    if (move) instance.translation = {move->at(i)[0], move->at(i)[1], move->at(i)[2]};
    if (scale) instance.scale = {scale->at(i)[0], scale->at(i)[1], scale->at(i)[2]};
    if (turn) {
      const glm::dvec4 q(turn->at(i)[0], turn->at(i)[1], turn->at(i)[2], turn->at(i)[3]);
      if (glm::length(q) > 0) instance.rotation = q / glm::length(q);
    }
    instances.push_back(local_matrix(instance));
  }
  return instances;
}

// Rigid primitives are one part wherever they stand; what is skinned or morphed is a part for each place.
void GltfScene::list_parts(const std::vector<GltfPlace>& places) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> rigid;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const std::size_t node = places[p].node;
    if (!mesh_of_node_[node]) continue;
    const std::size_t mesh = *mesh_of_node_[node];
    for (std::size_t i = 0; i < meshes_[mesh].size(); ++i) {
      const GltfPrimitive& primitive = meshes_[mesh][i];
      const std::optional<std::size_t> skin =
          primitive.influences_per_vertex > 0 ? skin_of_node_[node] : std::optional<std::size_t>();
      const bool is_instanced = !instances_of_node_[node].empty();
      if (skin || !primitive.targets.empty() || is_instanced) {
        parts_.push_back({mesh, i, {p}, skin, is_instanced});
        continue;
      }
      const auto [part, is_new] = rigid.try_emplace({mesh, i}, parts_.size());
      if (is_new) parts_.push_back({mesh, i, {}, {}, false});
      parts_[part->second].places.push_back(p);
    }
  }
}

std::vector<double> GltfScene::weights_of(const GltfNode& node, std::size_t mesh) const {
  return node.weights.empty() ? mesh_weights_[mesh] : node.weights;
}

void GltfScene::load(Model& model) {
  nodes_ = read_nodes(document_);
  roots_ = scene_roots(document_, nodes_, model.notices);
  const std::size_t lights = [&] {
    const auto extension = document_.root().extension("KHR_lights_punctual");
    return extension && extension->has("lights") ? extension->member("lights").size() : 0;
  }();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const GltfElement from = document_.item("nodes", i);
    mesh_of_node_.push_back(from.find_index("mesh", document_.count("meshes")));
    skin_of_node_.push_back(from.find_index("skin", document_.count("skins")));
    camera_of_node_.push_back(from.find_index("camera", document_.count("cameras")));
    const auto light = from.extension("KHR_lights_punctual");
    light_of_node_.push_back(light ? light->find_index("light", lights) : std::nullopt);
    instances_of_node_.push_back(instances_of(i));
  }
  read_meshes(model);
  read_skins();
  const std::vector<GltfPlace> places = placed_nodes(document_, nodes_, roots_);
  list_parts(places);
  for (const Part& part : parts_) {
    const GltfPrimitive& primitive = meshes_[part.mesh][part.primitive];
    ModelPart drawn;
    drawn.name = primitive.name;
    drawn.material = material_numbers_.at(primitive.material);
    drawn.instanced = part.is_instanced;
    if (part.skin) {
      for (const GltfPrimitive::Influence& influence : primitive.influences) {
        if (influence.joint >= skins_[*part.skin].joints.size()) {
          throw InputError("can't import the model",
                           fmt::format("joint {} of a skin of {}", influence.joint, skins_[*part.skin].joints.size()),
                           document_.file() + ", " + primitive.path);
        }
      }
    } else if (primitive.targets.empty()) {
      drawn.mesh = posed(primitive, {}, {}, model.materials[drawn.material]);
    }
    model.parts.push_back(std::move(drawn));
  }
  if (document_.count("animations") > 0) animation_.emplace(document_, 0, model.notices);
  note_what_is_ignored(model);
  pose(0, model);
}

void GltfScene::pose(double time_s, Model& model) const {
  std::vector<GltfNode> nodes = nodes_;
  if (animation_) animation_->apply(time_s, nodes);
  const std::vector<GltfPlace> places = placed_nodes(document_, nodes, roots_);
  std::vector<glm::dmat4> world_of_node(nodes.size(), glm::dmat4(1.0));
  for (const GltfPlace& place : places) world_of_node[place.node] = place.world;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const GltfPrimitive& primitive = meshes_[part.mesh][part.primitive];
    ModelPart& drawn = model.parts[i];
    drawn.placements.clear();
    for (const std::size_t place : part.places) {
      const std::vector<glm::dmat4>& instances = instances_of_node_[places[place].node];
      if (part.skin) {
        drawn.placements.emplace_back(1.0);  // the joints say where it is, its node does not
      } else if (part.is_instanced) {
        for (const glm::dmat4& instance : instances) drawn.placements.push_back(places[place].world * instance);
      } else {
        drawn.placements.push_back(places[place].world);
      }
    }
    if (!part.skin && primitive.targets.empty()) continue;
    std::vector<glm::dmat4> joints;
    if (part.skin) {
      const Skin& skin = skins_[*part.skin];
      for (std::size_t j = 0; j < skin.joints.size(); ++j) {
        joints.push_back(world_of_node[skin.joints[j]] * skin.inverse_bind[j]);
      }
    }
    const std::vector<double> weights = weights_of(nodes[places[part.places.front()].node], part.mesh);
    drawn.mesh = posed(primitive, weights, joints, model.materials[drawn.material]);
  }
  place_lights(places, model);
  place_camera(places, model);
}

// KHR_lights_punctual: candela and lux are taken as they are for radiant intensity and irradiance.
void GltfScene::place_lights(const std::vector<GltfPlace>& places, Model& model) const {
  model.point_lights.clear();
  model.sun.reset();
  double brightest_sun = -1;
  for (const GltfPlace& place : places) {
    if (!light_of_node_[place.node]) continue;
    const GltfElement light =
        document_.root().extension("KHR_lights_punctual")->member("lights").element(*light_of_node_[place.node]);
    glm::dvec3 colour(1);
    if (light.has("color")) {
      const std::vector<double> c = light.numbers("color", 3);
      colour = {std::max(c[0], 0.0), std::max(c[1], 0.0), std::max(c[2], 0.0)};
    }
    const glm::dvec3 intensity = colour * light.number_between("intensity", 0, 1e12, 1);
    const glm::dvec3 along = -glm::dvec3(place.world[2]);
    const glm::dvec3 direction = glm::length(along) > 0 ? glm::normalize(along) : glm::dvec3(0, 0, -1);
    const std::string type = light.text("type");
    if (type == "directional") {
      const double brightness = intensity.x + intensity.y + intensity.z;
      if (brightness > brightest_sun) model.sun = DirectionalLight{float3(direction), float3(intensity), true};
      brightest_sun = std::max(brightest_sun, brightness);
      continue;
    }
    if (type != "point" && type != "spot") light.member("type").fail("neither directional, point nor spot");
    PointLight point;
    point.position = float3(glm::dvec3(place.world[3]));
    point.intensity = float3(intensity);
    // Without a range of its own, far enough that the window hides less than 1% of what the sun of a default scene
    // gives.
    const double brightest = std::max({intensity.x, intensity.y, intensity.z, 1e-6});
    point.range = static_cast<float>(light.has("range") ? light.number_between("range", 1e-6, 1e12)
                                                        : std::sqrt(brightest / 0.03));
    if (type == "spot") {
      const GltfElement spot = light.member("spot");
      const double outer = spot.number_between("outerConeAngle", 1e-4, kPi / 2, kPi / 4);
      const double inner = spot.number_between("innerConeAngle", 0, kPi / 2, 0.0);
      if (!(inner < outer)) spot.fail(fmt::format("innerConeAngle {} is not below outerConeAngle {}", inner, outer));
      point.cone = SpotCone{float3(direction), static_cast<float>(cosine(inner)), static_cast<float>(cosine(outer))};
      // In floats two close angles may have one cosine.
      if (!(point.cone->inner_cosine > point.cone->outer_cosine))
        point.cone->outer_cosine = std::nextafter(point.cone->inner_cosine, -1.0f);
    }
    model.point_lights.push_back(point);
  }
}

void GltfScene::place_camera(const std::vector<GltfPlace>& places, Model& model) const {
  model.camera.reset();
  const auto placed =
      std::ranges::find_if(places, [&](const GltfPlace& place) { return camera_of_node_[place.node].has_value(); });
  if (placed == places.end()) return;
  const GltfElement from = document_.item("cameras", *camera_of_node_[placed->node]);
  ModelCamera camera;
  camera.world = placed->world;
  for (int i = 0; i < 3; ++i) {  // section 3.10.2: the node's scale is not the camera's
    const double length = glm::length(glm::dvec3(camera.world[i]));
    if (!(length > 0)) document_.item("nodes", placed->node).fail("the camera's node has a scale of 0");
    camera.world[i] /= length;
  }
  const std::string type = from.text("type");
  if (type == "orthographic") {
    const GltfElement orthographic = from.member("orthographic");
    camera.orthographic = true;
    camera.half_width = std::abs(orthographic.number("xmag"));
    camera.half_height = std::abs(orthographic.number("ymag"));
    if (!(camera.half_width > 0 && camera.half_height > 0)) orthographic.fail("xmag or ymag is 0");
    camera.near = orthographic.number_between("znear", 0, 1e12);
    camera.far = orthographic.number_between("zfar", 0, 1e12);
    if (!(*camera.far > *camera.near)) orthographic.fail("zfar is not beyond znear");
  } else if (type == "perspective") {
    const GltfElement perspective = from.member("perspective");
    camera.vertical_fov_degrees = perspective.number_between("yfov", 1e-4, kPi - 1e-4) * 180 / kPi;
    camera.near = perspective.number_between("znear", 1e-9, 1e12);
  } else {
    from.member("type").fail("neither perspective nor orthographic");
  }
  model.camera = camera;
}

void GltfScene::note_what_is_ignored(Model& model) const {
  for (const GltfElement& used : document_.root().elements("extensionsUsed")) {
    const std::string name = used.as_text();
    if (std::ranges::find(kSupported, name) == std::end(kSupported) && name != "KHR_texture_basisu") {
      model.notices.push_back("ignored: extension " + to_utf8(name));
    }
  }
  if (const std::size_t animations = document_.count("animations"); animations > 1) {
    model.notices.push_back(fmt::format("ignored: {} other animations; the first is played", animations - 1));
  }
  std::size_t suns = 0, cameras = 0;
  for (const GltfPlace& place : placed_nodes(document_, nodes_, roots_)) {
    cameras += camera_of_node_[place.node] ? 1 : 0;
    if (!light_of_node_[place.node]) continue;
    const GltfElement light =
        document_.root().extension("KHR_lights_punctual")->member("lights").element(*light_of_node_[place.node]);
    suns += light.text("type") == "directional" ? 1 : 0;
  }
  if (suns > 1)
    model.notices.push_back(fmt::format("ignored: {} directional lights; the brightest is the sun", suns - 1));
  if (cameras > 1) model.notices.push_back(fmt::format("ignored: {} other cameras; the first is used", cameras - 1));
}

}  // namespace

Model load_gltf(const AssetSource& source, const std::string& name) {
  Model model;
  model.name = to_utf8(std::filesystem::path(name).stem().string());
  const auto scene = std::make_shared<GltfScene>(source, name);
  scene->load(model);
  if (scene->moves()) model.animation = scene;
  return model;
}

}  // namespace subpixel::capture
