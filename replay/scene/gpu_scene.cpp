#include "replay/scene/gpu_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

#include "base/error.hpp"
#include "capture_format/streams.hpp"
#include "replay/gpu/material_sets.hpp"
#include "replay/results/limits.hpp"
#include "replay/scene/frame_points.hpp"
#include "replay/scene/light_cells.hpp"
#include "replay/scene/materials.hpp"
#include "replay/scene/shadow_pass.hpp"
#include "replay/scene/textures.hpp"

namespace subpixel::replay {
namespace {

struct FeatureName {
  std::uint32_t bit;
  const char* name;
};
constexpr FeatureName kFeatureNames[] = {
    {FEATURE_BASE_TEXTURE, "textures"},
    {FEATURE_ALPHA_TEST, "alpha test"},
    {FEATURE_NORMAL_MAP, "normal maps"},
    {FEATURE_ROUGHNESS_TEXTURE, "roughness textures"},
    {FEATURE_EMISSIVE, "emission"},
    {FEATURE_EMISSIVE_TEXTURE, "emission textures"},
    {FEATURE_METAL, "metal"},
    {FEATURE_TWO_SIDED, "two-sided"},
    {FEATURE_SUN, "sun"},
    {FEATURE_SHADOWS, "shadows"},
    {FEATURE_POINT_LIGHTS, "point lights"},
    {FEATURE_VARYING_ROUGHNESS, "varying roughness"},
    {FEATURE_SAMPLERS, "samplers"},
    {FEATURE_SECOND_UV, "second texture coordinates"},
    {FEATURE_TEXTURE_TRANSFORM, "texture transforms"},
    {FEATURE_VERTEX_COLOUR, "vertex colours"},
    {FEATURE_NORMAL_SCALE, "normal map scales"},
    {FEATURE_UNLIT, "unlit materials"},
    {FEATURE_SPOT_LIGHTS, "spot lights"},
};

gpu_types::InstanceRecord instance_record(const glm::dmat4& world) {
  gpu_types::InstanceRecord record{};
  const glm::dmat4 rows = glm::transpose(world);
  for (int r = 0; r < 3; ++r) record.world_row[r] = glm::vec4(rows[r]);
  // The inverse transpose is the cofactor matrix over the determinant. Only directions matter, so the cofactors are
  // scaled to 1 instead, which keeps flat and tiny transforms usable.
  const glm::dvec3 a(rows[0]), b(rows[1]), c(rows[2]);
  glm::dvec3 cofactors[3] = {glm::cross(b, c), glm::cross(c, a), glm::cross(a, b)};
  const bool mirrored = glm::dot(a, cofactors[0]) < 0;
  double largest = 0;
  for (const auto& row : cofactors)
    for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(row[i]));
  const double scale = largest > 0 ? (mirrored ? -1 : 1) / largest : 1;
  for (int r = 0; r < 3; ++r) record.normal_row[r] = glm::vec4(glm::vec3(cofactors[r] * scale), 0);
  record.normal_row[0].w = mirrored ? -1.0f : 1.0f;
  return record;
}

// Samplers of the same values are one.
using SamplerKey = std::array<std::uint32_t, 5>;
SamplerKey key_of(const capture::Sampler& sampler) {
  return {static_cast<std::uint32_t>(sampler.wrap_u), static_cast<std::uint32_t>(sampler.wrap_v),
          static_cast<std::uint32_t>(sampler.magnify), static_cast<std::uint32_t>(sampler.minify),
          static_cast<std::uint32_t>(sampler.mip)};
}

VkSamplerAddressMode address_mode(capture::Wrap wrap) {
  switch (wrap) {
    case capture::Wrap::repeat:
      return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    case capture::Wrap::clamp_to_edge:
      return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    case capture::Wrap::mirrored_repeat:
      return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
  }
  return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

gpu::SamplerDescription description_of(const capture::Sampler& sampler) {
  const auto filter = [](capture::TexelFilter of) {
    return of == capture::TexelFilter::nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  };
  // A texture without mipmaps has no other level to read (load_texture()).
  const bool blends_levels =
      sampler.mip == capture::MipFilter::linear || sampler.mip == capture::MipFilter::linear_of_means;
  return {filter(sampler.magnify), filter(sampler.minify),
          blends_levels ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST, address_mode(sampler.wrap_u),
          address_mode(sampler.wrap_v)};
}

glm::vec4 vec4_of(const capture::Float3& v, float w = 0) {
  return {v[0], v[1], v[2], w};
}

}  // namespace

std::vector<std::string> SceneFeatures::names() const {
  std::vector<std::string> names;
  for (const auto& feature : kFeatureNames)
    if (has(feature.bit)) names.emplace_back(feature.name);
  return names;
}

struct GpuScene::Impl {
  SceneOptions options;
  GeometryPlan plan;
  std::vector<Bounds> mesh_bounds;
  std::vector<capture::PointLight> placed;
  std::vector<MaterialUse> uses;                 // of each material
  std::map<std::uint32_t, gpu::Image> textures;  // by capture number
  gpu::Image white;
  std::map<SamplerKey, gpu::Sampler> samplers;
  std::unique_ptr<gpu::MaterialSets> sets;
  std::vector<VkDescriptorSet> set_of_material;
  Camera camera;                        // of the current frame
  std::vector<Bounds> instance_bounds;  // of the current frame, world space
  std::uint64_t triangle_count = 0;

  void upload_textures(gpu::Device& device, const capture::Capture& capture);
  void make_sets(gpu::Device& device, const capture::Capture& capture);
  std::vector<capture::PointLight> lights_of(const capture::Frame& frame) const;
};

namespace {

gpu::Image upload_mipmaps(gpu::Device& device, const std::string& name, const Mipmaps& mipmaps) {
  gpu::ImageDescription description;
  description.name = name;
  description.format = mipmaps.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
  description.width = mipmaps.width;
  description.height = mipmaps.height;
  description.mips = static_cast<std::uint32_t>(mipmaps.levels.size());
  description.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  gpu::Image image(device, description);
  for (std::uint32_t mip = 0; mip < description.mips; ++mip)
    gpu::upload(device, image, mip, 0, std::as_bytes(std::span(mipmaps.levels[mip])));
  return image;
}

}  // namespace

void GpuScene::Impl::upload_textures(gpu::Device& device, const capture::Capture& capture) {
  for (const auto& use : texture_uses(capture))
    textures.emplace(use.texture, upload_mipmaps(device, "texture " + capture.textures[use.texture].name,
                                                 load_texture(capture, use)));
  white = upload_mipmaps(device, "white", {1, 1, false, {{255, 255, 255, 255}}});
}

void GpuScene::Impl::make_sets(gpu::Device& device, const capture::Capture& capture) {
  const auto sampler_of = [&](const capture::Sampler& captured) {
    const auto [at, is_new] = samplers.try_emplace(key_of(captured));
    if (is_new) at->second = gpu::Sampler(device, description_of(captured));
    return &at->second;
  };
  sets = std::make_unique<gpu::MaterialSets>(device, static_cast<std::uint32_t>(capture.materials.size()) + 1);
  for (const auto& material : capture.materials) {
    std::array<gpu::MaterialTexture, gpu::kMaterialTextures> seen{};
    const auto numbers = textures_of(material);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const auto found = textures.find(numbers[i]);
      const bool absent = found == textures.end();
      seen[i] = {absent ? &white : &found->second,
                 sampler_of(absent ? capture::Sampler{} : capture.textures[numbers[i]].sampler)};
    }
    set_of_material.push_back(sets->set_of(seen));
  }
}

std::vector<capture::PointLight> GpuScene::Impl::lights_of(const capture::Frame& frame) const {
  auto lights = frame.point_lights;
  if (!options.point_lights) return lights;
  const std::size_t count = *options.point_lights, captured = std::min(lights.size(), count);
  lights.resize(captured);
  if (captured < count)
    lights.insert(lights.end(), placed.begin() + static_cast<std::ptrdiff_t>(std::min(captured, placed.size())),
                  placed.end());
  return lights;
}

GpuScene::GpuScene(gpu::Device& device, const capture::Capture& capture, const SceneOptions& options)
    : device_(device), capture_(capture), impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  if (options.point_lights) kPointLightsLimit.require(*options.point_lights);
  const PointLights lights = !options.point_lights        ? PointLights::captured
                             : *options.point_lights == 0 ? PointLights::none
                                                          : PointLights::some;
  features_.bits = detect_features(capture, lights) | options.forced_features;

  constexpr std::uint32_t kAnyTexture =
      FEATURE_BASE_TEXTURE | FEATURE_ROUGHNESS_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_EMISSIVE_TEXTURE;
  auto& plan = impl_->plan;
  plan = plan_geometry(capture, {features_.has(kAnyTexture), features_.has(FEATURE_NORMAL_MAP),
                                 features_.has(FEATURE_SECOND_UV), features_.has(FEATURE_VERTEX_COLOUR)});
  const std::uint64_t vertices = plan.vertex_count;
  positions = gpu::Buffer(device, "positions", vertices * 12);
  normals = gpu::Buffer(device, "normals", vertices * 12);
  uvs = gpu::Buffer(device, "texture coordinates", plan.needs.uvs ? vertices * 8 : 0);
  tangents = gpu::Buffer(device, "tangents", plan.needs.tangents ? vertices * 16 : 0);
  second_uvs = gpu::Buffer(device, "second texture coordinates", plan.needs.second_uvs ? vertices * 8 : 0);
  colours = gpu::Buffer(device, "vertex colours", plan.needs.colours ? vertices * 16 : 0);
  indices = gpu::Buffer(device, "indices", plan.index_count * 4);
  impl_->mesh_bounds = fill_geometry(capture, plan,
                                     {positions.as<float>(), normals.as<float>(), uvs.as<float>(), tangents.as<float>(),
                                      indices.as<std::uint32_t>(), second_uvs.as<float>(), colours.as<float>()});

  std::size_t most_instances = 0;
  for (const auto& frame : capture.frames) {
    std::size_t frame_instances = 0;
    for (const auto& draw : frame.draws) frame_instances += draw.instance_count;
    most_instances = std::max(most_instances, frame_instances);
  }
  instances = gpu::Buffer(device, "instances", most_instances * sizeof(gpu_types::InstanceRecord));
  frame_constants = gpu::Buffer(device, "frame constants", sizeof(gpu_types::FrameConstants));
  materials = gpu::Buffer(device, "materials", capture.materials.size() * sizeof(gpu_types::MaterialRecord));
  impl_->uses = material_uses(capture);
  const bool transformed_uvs = features_.has(FEATURE_TEXTURE_TRANSFORM);
  uv_mappings = gpu::Buffer(device, "uv mappings",
                            transformed_uvs ? capture.materials.size() * 4 * sizeof(gpu_types::UvMappingRecord) : 0);
  for (std::uint32_t m = 0; m < capture.materials.size(); ++m) {
    materials.as<gpu_types::MaterialRecord>()[m] = record_of(capture.materials[m], m, impl_->uses[m]);
    if (transformed_uvs)
      std::ranges::copy(mapping_records_of(capture.materials[m]),
                        uv_mappings.as<gpu_types::UvMappingRecord>().begin() + std::ptrdiff_t{4} * m);
  }
  spot_cones = gpu::Buffer(
      device, "spot cones",
      features_.has(FEATURE_SPOT_LIGHTS) ? SUBPIXEL_MAX_POINT_LIGHTS * sizeof(gpu_types::SpotConeConstants) : 0);
  light_cells = gpu::Buffer(device, "light cells",
                            features_.has(FEATURE_POINT_LIGHTS) ? kMostLightWords * sizeof(std::uint32_t) : 0);
  impl_->upload_textures(device, capture);
  impl_->make_sets(device, capture);

  gpu::ImageDescription shadow;
  shadow.name = "shadow map";
  shadow.format = VK_FORMAT_D32_SFLOAT;
  shadow.width = shadow.height = features_.has(FEATURE_SHADOWS) ? options.shadow_map_size : 1;
  shadow.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  shadow_map = gpu::Image(device, shadow);
  shadow_sampler = gpu::Sampler(device, gpu::kNearestClamped);

  if (lights == PointLights::some) {
    std::vector<LightStage> stages;
    Bounds all;
    for (const std::uint32_t frame : light_stage_frames(capture.frames.size())) {
      stages.push_back(light_stage(capture, frame, plan, positions.as<float>(), indices.as<std::uint32_t>()));
      const auto& draws = capture.frames[frame].draws;
      for (std::size_t d = 0; d < draws.size(); ++d)
        for (const auto& world : capture::world_transforms(capture, draws[d]))
          all.add(transformed(impl_->mesh_bounds[plan.mesh_of_draw[frame][d]], matrix(world)));
    }
    impl_->placed = placed_lights(0, *options.point_lights, stages, all);
  }
}

GpuScene::~GpuScene() = default;

void GpuScene::set_frame(std::uint32_t index, std::uint32_t width, std::uint32_t height) {
  if (index >= capture_.frames.size())
    throw UsageError("frame", fmt::format("the capture has {}", capture_.frames.size()),
                     fmt::format("frame {}", index));
  const auto& frame = capture_.frames[index];
  draws_.clear();
  impl_->instance_bounds.clear();
  impl_->triangle_count = 0;
  Bounds bounds;
  std::uint32_t instance = 0;
  const auto records = instances.as<gpu_types::InstanceRecord>();
  for (std::size_t d = 0; d < frame.draws.size(); ++d) {
    const auto& draw = frame.draws[d];
    const std::uint32_t mesh_number = impl_->plan.mesh_of_draw[index][d];
    const auto& mesh = impl_->plan.meshes[mesh_number];
    if (mesh.triangle_count == 0 || draw.instance_count == 0) continue;
    draws_.push_back({draw.material, mesh.first_index, mesh.triangle_count, instance, draw.instance_count});
    impl_->triangle_count += capture::triangle_count(draw);
    for (const auto& transform : capture::world_transforms(capture_, draw)) {
      const glm::dmat4 world = matrix(transform);
      records[instance++] = instance_record(world);
      impl_->instance_bounds.push_back(transformed(impl_->mesh_bounds[mesh_number], world));
      bounds.add(impl_->instance_bounds.back());
    }
  }

  const Camera camera = camera_of(frame, index);
  auto& value = constants_value_;
  value = {};
  impl_->camera = camera;
  value.view_projection = glm::mat4(camera.view_projection);
  value.inverse_view_projection = glm::mat4(camera.inverse_view_projection);
  value.view = glm::mat4(camera.view);
  value.eye = glm::vec4(glm::vec3(camera.eye), 1);
  value.ambient = vec4_of(frame.ambient);
  value.sky = vec4_of(frame.sky, 1);
  value.viewport = {static_cast<float>(width), static_cast<float>(height), 1.0f / static_cast<float>(width),
                    1.0f / static_cast<float>(height)};
  value.band = {0, height, 0, 0};
  value.tone.x = frame.exposure;
  const auto lit =
      std::ranges::find_if(draws_, [this](const DrawItem& draw) { return !capture_.materials[draw.material].unlit; });
  if (lit != draws_.end()) value.tone.y = capture_.materials[lit->material].roughness;
  if (!impl_->options.point_lights) require_few_lights(frame, index);
  const auto captured_lights = impl_->lights_of(frame);
  const auto lights = light_constants(captured_lights);
  std::copy(lights.begin(), lights.end(), value.point_lights);
  if (features_.has(FEATURE_SPOT_LIGHTS))
    std::ranges::copy(cone_constants(captured_lights), spot_cones.as<gpu_types::SpotConeConstants>().begin());
  if (features_.has(FEATURE_POINT_LIGHTS)) {
    const LightCells cells =
        impl_->options.every_light ? one_light_cell(lights.size()) : replay::light_cells(lights, value.view_projection);
    value.light_cells = cells.constants;
    std::ranges::copy(cells.lights, light_cells.as<std::uint32_t>().begin());
  }
  value.counts = {static_cast<std::uint32_t>(lights.size()), static_cast<std::uint32_t>(capture_.materials.size()),
                  instance, 0};

  value.sun_direction = {0, -1, 0, 0};
  // Cascades that hold no point: everything is beside them, and so lit.
  value.shadow_matrix = glm::mat4(1);
  for (auto& cascade : value.shadow_cascades) cascade = {0, -1, -1, 0};
  std::optional<ShadowFit> fit;
  if (frame.sun) {
    const glm::dvec3 direction(frame.sun->direction[0], frame.sun->direction[1], frame.sun->direction[2]);
    const double length = glm::length(direction);
    if (length > 1e-9 && std::isfinite(length)) {
      value.sun_direction = glm::vec4(glm::vec3(direction / length), 0);
      value.sun_irradiance = vec4_of(frame.sun->irradiance);
      if (frame.sun->shadows && features_.has(FEATURE_SHADOWS))
        fit = fit_shadow(camera, bounds, direction, impl_->options.shadow_map_size / 2);
    }
  }
  if (fit) {
    value.shadow_matrix = glm::mat4(fit->world_to_light);
    value.sun_direction.w = static_cast<float>(fit->depth_per_unit);
    for (std::size_t c = 0; c < fit->cascades.size(); ++c) {
      const auto& cascade = fit->cascades[c];
      value.shadow_cascades[c] = glm::vec4(cascade.scale, cascade.offset, cascade.texel);
    }
  }
  frame_constants.as<gpu_types::FrameConstants>()[0] = value;
  if (fit) render_shadow_map(device_, *this, impl_->instance_bounds, *fit);
}

void GpuScene::set_jitter(const glm::dvec2& jitter) {
  auto& value = constants_value_;
  const glm::dvec2 size(value.viewport.x, value.viewport.y);
  value.view_projection = glm::mat4(moved_image(-jitter, size) * impl_->camera.view_projection);
  value.inverse_view_projection = glm::mat4(impl_->camera.inverse_view_projection * moved_image(jitter, size));
  frame_constants.as<gpu_types::FrameConstants>()[0] = value;
}

void GpuScene::set_band(std::uint32_t first, std::uint32_t rows) {
  constants_value_.band = {first, rows, 0, 0};
  frame_constants.as<gpu_types::FrameConstants>()[0] = constants_value_;
}

std::uint64_t GpuScene::triangle_count() const {
  return impl_->triangle_count;
}

VkDescriptorSet GpuScene::material_set(std::uint32_t material) const {
  return impl_->set_of_material[material];
}

bool GpuScene::alpha_tested(std::uint32_t material) const {
  return is_alpha_tested(capture_.materials[material], impl_->uses[material].translucent_vertices);
}

bool GpuScene::two_sided(std::uint32_t material) const {
  return capture_.materials[material].two_sided;
}

bool GpuScene::second_uv_of_base(std::uint32_t material) const {
  return features_.has(FEATURE_SECOND_UV) && capture_.materials[material].base_colour_uv.set != 0;
}

bool GpuScene::has_textures(std::uint32_t material) const {
  const auto numbers = textures_of(capture_.materials[material]);
  return std::any_of(numbers.begin(), numbers.end(), [](std::uint32_t number) { return number != capture::kNone; });
}

std::uint64_t GpuScene::bytes() const {
  std::uint64_t total = shadow_map.bytes() + impl_->white.bytes();
  for (const gpu::Buffer* buffer : {&positions, &normals, &uvs, &tangents, &second_uvs, &colours, &indices, &instances,
                                    &materials, &uv_mappings, &spot_cones, &light_cells, &frame_constants})
    total += buffer->bytes();
  for (const auto& [number, image] : impl_->textures) total += image.bytes();
  return total;
}

}  // namespace subpixel::replay
