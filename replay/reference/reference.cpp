#include "replay/reference/reference.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "replay/reference/texture_table.hpp"
#include "replay/reference/triangle_list.hpp"
#include "replay/reference/turns.hpp"
#include "replay/results/limits.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kGroupSide = 8;  // of the compute passes' workgroups

std::uint32_t groups(std::uint32_t pixels) {
  return (pixels + kGroupSide - 1) / kGroupSide;
}

template <typename T>
gpu::Buffer filled(gpu::Device& device, const char* name, const std::vector<T>& values) {
  gpu::Buffer buffer(device, name, values.size() * sizeof(T));
  std::copy(values.begin(), values.end(), buffer.as<T>().begin());
  return buffer;
}

Image image_of(const gpu::Buffer& pixels, std::uint32_t width, std::uint32_t height, Encoding encoding) {
  Image image(width, height, 3, encoding);
  const auto from = pixels.as<float>();
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) std::copy_n(&from[4 * i], 3, &image.pixels[3 * i]);
  return image;
}

// What one reference is made with; the passes refer to it.
struct Work {
  std::vector<TriangleRun> runs;
  gpu::Buffer corners, triangles, turn, sums, compensation, display_sums, story;
  TextureTable textures;
};

// Of every pass; `sums`: of one that adds to them.
gpu_types::ReferencePush push_of(gpu::AddressUses& pass, GpuScene& scene, Work& work, bool sums) {
  const auto sum = [&](gpu::Buffer& buffer) { return sums ? pass.writes(buffer) : 0; };
  return {.corners = pass.reads(work.corners),
          .triangles = pass.reads(work.triangles),
          .indices = pass.reads(scene.indices),
          .normals = pass.reads(scene.normals),
          .uvs = pass.reads(scene.uvs),
          .tangents = pass.reads(scene.tangents),
          .instances = pass.reads(scene.instances),
          .texels = pass.reads(work.textures.texels),
          .sums = sum(work.sums),
          .compensation = sum(work.compensation),
          .display_sums = sum(work.display_sums),
          .second_uvs = pass.reads(scene.second_uvs),
          .colours = pass.reads(scene.colours)};
}

std::vector<gpu::Binding> bindings_of(GpuScene& scene, Work& work) {
  return {gpu::uniform(scene.frame_constants),
          gpu::reads(REFERENCE_SLOT_TURN, work.turn),
          gpu::reads(REFERENCE_SLOT_LEVELS, work.textures.levels),
          gpu::reads(REFERENCE_SLOT_MATERIAL_TEXTURES, work.textures.materials),
          gpu::reads(FRAME_SLOT_MATERIALS, scene.materials),
          gpu::reads(FRAME_SLOT_UV_MAPPINGS, scene.uv_mappings)};
}

gpu::RasterPass visibility_pass(GpuScene& scene, Work& work, gpu::Image& seen, gpu::Image& depth, std::uint32_t side) {
  gpu::RasterPass pass;
  pass.name = "reference visibility";
  pass.pipeline.vertex = "reference/visibility.vert";
  pass.pipeline.fragment = "reference/visibility.frag:SOLID";
  pass.pipeline.constants = {{CONSTANT_FEATURES, scene.features().bits}, {REFERENCE_CONSTANT_SIDE, side}};
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_GREATER;  // of equal depths the first stays
  pass.pipeline.depth_write = true;
  pass.colours = {seen};
  pass.depth = &depth;
  pass.clear_colours = {{0, 0, 0, 0}};
  pass.clear_depth = 0;
  pass.bindings = bindings_of(scene, work);
  pass.push = gpu::PushConstants(push_of(pass, scene, work, false));
  pass.alternatives = {pass.pipeline};
  pass.alternatives[0].fragment = "reference/visibility.frag:TESTED";
  pass.draws = [&work](gpu::DrawEncoder& encoder) {
    for (const auto& run : work.runs) {
      if (run.count == 0) continue;
      encoder.pipeline(run.tested ? 1 : 0);
      encoder.draw(3 * run.count, 1, 3 * run.first);
    }
  };
  return pass;
}

gpu::ComputePass pixel_pass(const char* name, const char* shader, GpuScene& scene, Work& work,
                            const ReferenceOptions& options, std::uint32_t side) {
  gpu::ComputePass pass;
  pass.name = name;
  pass.shader = shader;
  pass.constants = {{CONSTANT_FEATURES, scene.features().bits},
                    {CONSTANT_SHADING_MODEL, options.shading_model},
                    {REFERENCE_CONSTANT_TONE_MAP_SAMPLES, options.tone_map_samples ? 1u : 0u},
                    {REFERENCE_CONSTANT_SIDE, side},
                    {REFERENCE_CONSTANT_SHADE_ALL_SAMPLES, options.shade_all_samples ? 1u : 0u}};
  pass.bindings = bindings_of(scene, work);
  pass.bindings.push_back(gpu::reads(FRAME_SLOT_SPOT_CONES, scene.spot_cones));
  pass.bindings.push_back(gpu::reads(FRAME_SLOT_LIGHT_CELLS, scene.light_cells));
  pass.push = gpu::PushConstants(push_of(pass, scene, work, true));
  const auto& size = scene.constants().viewport;
  pass.groups = {groups(static_cast<std::uint32_t>(size.x)), groups(static_cast<std::uint32_t>(size.y)), 1};
  return pass;
}

// Moves what the turn's shading told to `told`.
void take_story(Work& work, std::uint32_t turn, PixelReference& told) {
  gpu_types::ReferenceStory& story = work.story.as<gpu_types::ReferenceStory>()[0];
  for (std::uint32_t i = 0; i < story.head.z; ++i) {
    const gpu_types::ReferenceShading& one = story.shading[i];
    const glm::uvec4 source = work.triangles.as<gpu_types::ReferenceTriangle>()[one.of.x].source;
    told.shadings.push_back({.turn = turn,
                             .samples = one.of.y,
                             .at = glm::vec2(one.at),
                             .first_index = source.x,
                             .instance = source.y,
                             .material = source.z,
                             .radiance = glm::vec3(one.radiance)});
  }
  story.head = {told.pixel, 0, 0};
}

}  // namespace

std::uint64_t reference_bytes(std::uint32_t samples, std::uint32_t width, std::uint32_t height, bool tone_map_samples) {
  // Triangles and depths of a turn's samples, and sums of four channels.
  const std::uint64_t side = turn_side(samples, width, height);
  return std::uint64_t{width} * height * (side * side * 2 * 4 + (tone_map_samples ? 3 : 2) * 16);
}

ReferenceImage render_reference(gpu::Device& device, GpuScene& scene, const ReferenceOptions& options,
                                const ReferenceProgress& progress) {
  kReferenceSamplesLimit.require(options.samples);
  if (options.samples == 0) throw UsageError("reference samples", "a reference of none was asked for", "samples");
  const auto width = static_cast<std::uint32_t>(scene.constants().viewport.x);
  const auto height = static_cast<std::uint32_t>(scene.constants().viewport.y);
  const std::uint64_t pixels = std::uint64_t{width} * height;
  const std::uint32_t side = turn_side(options.samples, width, height);

  Work work;
  {
    const TriangleList list = visible_triangles(scene);
    work.runs = list.runs;
    work.corners = filled(device, "reference corners", list.corners);
    work.triangles = filled(device, "reference triangles", list.triangles);
  }
  work.textures = make_texture_table(device, scene.capture());
  work.turn = gpu::Buffer(device, "reference turn", sizeof(gpu_types::TurnConstants));
  work.sums = gpu::Buffer(device, "reference sums", pixels * 16);
  work.compensation = gpu::Buffer(device, "reference compensation", pixels * 16);
  work.display_sums = gpu::Buffer(device, "reference display sums", options.tone_map_samples ? pixels * 16 : 0);

  gpu::PassRecorder turns(device), finish(device);
  gpu::ImageDescription target;
  target.width = side * width;
  target.height = side * height;
  target.name = "reference triangles seen";
  target.format = VK_FORMAT_R32_UINT;
  target.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  gpu::Image& seen = turns.image(target);
  target.name = "reference depth";
  target.format = VK_FORMAT_D32_SFLOAT;
  target.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  gpu::Image& depth = turns.image(target);

  device.ledger().require("reference", work.sums.bytes() + work.compensation.bytes() + work.display_sums.bytes());
  turns.raster(visibility_pass(scene, work, seen, depth, side));
  gpu::ComputePass accumulate =
      pixel_pass("reference shading", options.story ? "reference/accumulate.comp:STORY" : "reference/accumulate.comp",
                 scene, work, options, side);
  if (options.story != nullptr) {
    work.story = gpu::Buffer(device, "reference story", sizeof(gpu_types::ReferenceStory));
    work.story.as<gpu_types::ReferenceStory>()[0].head = {options.story->pixel, 0, 0};
    accumulate.bindings.push_back(gpu::writes(REFERENCE_SLOT_STORY, work.story));
  }
  accumulate.bindings.push_back(gpu::samples(REFERENCE_SLOT_SEEN, seen));
  accumulate.bindings.push_back(gpu::samples(FRAME_SLOT_SHADOW_MAP, scene.shadow_map, &scene.shadow_sampler));
  turns.compute(std::move(accumulate));
  finish.compute(pixel_pass("reference mean", "reference/finish.comp", scene, work, options, side));

  const auto constants = turn_constants(options.samples / (side * side), side, width, height);
  for (std::uint32_t i = 0; i < constants.size(); ++i) {
    work.turn.as<gpu_types::TurnConstants>()[0] = constants[i];
    turns.run();
    if (options.story != nullptr) take_story(work, i, *options.story);
    if (progress) progress(i + 1, static_cast<std::uint32_t>(constants.size()));
  }
  finish.run();
  return {image_of(work.sums, width, height, Encoding::linear),
          image_of(work.compensation, width, height, Encoding::display)};
}

}  // namespace subpixel::replay
