// Deferred shading of per-pixel lists: one block of attributes for each visible fragment instead of each sample. Every
// pixel has a block; further fragments take blocks of a pool and are linked to it.
// Fridvalszky and Toth, "Multisample Anti-Aliasing in Deferred Rendering", Eurographics 2020 short papers.
// The publication hands out blocks by one atomic counter (`allocation=atomic`). Which fragments a full pool leaves
// without a block then depends on how the device's threads ran. By default the lists are laid out before the geometry
// pass, from the visibility that its depth pre-pass left, by counting and prefix sums: the same lists every run, and
// the fragments with fewest samples are those that go without.
#include "replay/techniques/linked_list.hpp"

#include <algorithm>
#include <cmath>

#include "replay/frontend/list_passes.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/linked_list_story.hpp"
#include "shaders/techniques/linked_list/linked_list_interface.h"

namespace subpixel::replay {
namespace {

constexpr const char* kLink = "link";  // the passes of allocation
constexpr double kMib = 1024.0 * 1024.0;

std::uint64_t pixels(const FrameSetup& setup) {
  return std::uint64_t{setup.width} * setup.height;
}

std::uint64_t pair_words(const FrameSetup& setup) {
  const SceneFeatures features = setup.scene.features();
  const bool shared = features.has(FEATURE_METAL) && features.has(FEATURE_VARYING_ROUGHNESS);
  return LINK_PAIR_WORDS - (shared ? 0 : 1) + (features.has(FEATURE_EMISSIVE) ? 2 : 0);
}

std::uint32_t allocation(const LinkedListSetup& setup) {
  return static_cast<std::uint32_t>(setup.parameters.allocation);
}

std::uint64_t frame_pixels(const FrameSetup& setup) {
  return std::uint64_t{setup.width} * setup.frame_height();
}

bool by_blocks(const LinkedListSetup& setup) {
  constexpr std::uint32_t kSide = 1u << LINK_OWNER_SIDE_BITS;  // larger images are lit by lists
  return setup.parameters.lighting == BlockLighting::blocks && setup.width <= kSide && setup.frame_height() <= kSide;
}

gpu::Constants list_constants(const LinkedListSetup& setup) {
  return {{LINK_CONSTANT_ALLOCATION, allocation(setup)},
          {LINK_CONSTANT_FIRST_BLOCK, static_cast<std::uint32_t>(setup.parameters.first_block)},
          {LINK_CONSTANT_LIGHTING, by_blocks(setup) ? LINK_LIGHT_BLOCKS : LINK_LIGHT_LISTS}};
}

MemoryLayout layout(const LinkedListSetup& setup) {
  const double n = setup.samples, per_pixel = 1.0 / static_cast<double>(pixels(setup));
  const double dynamic = static_cast<double>(linked_list_dynamic_blocks(setup)) * per_pixel;
  return {{"depth", 32 * n}, {"pre-allocated blocks", LINK_BLOCK_BITS}, {"dynamic blocks", LINK_BLOCK_BITS * dynamic}};
}

// What all passes of one frame share.
struct Lists {
  gpu::AddressTable* pool = nullptr;  // a LinkPool
  std::uint64_t capacity = 0;
  gpu::Image* visibility = nullptr;
  gpu::Buffer *places = nullptr, *blocks = nullptr;  // logs of a story
};

template <typename Pass>
void bind(Pass& pass, const Lists& lists) {
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, *lists.visibility));
  pass.bindings.push_back(gpu::writes(LINK_SLOT_POOL, *lists.pool));
}
void bind(gpu::RasterPass& pass, const Lists& lists) {  // which only reads
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, *lists.visibility));
  pass.bindings.push_back(gpu::reads(LINK_SLOT_POOL, *lists.pool));
}

gpu::RasterPass list_pass(const LinkedListSetup& setup, const Lists& lists, std::string name, std::string fragment) {
  gpu::RasterPass pass = fullscreen_pass(setup, std::move(name), std::move(fragment));
  gpu::append(pass.pipeline.constants, list_constants(setup));
  bind(pass, lists);
  return pass;
}

void record_allocation(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const Lists& lists) {
  gpu::ComputePass pass;
  pass.name = kLink;
  pass.constants = setup.frontend.constants();
  gpu::append(pass.constants, list_constants(setup));
  pass.bindings = {gpu::uniform(setup.scene.frame_constants)};
  bind(pass, lists);
  if (allocation(setup) == LINK_ALLOCATE_ATOMIC) {
    pass.shader = "techniques/linked_list/clear.comp";
    pass.groups = {(setup.width + 63) / 64, setup.height, 1};
    recorder.compute(std::move(pass));
    return;
  }
  const std::uint32_t tiles =
      ((setup.width + LINK_TILE - 1) / LINK_TILE) * ((setup.height + LINK_TILE - 1) / LINK_TILE);
  const std::uint32_t sums = allocation(setup) == LINK_ALLOCATE_LARGEST ? tiles * setup.samples : tiles;
  gpu::Buffer& needed = recorder.buffer("blocks by tile", (std::uint64_t{sums} + 1) * 16);
  gpu::Image& leaders = map_image(recorder, setup, "leaders");
  gpu::RasterPass find = list_pass(setup, lists, kLink, "techniques/linked_list/leaders.frag");
  find.colours = {{leaders}};
  recorder.raster(std::move(find));

  pass.shader = "techniques/linked_list/count.comp";
  pass.bindings.push_back(gpu::samples(LINK_SLOT_LEADERS, leaders));
  pass.bindings.push_back(gpu::writes(LINK_SLOT_TILE_SUMS, needed));
  pass.groups = {(tiles + 63) / 64, 1, 1};
  recorder.compute(pass);

  record_scan(recorder, kLink, needed, sums);

  pass.shader = "techniques/linked_list/link.comp";
  recorder.compute(pass);
  if (lists.places == nullptr) return;
  pass.name = "story";
  pass.shader = "techniques/linked_list/link.comp:STORY";
  pass.bindings.push_back(gpu::writes(LINK_SLOT_STORY, *lists.places));
  recorder.compute(std::move(pass));
}

void record_geometry(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const FragmentLists& fragments,
                     const Lists& lists) {
  ListedPass pass;
  pass.name = "gbuffer";
  pass.shader = "techniques/linked_list/gbuffer.comp";
  pass.constants = common_constants(setup);
  gpu::append(pass.constants, list_constants(setup));
  bind(pass, lists);
  record_listed_fragments(recorder, setup, fragments, pass);
}

// Of the story's pixel what the geometry left.
void record_blocks_story(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const Lists& lists) {
  gpu::ComputePass pass;
  pass.name = "story";
  pass.shader = "techniques/linked_list/story.comp";
  pass.constants = setup.frontend.constants();
  gpu::append(pass.constants, common_constants(setup));
  gpu::append(pass.constants, list_constants(setup));
  pass.bindings = light_bindings(setup);
  pass.bindings.push_back(gpu::uniform(setup.scene.frame_constants));
  bind(pass, lists);
  pass.bindings.push_back(gpu::writes(LINK_SLOT_STORY, *lists.blocks));
  recorder.compute(std::move(pass));
}

void make_story_logs(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const LinkedListPool& pool,
                     Lists& lists) {
  PixelStory& story = *setup.story;
  lists.places = &story.record_log<gpu_types::LinkPlace>(recorder, "list places", setup.samples);
  lists.blocks = &story.record_log<gpu_types::LinkStoredBlock>(recorder, "list blocks", setup.samples + 1);
  const LinkForm form{setup.samples, static_cast<std::uint32_t>(pixels(setup)),
                      static_cast<std::uint32_t>(pool.dynamic_blocks), setup.parameters.allocation,
                      setup.parameters.first_block};
  const auto blocks = [log = lists.blocks] { return PixelStory::log_of<gpu_types::LinkStoredBlock>(*log); };
  story.tell("steps", [&story, form, places = lists.places, blocks] {
    return linked_list_steps(story, form, PixelStory::log_of<gpu_types::LinkPlace>(*places), blocks());
  });
  story.tell("surfaces", [&story, form, blocks] { return linked_list_blocks(story, form, blocks()); });
  story.amend(light_surfaces);
}

// The dynamic blocks' part of `shading`, which has the lights bound.
void record_block_lighting(gpu::PassRecorder& recorder, gpu::Buffer& frame_constants, const Lists& lists,
                           const gpu::RasterPass& shading) {
  gpu::Buffer& groups = recorder.buffer("block groups", 12);
  gpu::ComputePass pass;
  pass.name = "shade blocks";
  pass.shader = "techniques/linked_list/groups.comp";
  pass.constants = shading.pipeline.constants;
  pass.bindings = {gpu::uniform(frame_constants)};
  bind(pass, lists);
  pass.bindings.push_back(gpu::writes(LINK_SLOT_GROUPS, groups));
  recorder.compute(std::move(pass));

  gpu::ComputePass light;
  light.name = "shade blocks";
  light.shader = "techniques/linked_list/light.comp";
  light.constants = shading.pipeline.constants;
  light.bindings = shading.bindings;
  bind(light, lists);
  light.indirect = &groups;
  recorder.compute(std::move(light));
}

void record_shading(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const Lists& lists) {
  gpu::RasterPass pass = lighting_pass(setup, "shade", "techniques/linked_list/shade.frag");
  gpu::append(pass.pipeline.constants, list_constants(setup));
  if (by_blocks(setup)) record_block_lighting(recorder, setup.scene.frame_constants, lists, pass);
  pass.colours = make_outputs(recorder, setup);
  bind(pass, lists);
  if (setup.story != nullptr) setup.story->record_lighting(recorder, pass, "techniques/linked_list/shade.frag:STORY");
  recorder.raster(std::move(pass));
}

// After every run: the atomic counter's allocation differs from run to run.
void record_maps(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const Lists& lists) {
  gpu::RasterPass pass = list_pass(setup, lists, "maps", "techniques/linked_list/maps.frag");
  pass.colours = make_maps(recorder, setup, {"blocks", "overflow", "leaks"});
  recorder.host(run_pass(recorder.device(), std::move(pass)));
  setup.outputs.frame_counters["blocks_available"] =
      setup.height == setup.frame_height() ? lists.capacity : linked_list_dynamic_blocks(setup);
  recorder.host([&counters = setup.outputs.counters, table = lists.pool] {
    const auto pool = table->buffer().as<gpu_types::LinkPool>()[0];
    counters["blocks_wanted"] = pool.allocated;  // dynamic ones
    counters["blocks_used"] = std::min(pool.allocated, pool.capacity);
    counters["overflowed_fragments"] = pool.allocated - std::min(pool.allocated, pool.capacity);
  });
}

void record(gpu::PassRecorder& recorder, const LinkedListSetup& setup) {
  // Rows of a frame have all that they may need of the frame's pool: whether that is enough for all is known when all
  // have been drawn.
  const std::uint64_t dynamic = std::min(linked_list_dynamic_blocks(setup), (setup.samples - 1) * pixels(setup));
  record_linked_list(recorder, setup, {&recorder.buffer("blocks", linked_list_pool_bytes(setup, dynamic)), 0, dynamic});
}

}  // namespace

std::uint64_t linked_list_dynamic_blocks(const LinkedListSetup& setup) {
  const PoolUnit unit = setup.parameters.pool_unit;
  const double pool = setup.parameters.pool;
  const double blocks = unit == PoolUnit::blocks ? pool
                        : unit == PoolUnit::mib  ? pool * kMib * 8 / static_cast<double>(16 * pair_words(setup))
                                                 : pool * static_cast<double>(frame_pixels(setup));
  // A chosen sample that shows the sky leaves up to samples - 1 others, like one that doesn't.
  const std::uint64_t useful = (setup.samples - 1) * frame_pixels(setup);
  constexpr std::uint64_t kIndices = std::uint64_t{1} << LINK_INDEX_BITS;
  const std::uint64_t reachable = kIndices - std::min(kIndices, frame_pixels(setup));
  return std::min({static_cast<std::uint64_t>(std::floor(blocks)), useful, reachable});
}

std::uint64_t linked_list_pool_bytes(const LinkedListSetup& setup, std::uint64_t dynamic_blocks) {
  return (pixels(setup) + dynamic_blocks + 1) / 2 * pair_words(setup) * 4;
}

void record_linked_list(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const LinkedListPool& pool) {
  const VisibleFragments visible = record_visible(recorder, setup);
  Lists lists;
  lists.visibility = visible.visibility;
  lists.capacity = pool.dynamic_blocks;
  gpu::Buffer* owners = by_blocks(setup) ? &recorder.buffer("block owners", pool.dynamic_blocks * 4) : nullptr;
  lists.pool = &recorder.address_table("lists", sizeof(gpu_types::LinkPool));
  lists.pool->set(gpu_types::LinkPool{.words = lists.pool->of(*pool.buffer) + pool.first_byte,
                                      .owners = owners ? lists.pool->of(*owners) : 0,
                                      .capacity = static_cast<std::uint32_t>(pool.dynamic_blocks),
                                      .allocated = 0,
                                      .width = setup.width,
                                      .height = setup.height});
  if (setup.story != nullptr) make_story_logs(recorder, setup, pool, lists);
  record_allocation(recorder, setup, lists);
  record_geometry(recorder, setup, visible.lists, lists);
  if (setup.story != nullptr) record_blocks_story(recorder, setup, lists);
  record_shading(recorder, setup, lists);
  record_maps(recorder, setup, lists);
}

extern const Technique kLinkedList;

const Technique kLinkedList = TechniqueOf<LinkedListParameters>{
    .name = "linked_list",
    .title = "Per-pixel linked lists",
    .paper = "Fridvalszky, Toth: Multisample Anti-Aliasing in Deferred Rendering. Eurographics 2020 short papers",
    .fields =
        {field::samples({2, 4, 8}),
         field::number("pool", &LinkedListParameters::pool, {0, 1e9},
                       "dynamic blocks at most, in pool_unit; those of a pixel beyond samples - 1 are never needed nor "
                       "made"),
         field::choice(
             "pool_unit", &LinkedListParameters::pool_unit, "what the pool is counted in",
             {{"blocks_per_pixel", PoolUnit::blocks_per_pixel}, {"mib", PoolUnit::mib}, {"blocks", PoolUnit::blocks}}),
         field::choice("allocation", &LinkedListParameters::allocation,
                       "who gets a block while there are some: fragments with most samples first, tile by tile, or as "
                       "fragments come, by an atomic counter",
                       {{"largest", BlockAllocation::largest},
                        {"tiles", BlockAllocation::tiles},
                        {"atomic", BlockAllocation::atomic}}),
         field::choice("first_block", &LinkedListParameters::first_block,
                       "a pixel's own block holds what sample 0 shows, or what its first covered sample shows",
                       {{"sample", FirstBlock::sample}, {"covered", FirstBlock::covered}}),
         field::choice("lighting", &LinkedListParameters::lighting,
                       "dynamic blocks are lit one by one before the pixels, or with their pixel's list",
                       {{"blocks", BlockLighting::blocks}, {"lists", BlockLighting::lists}}),
         field::alpha(), field::resolve(), field::shading()},
    .maps = {{"blocks", "Blocks with a surface", "blocks", 0},
             {"overflow", "Samples of fragments without a block", "samples", 0},
             {"leaks", "Samples that show the sky for want of a block", "samples", 0}},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
    .whole_only = [](const LinkedListSetup& whole) -> std::string {
      const auto& counters = whole.outputs.counters;
      const auto wanted = counters.find("blocks_wanted");
      if (wanted == counters.end() || wanted->second <= linked_list_dynamic_blocks(whole)) return "";
      return "its pool has fewer blocks than fragments want, which are given out over all of the frame";
    },
};

}  // namespace subpixel::replay
