#include "replay/frontend/frontend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>

#include "base/error.hpp"
#include "replay/frontend/count_image.hpp"
#include "replay/frontend/host_setup.hpp"
#include "replay/frontend/list_passes.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kChunk = SUBPIXEL_CHUNK_TRIANGLES;
// A dispatch may have at least this many groups in each dimension (Vulkan's required limit).
constexpr std::uint32_t kMaxGroups = 65535;

std::uint32_t groups_of(std::uint64_t items, std::uint32_t size) {
  return static_cast<std::uint32_t>((items + size - 1) / size);
}

}  // namespace

SetupPlace setup_place(const gpu::Device& device) {
  return device.info().is_cpu || !device.info().doubles ? SetupPlace::host : SetupPlace::device;
}

gpu::Constants Frontend::constants() const {
  return {{CONSTANT_SAMPLES, samples_}, {CONSTANT_FEATURES, scene_.features().bits}};
}

std::uint64_t Frontend::allocated_bytes() const {
  std::uint64_t total = 0;
  for (const gpu::Buffer* buffer :
       {&chunks_, &clip_matrices_, &counts_, &clip_list_, &clip_count_, &sums_, &piece_bases_, &records_,
        &hull_indices_, &material_ranges_, &visibility_ranges_, &material_commands_, &visibility_commands_, &rest_sums_,
        &rest_indices_, &rest_commands_, &small_records_})
    total += buffer->bytes();
  return total;
}

void Frontend::build_chunks() {
  std::vector<gpu_types::ChunkRecord> chunks;
  material_batches_.clear();
  visibility_batches_.clear();
  for (const DrawItem& draw : scene_.draws()) {
    const auto first_chunk = static_cast<std::uint32_t>(chunks.size());
    const bool alpha = scene_.alpha_tested(draw.material);
    const std::uint32_t flags =
        (scene_.two_sided(draw.material) ? 0u : CHUNK_CULL_BACK) | (alpha ? CHUNK_ALPHA_TEST : 0u);
    for (std::uint32_t instance = 0; instance < draw.instance_count; ++instance)
      for (std::uint32_t first = 0; first < draw.triangle_count; first += kChunk)
        chunks.push_back({{draw.first_index + 3 * first, std::min(kChunk, draw.triangle_count - first),
                           draw.first_instance + instance, draw.material},
                          {flags, 0, 0, 0}});
    const auto last_chunk = static_cast<std::uint32_t>(chunks.size());
    if (first_chunk == last_chunk) continue;
    const auto extend = [&](std::vector<Batch>& batches, bool same_kind) {
      if (!batches.empty() && same_kind)
        batches.back().last_chunk = last_chunk;
      else
        batches.push_back({first_chunk, last_chunk, draw.material, alpha});
    };
    extend(material_batches_, !material_batches_.empty() && material_batches_.back().material == draw.material);
    // Depth alone needs a material's textures only where they decide coverage.
    extend(visibility_batches_, !visibility_batches_.empty() && visibility_batches_.back().alpha_test == alpha &&
                                    (!alpha || visibility_batches_.back().material == draw.material));
  }
  constexpr std::size_t kMostChunks = 0x7fffffffu / 4 / kChunk;  // corner numbers of all records stay within 32 bits
  if (chunks.size() > kMostChunks)
    throw DeviceError(
        "front-end",
        fmt::format("{} groups of {} triangles are over the limit of {}", chunks.size(), kChunk, kMostChunks),
        "frame's draws");
  chunk_count_ = static_cast<std::uint32_t>(chunks.size());
  chunks_ = gpu::Buffer(device_, "chunks", chunks.size() * sizeof(gpu_types::ChunkRecord));
  std::copy(chunks.begin(), chunks.end(), chunks_.as<gpu_types::ChunkRecord>().begin());

  const auto upload_ranges = [&](const std::vector<Batch>& batches, gpu::Buffer& ranges, gpu::Buffer& commands,
                                 const char* name) {
    ranges = gpu::Buffer(device_, std::string(name) + " batches", batches.size() * sizeof(glm::uvec2));
    for (std::size_t i = 0; i < batches.size(); ++i)
      ranges.as<glm::uvec2>()[i] = {batches[i].first_chunk, batches[i].last_chunk};
    commands =
        gpu::Buffer(device_, std::string(name) + " draws", batches.size() * sizeof(VkDrawIndexedIndirectCommand));
  };
  upload_ranges(material_batches_, material_ranges_, material_commands_, "material");
  upload_ranges(visibility_batches_, visibility_ranges_, visibility_commands_, "visibility");
}

void Frontend::build_clip_matrices() {
  // In doubles, so that a scene far from the origin keeps its sub-pixel positions.
  const auto instances = scene_.instances.as<gpu_types::InstanceRecord>();
  const std::uint32_t count = scene_.constants().counts.z;
  clip_matrices_ = gpu::Buffer(device_, "clip matrices", std::uint64_t{count} * sizeof(glm::mat4));
  const glm::dmat4 view_projection(scene_.constants().view_projection);
  for (std::uint32_t i = 0; i < count; ++i) {
    glm::dmat4 world(1.0);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        world[column][row] = static_cast<double>(instances[i].world_row[row][column]);
    clip_matrices_.as<glm::mat4>()[i] = glm::mat4(view_projection * world);
  }
}

void Frontend::prepare(std::uint32_t samples) {
  samples_ = samples;
  build_chunks();
  build_clip_matrices();
  const std::uint64_t slots = std::uint64_t{chunk_count_} * kChunk;
  counts_ = gpu::Buffer(device_, "counts", slots * sizeof(std::uint32_t));
  clip_list_ = gpu::Buffer(device_, "clip list", slots * sizeof(std::uint32_t));
  clip_count_ = gpu::Buffer(device_, "clip count", sizeof(std::uint32_t));
  sums_ = gpu::Buffer(device_, "chunk sums", (std::uint64_t{chunk_count_} + 1) * sizeof(glm::uvec4));
  piece_bases_ = gpu::Buffer(device_, "piece bases", slots * sizeof(std::uint32_t));
  records_ = gpu::Buffer(device_, "triangle records", slots * sizeof(gpu_types::TriangleRecord));
  hull_indices_ = gpu::Buffer(device_, "hull indices", 16);
  clipped_ = slots;  // of this run; the real number is known after it
  pieces_ = hulls_ = hull_triangles_ = 0;

  gpu::PassRecorder sizing(device_);
  record_culling(sizing);
  sizing.run();
  clipped_ = place_ == SetupPlace::host ? host_clipped_.size() : clip_count_.as<std::uint32_t>()[0];
  const glm::uvec4 totals = sums_.as<glm::uvec4>()[chunk_count_];
  hull_triangles_ = totals.x;
  pieces_ = totals.y;
  hulls_ = totals.z;
  small_count_ = totals.w;
  small_tested_ = small_blocks_ = 0;
  for (const std::uint32_t count : counts_.as<std::uint32_t>()) {
    small_tested_ += (count & COUNT_SMALL_TESTED) != 0 ? 1 : 0;
    if ((count & COUNT_SMALL) != 0) small_blocks_ += count >> COUNT_BLOCKS_SHIFT & COUNT_BLOCKS_MASK;
  }
  records_ = gpu::Buffer(device_, "triangle records", (slots + pieces_) * sizeof(gpu_types::TriangleRecord));
  hull_indices_ = gpu::Buffer(device_, "hull indices", hull_triangles_ * 3 * sizeof(std::uint32_t));
  rest_sums_ = gpu::Buffer(device_, "sums without small triangles", sums_.bytes());
  rest_indices_ = gpu::Buffer(device_, "hull indices without small triangles", hull_indices_.bytes());
  rest_commands_ = gpu::Buffer(device_, "draws without small triangles",
                               visibility_batches_.size() * sizeof(VkDrawIndexedIndirectCommand));
  small_records_ = gpu::Buffer(device_, "small triangles", small_count(true) * sizeof(std::uint32_t));
}

void Frontend::record_culling(gpu::PassRecorder& recorder) {
  if (place_ == SetupPlace::host)
    recorder.host_pass("setup", [this] {
      const auto records = records_.as<gpu_types::TriangleRecord>();
      host_clipped_ = set_up_on_host(host_input(), records, counts_.as<std::uint32_t>());
    });
  else
    record_triangles(recorder);

  gpu::ComputePass sum;
  sum.name = "setup";
  sum.shader = "frontend/chunk_sum.comp:ALL";
  sum.bindings = {gpu::reads(FRONTEND_SLOT_COUNTS, counts_), gpu::writes(FRONTEND_SLOT_SUMS, sums_)};
  const gpu_types::ChunkSumPush sum_push{chunk_count_, chunk_count_ * kChunk, COUNT_SMALL};
  sum.push = gpu::PushConstants(sum_push);
  sum.groups = {groups_of(chunk_count_, 64), 1, 1};
  recorder.compute(sum);

  record_scan(recorder, "setup", sums_, chunk_count_);
}

void Frontend::record_triangles(gpu::PassRecorder& recorder) {
  recorder.fill("setup", clip_count_, 0);
  gpu::ComputePass pass;
  pass.name = "setup";
  pass.shader = "frontend/setup.comp";
  pass.constants = constants();
  pass.bindings = {gpu::uniform(scene_.frame_constants), gpu::reads(FRONTEND_SLOT_CHUNKS, chunks_),
                   gpu::writes(FRONTEND_SLOT_COUNTS, counts_), gpu::writes(FRONTEND_SLOT_CLIP_LIST, clip_list_),
                   gpu::writes(FRONTEND_SLOT_CLIP_COUNT, clip_count_)};
  pass.push = gpu::PushConstants(setup_push(pass));
  pass.groups = {std::min(chunk_count_, kMaxGroups), groups_of(chunk_count_, kMaxGroups), 1};
  recorder.compute(pass);

  pass.shader = "frontend/clip.comp:COUNT";
  pass.bindings = clip_bindings();
  pass.groups = {groups_of(clipped_, 64), 1, 1};
  recorder.compute(std::move(pass));
}

HostSetupInput Frontend::host_input() const {
  return {.frame = scene_.constants(),
          .samples = samples_,
          .chunks = chunks_.as<gpu_types::ChunkRecord>().first(chunk_count_),
          .positions = scene_.positions.as<glm::vec3>(),
          .indices = scene_.indices.as<std::uint32_t>(),
          .clip_matrices = clip_matrices_.as<glm::mat4>(),
          .instances = scene_.instances.as<gpu_types::InstanceRecord>()};
}

void Frontend::record_setup(gpu::PassRecorder& recorder) {
  record_culling(recorder);

  gpu::ComputePass emit;
  emit.name = "setup";
  emit.shader = "frontend/emit.comp:ALL";
  emit.bindings = {gpu::reads(FRONTEND_SLOT_COUNTS, counts_), gpu::reads(FRONTEND_SLOT_SUMS, sums_),
                   gpu::writes(FRONTEND_SLOT_HULL_INDICES, hull_indices_),
                   gpu::writes(FRONTEND_SLOT_PIECE_BASES, piece_bases_)};
  const gpu_types::EmitPush emit_push{chunk_count_, chunk_count_ * kChunk, static_cast<std::uint32_t>(hull_triangles_),
                                      0, 0};
  emit.push = gpu::PushConstants(emit_push);
  emit.groups = {groups_of(chunk_count_, 64), 1, 1};
  recorder.compute(emit);

  if (place_ == SetupPlace::host) {
    recorder.host_pass("setup", [this] {
      const auto pieces = records_.as<gpu_types::TriangleRecord>().subspan(triangle_slots());
      emit_pieces_on_host(host_input(), host_clipped_, piece_bases_.as<std::uint32_t>(), pieces);
    });
  } else if (clipped_ > 0) {
    gpu::ComputePass clip;
    clip.name = "setup";
    clip.shader = "frontend/clip.comp:EMIT";
    clip.constants = constants();
    clip.bindings = clip_bindings();
    clip.push = gpu::PushConstants(setup_push(clip));
    clip.groups = {groups_of(clipped_, 64), 1, 1};
    recorder.compute(clip);
  }

  record_arguments(recorder, "setup", material_batches_.size(), material_ranges_, sums_, material_commands_);
  record_arguments(recorder, "setup", visibility_batches_.size(), visibility_ranges_, sums_, visibility_commands_);
}

void Frontend::record_small_list(gpu::PassRecorder& recorder, const std::string& name, bool with_tested) {
  const std::uint32_t small_bits = COUNT_SMALL | (with_tested ? COUNT_SMALL_TESTED : 0);
  gpu::ComputePass pass;
  pass.name = name;
  pass.shader = "frontend/chunk_sum.comp:REST";
  pass.bindings = {gpu::reads(FRONTEND_SLOT_COUNTS, counts_), gpu::writes(FRONTEND_SLOT_SUMS, rest_sums_)};
  const gpu_types::ChunkSumPush sum_push{chunk_count_, triangle_slots(), small_bits};
  pass.push = gpu::PushConstants(sum_push);
  pass.groups = {groups_of(chunk_count_, 64), 1, 1};
  recorder.compute(pass);
  record_scan(recorder, name, rest_sums_, chunk_count_);
  const gpu_types::EmitPush push{chunk_count_, triangle_slots(), static_cast<std::uint32_t>(hull_triangles_),
                                 static_cast<std::uint32_t>(small_count(with_tested)), small_bits};
  pass.push = gpu::PushConstants(push);
  pass.shader = "frontend/emit.comp:REST";
  pass.bindings = {gpu::reads(FRONTEND_SLOT_COUNTS, counts_), gpu::reads(FRONTEND_SLOT_SUMS, rest_sums_),
                   gpu::writes(FRONTEND_SLOT_HULL_INDICES, rest_indices_),
                   gpu::reads(FRONTEND_SLOT_PIECE_BASES, piece_bases_),
                   gpu::writes(FRONTEND_SLOT_SMALL_RECORDS, small_records_)};
  pass.groups = {groups_of(chunk_count_, 64), 1, 1};
  recorder.compute(pass);
  record_arguments(recorder, name, visibility_batches_.size(), visibility_ranges_, rest_sums_, rest_commands_);
}

void Frontend::record_arguments(gpu::PassRecorder& recorder, const std::string& name, std::size_t batches,
                                gpu::Buffer& ranges, gpu::Buffer& sums, gpu::Buffer& commands) {
  gpu::ComputePass pass;
  pass.name = name;
  pass.shader = "frontend/draw_arguments.comp";
  pass.bindings = {gpu::reads(FRONTEND_SLOT_BATCHES, ranges), gpu::reads(FRONTEND_SLOT_SUMS, sums),
                   gpu::writes(FRONTEND_SLOT_COMMANDS, commands)};
  pass.push = gpu::PushConstants(gpu_types::DrawArgumentsPush{static_cast<std::uint32_t>(batches)});
  pass.groups = {groups_of(batches, 64), 1, 1};
  recorder.compute(pass);
}

gpu_types::SetupPush Frontend::setup_push(gpu::AddressUses& pass) {
  return {.positions = pass.reads(scene_.positions),
          .indices = pass.reads(scene_.indices),
          .clip_matrices = pass.reads(clip_matrices_),
          .instances = pass.reads(scene_.instances),
          .records = pass.writes(records_),
          .chunk_count = chunk_count_,
          .triangle_slots = triangle_slots(),
          .piece_capacity = static_cast<std::uint32_t>(pieces_)};
}

std::vector<gpu::Binding> Frontend::clip_bindings() {
  return {gpu::uniform(scene_.frame_constants),
          gpu::reads(FRONTEND_SLOT_CHUNKS, chunks_),
          gpu::writes(FRONTEND_SLOT_COUNTS, counts_),
          gpu::reads(FRONTEND_SLOT_CLIP_LIST, clip_list_),
          gpu::reads(FRONTEND_SLOT_PIECE_BASES, piece_bases_),
          gpu::reads(FRONTEND_SLOT_CLIP_COUNT, clip_count_)};
}

gpu_types::HullPush Frontend::hull_push(gpu::AddressUses& pass, std::uint32_t material) {
  return {.records = pass.reads(records_),
          .positions = pass.reads(scene_.positions),
          .normals = pass.reads(scene_.normals),
          .uvs = pass.reads(scene_.uvs),
          .tangents = pass.reads(scene_.tangents),
          .indices = pass.reads(scene_.indices),
          .clip_matrices = pass.reads(clip_matrices_),
          .instances = pass.reads(scene_.instances),
          .second_uvs = pass.reads(scene_.second_uvs),
          .colours = pass.reads(scene_.colours),
          .material = material,
          .triangle_slots = triangle_slots(),
          .first_fragment = 0,
          .last_fragment = 0};
}

std::uint64_t Frontend::count_fragments(std::uint32_t width, std::uint32_t height, std::uint32_t first,
                                        std::uint32_t rows) {
  gpu::PassRecorder recorder(device_);
  gpu::Image& counts = recorder.image(count_image(width, height));
  GeometryPass geometry;
  geometry.fragment_opaque = geometry.fragment_alpha = "frontend/count_fragments.frag";
  geometry.pass.name = "fragments";
  geometry.pass.pipeline.constants = {{CONSTANT_ALPHA_MODE, ALPHA_MODE_TO_COVERAGE}};  // what triangles cover, whole
  geometry.pass.pipeline.additive = true;
  geometry.pass.pipeline.targets.clear = true;
  geometry.pass.colours = {{counts}};
  geometry.pass.clear_colours = {{}};
  record_geometry(recorder, std::move(geometry));
  recorder.run();
  const auto bytes = gpu::download(device_, counts);
  std::uint64_t total = 0;
  const std::size_t row_bytes = std::size_t{width} * sizeof(float);
  for (std::size_t at = first * row_bytes; at < (first + rows) * row_bytes; at += sizeof(float)) {
    float here = 0;
    std::memcpy(&here, bytes.data() + at, sizeof(here));
    total += static_cast<std::uint64_t>(here);
  }
  return total;
}

void Frontend::record_geometry(gpu::PassRecorder& recorder, GeometryPass geometry) {
  gpu::RasterPass& pass = geometry.pass;

  pass.pipeline.vertex = geometry.by_material ? "frontend/hull.vert:ATTRIBUTES" : "frontend/hull.vert:VISIBILITY";
  pass.pipeline.fragment = geometry.fragment_opaque;
  for (const auto& constant : constants()) pass.pipeline.constants.push_back(constant);
  if (!geometry.by_material) {
    gpu::RasterDescription& alpha = pass.alternatives.emplace_back(pass.pipeline);
    alpha.vertex = "frontend/hull.vert:ALPHA";
    alpha.fragment = geometry.fragment_alpha;
  }
  pass.bindings.push_back(gpu::uniform(scene_.frame_constants));
  pass.bindings.push_back(gpu::reads(FRAME_SLOT_UV_MAPPINGS, scene_.uv_mappings));
  pass.bindings.push_back(gpu::reads(FRAME_SLOT_MATERIALS, scene_.materials));
  pass.triangles = gpu::Triangles::all;
  const glm::uvec4 band = scene_.constants().band;
  const auto frame_rows = static_cast<std::uint32_t>(scene_.constants().viewport.y);
  if (geometry.rasterise_frame) {
    pass.size[1] = frame_rows;
    pass.scissor_rows = {band.x, band.y};
  } else {
    pass.first_row = band.x;
    pass.frame_rows = frame_rows;
  }
  gpu::Buffer& commands = geometry.without_small ? rest_commands_
                          : geometry.by_material ? material_commands_
                                                 : visibility_commands_;
  gpu::Buffer& indices = geometry.without_small ? rest_indices_ : hull_indices_;
  pass.indices_and_indirect = {&indices, &commands};
  const auto& batches = geometry.by_material ? material_batches_ : visibility_batches_;
  const gpu_types::HullPush push = hull_push(pass, batches.empty() ? 0 : batches.front().material);
  pass.push = gpu::PushConstants(push);
  pass.draws = [this, push, &batches, &commands, &indices,
                by_material = geometry.by_material](gpu::DrawEncoder& encoder) {
    encoder.index_buffer(indices);
    gpu_types::HullPush batch_push = push;
    for (std::size_t i = 0; i < batches.size(); ++i) {
      const Batch& batch = batches[i];
      if (!by_material) encoder.pipeline(batch.alpha_test ? 1 : 0);
      batch_push.material = batch.material;
      encoder.push(gpu::PushConstants(batch_push));
      encoder.material(scene_.material_set(batch.material));
      encoder.draw_indexed_indirect(commands, i * sizeof(VkDrawIndexedIndirectCommand));
    }
  };
  recorder.raster(std::move(pass));
}

}  // namespace subpixel::replay
