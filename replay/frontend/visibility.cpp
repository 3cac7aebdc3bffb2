#include "replay/frontend/visibility.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "replay/frontend/list_passes.hpp"

namespace subpixel::replay {
namespace {

constexpr VkFormat kTexel = VK_FORMAT_R32G32B32A32_UINT;
constexpr const char* kPass = "visibility";
// Entries of a list for devices that end long loops (runs_long_loops()): an entry takes up to two turns.
constexpr std::uint64_t kMostEntries = 30'000;

// Layers of the image of `samples` that group `g` of them, `group` at a time, has: its depths', then its triangles'.
// They lie as visibility.glsl reads them, however many are drawn at a time.
std::vector<std::uint32_t> layers_of(std::uint32_t samples, std::uint32_t group, std::uint32_t g) {
  if (group < 4) return {0};
  const std::uint32_t together = std::min(samples, 16u) / 4, quads = group / 4;
  std::vector<std::uint32_t> layers;
  for (const std::uint32_t half : {0u, 1u})
    for (std::uint32_t quad = g * quads; quad < (g + 1) * quads; ++quad)
      layers.push_back((2 * (quad / together) + half) * together + quad % together);
  return layers;
}

// Lists of the small triangles that may touch each block of pixels (list_small.comp).
struct SmallLists {
  gpu::Buffer *triangles, *ends, *listed;
};

std::uint32_t block_count(const FrontendFrame& frame) {
  return (frame.width + 3) / 4 * ((frame.height + 1) / 2);
}

SmallLists record_small_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame) {
  Frontend& frontend = frame.frontend;
  const std::uint32_t blocks = block_count(frame), block_groups = groups_of(blocks);
  SmallLists lists{&recorder.buffer("small triangles", frontend.small_count() * sizeof(gpu_types::SmallTriangle)),
                   &recorder.buffer("block list ends", std::uint64_t{blocks} * 4),
                   // One more than are listed: visibility_small.frag reads ahead.
                   &recorder.buffer("block lists", (frontend.small_blocks() + 1) * 4)};
  gpu::Buffer& sums = recorder.buffer("block list sums", (std::uint64_t{block_groups} + 1) * 16);
  frontend.record_small_list(recorder, kPass);
  recorder.fill(kPass, *lists.ends, 0);

  gpu::ComputePass list;
  list.name = kPass;
  list.shader = "frontend/list_small.comp:COUNT";
  list.bindings = {gpu::reads(FRONTEND_SLOT_SMALL_RECORDS, frontend.small_records()),
                   gpu::writes(FRONTEND_SLOT_BLOCK_ENDS, *lists.ends)};
  list.push = gpu::PushConstants(gpu_types::ListSmallPush{.records = list.reads(frontend.records()),
                                                          .small = list.writes(*lists.triangles),
                                                          .count = static_cast<std::uint32_t>(frontend.small_count()),
                                                          .width = frame.width,
                                                          .height = frame.height});
  list.groups = dealt_grid_of(frontend.small_count());
  recorder.compute(list);
  record_bases(recorder, kPass, *lists.ends, sums, blocks);
  list.shader = "frontend/list_small.comp:STORE";
  list.bindings.push_back(gpu::writes(FRONTEND_SLOT_BLOCK_LISTS, *lists.listed));
  recorder.compute(std::move(list));
  return lists;
}

}  // namespace

bool small_lists_too_long(const FrontendFrame& frame) {
  Frontend& frontend = frame.frontend;
  if (frontend.small_count() < kMostEntries || runs_long_loops(frontend.device())) return false;
  gpu::PassRecorder counting(frontend.device());
  frontend.record_setup(counting);
  const SmallLists lists = record_small_lists(counting, frame);
  counting.run();
  const auto ends = lists.ends->as<std::uint32_t>();
  std::uint32_t longest = ends[0];
  for (std::uint32_t block = 1; block < block_count(frame); ++block)
    longest = std::max(longest, ends[block] - ends[block - 1]);
  return longest >= kMostEntries;
}

namespace {

// Small triangles of sample group `g` into the image.
void record_small_triangles(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& image,
                            const SmallLists& lists, std::uint32_t group, std::uint32_t g) {
  gpu::RasterPass pass;
  const gpu_types::VisibilitySmallPush push{.small = pass.reads(*lists.triangles),
                                            .count = static_cast<std::uint32_t>(frame.frontend.small_count()),
                                            .width = frame.width,
                                            .height = frame.height};
  pass.name = kPass;
  pass.pipeline.vertex = "shade/fullscreen.vert";
  pass.pipeline.fragment = "frontend/visibility_small.frag:" + std::to_string(group);
  const gpu::DeviceInfo& info = recorder.device().info();
  const bool far = lists.triangles->bytes() > info.max_storage_buffer_range;
  if (!info.fragment_subgroups)
    pass.pipeline.fragment += "_BY_LANE";
  else if (far)
    pass.pipeline.fragment += "_FAR";
  else
    pass.bindings.push_back(gpu::reads(FRONTEND_SLOT_SMALL_TRIANGLES, *lists.triangles));
  pass.pipeline.constants = frame.frontend.constants();
  pass.pipeline.constants.emplace_back(CONSTANT_SAMPLE_GROUP, g);
  pass.bindings.push_back(gpu::reads(FRONTEND_SLOT_BLOCK_ENDS, *lists.ends));
  pass.bindings.push_back(gpu::reads(FRONTEND_SLOT_BLOCK_LISTS, *lists.listed));
  pass.push = gpu::PushConstants(push);
  for (const std::uint32_t layer : layers_of(frame.frontend.samples(), group, g))
    pass.colours.emplace_back(image, layer);
  recorder.raster(std::move(pass));
}

// All triangles of sample group `g` into the image, with no order of fragments needed: what the words of
// visibility_unordered.frag hold after three geometry passes is gathered.
void record_unordered(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& image,
                      const std::array<gpu::Buffer*, 3>& words, gpu::AddressTable& table, std::uint32_t group,
                      std::uint32_t g) {
  const auto [depths, slots, records] = words;
  recorder.fill(kPass, *depths, 0);
  recorder.fill(kPass, *slots, SUBPIXEL_NO_TRIANGLE);
  recorder.fill(kPass, *records, SUBPIXEL_NO_TRIANGLE);
  for (const std::string step : {"DEPTH", "SLOT", "RECORD"}) {
    Frontend::GeometryPass geometry;
    geometry.fragment_opaque = "frontend/visibility_unordered.frag:" + step;
    geometry.fragment_alpha = geometry.fragment_opaque + "A";
    geometry.pass.name = kPass;
    geometry.pass.pipeline.constants = {{CONSTANT_ALPHA_MODE, static_cast<std::uint32_t>(frame.alpha)},
                                        {CONSTANT_SAMPLE_GROUP, g},
                                        {CONSTANT_GROUP_SAMPLES, group}};
    geometry.pass.size = {frame.width, frame.height};
    geometry.pass.bindings = {gpu::writes(FRONTEND_SLOT_NEAREST, table)};
    frame.frontend.record_geometry(recorder, std::move(geometry));
  }
  gpu::RasterPass gather;
  gather.name = kPass;
  gather.pipeline.vertex = "shade/fullscreen.vert";
  gather.pipeline.fragment = "frontend/gather_visibility.frag:" + std::to_string(group);
  gather.pipeline.constants = frame.frontend.constants();
  gather.push = gpu::PushConstants(
      gpu_types::NearestPush{.nearest = {gather.reads(*depths), gather.reads(*slots), gather.reads(*records)},
                             .width = frame.width,
                             .height = frame.height});
  for (const std::uint32_t layer : layers_of(frame.frontend.samples(), group, g))
    gather.colours.emplace_back(image, layer);
  recorder.raster(std::move(gather));
}

void record_unordered(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& image) {
  const std::uint32_t samples = frame.frontend.samples(), group = visibility_group(frame.frontend);
  const std::uint64_t bytes = std::uint64_t{frame.width} * frame.height * group * 4;
  const std::array<gpu::Buffer*, 3> words{&recorder.buffer("nearest depths", bytes),
                                          &recorder.buffer("nearest triangles", bytes),
                                          &recorder.buffer("nearest records", bytes)};
  gpu::AddressTable& table = recorder.address_table("nearest words", sizeof(gpu_types::NearestAddresses));
  table.set(gpu_types::NearestAddresses{table.of(*words[0]), table.of(*words[1]), table.of(*words[2])});
  for (std::uint32_t g = 0; g < samples / group; ++g) record_unordered(recorder, frame, image, words, table, group, g);
}

}  // namespace

std::uint32_t visibility_group(const Frontend& frontend) {
  return std::min(frontend.samples(), frontend.device().info().eight_attachments ? 16u : 8u);
}

bool small_lists_pay(const Frontend& frontend, std::uint64_t pixels) {
  const gpu::DeviceInfo& info = frontend.device().info();
  const std::uint64_t range = info.max_storage_buffer_range;
  // Lists cost about what the hulls of 1/32 as many triangles as pixels do.
  return info.ordered_attachments && 32 * frontend.small_count() > pixels && (frontend.small_blocks() + 1) * 4 <= range;
}

SmallTriangles choose_small_triangles(const FrontendFrame& frame) {
  const bool in_lists =
      small_lists_pay(frame.frontend, std::uint64_t{frame.width} * frame.height) && !small_lists_too_long(frame);
  return in_lists ? SmallTriangles::in_lists : SmallTriangles::as_hulls;
}

gpu::Image& visibility_image(gpu::PassRecorder& recorder, const FrontendFrame& frame) {
  const std::uint32_t samples = frame.frontend.samples();
  const std::uint32_t layers = samples < 4 ? 1 : samples / 2;
  return recorder.image(
      {"visibility", kTexel, frame.width, frame.height, 1, layers, VK_SAMPLE_COUNT_1_BIT,
       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
}

void attach_visibility(gpu::RasterPass& pass, const Frontend& frontend, gpu::Image& image, std::uint32_t g) {
  const std::uint32_t group = visibility_group(frontend);
  constexpr std::uint32_t kNone = SUBPIXEL_NO_TRIANGLE;
  pass.pipeline.targets.ordered_read = true;
  pass.pipeline.constants.emplace_back(CONSTANT_SAMPLE_GROUP, g);
  if (group < 4) {
    pass.colours = {{image, 0}};
    pass.clear_colours = {{0, group == 1 ? kNone : 0, kNone, kNone}};
    return;
  }
  const std::vector<std::uint32_t> layers = layers_of(frontend.samples(), group, g);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    pass.colours.emplace_back(image, layers[i]);
    pass.clear_colours.push_back(i < layers.size() / 2 ? std::array<std::uint32_t, 4>{}
                                                       : std::array<std::uint32_t, 4>{kNone, kNone, kNone, kNone});
  }
}

gpu::Image& record_visibility(gpu::PassRecorder& recorder, const FrontendFrame& frame) {
  const std::uint32_t samples = frame.frontend.samples();
  const std::uint32_t group = visibility_group(frame.frontend);
  gpu::Image& image = visibility_image(recorder, frame);
  if (!recorder.device().info().ordered_attachments) {
    record_unordered(recorder, frame, image);
    return image;
  }
  std::optional<SmallLists> lists;
  if (frame.small == SmallTriangles::in_lists) lists = record_small_lists(recorder, frame);
  for (std::uint32_t g = 0; g < samples / group; ++g) {
    if (lists) record_small_triangles(recorder, frame, image, *lists, group, g);
    Frontend::GeometryPass geometry;
    geometry.without_small = lists.has_value();
    gpu::RasterPass& pass = geometry.pass;
    pass.name = kPass;
    const std::string variant = std::to_string(group);
    geometry.fragment_opaque = "frontend/visibility.frag:" + variant;
    geometry.fragment_alpha = "frontend/visibility.frag:" + variant + "A";
    pass.pipeline.constants = {{CONSTANT_ALPHA_MODE, static_cast<std::uint32_t>(frame.alpha)},
                               {FRONTEND_CONSTANT_AFTER_SMALL, lists ? 1 : 0}};
    pass.pipeline.targets.clear = !lists;
    attach_visibility(pass, frame.frontend, image, g);
    frame.frontend.record_geometry(recorder, std::move(geometry));
  }
  return image;
}

}  // namespace subpixel::replay
