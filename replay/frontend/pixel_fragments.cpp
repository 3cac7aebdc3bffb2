#include "replay/frontend/pixel_fragments.hpp"

#include <algorithm>
#include <iterator>

namespace subpixel::replay {
namespace {

// The triangles whose bounding box touches the pixel's square, in submission order.
std::vector<PixelFragment> touching_triangles(Frontend& frontend, glm::uvec2 pixel) {
  const auto counts = frontend.counts().as<std::uint32_t>();
  const auto piece_bases = frontend.piece_bases().as<std::uint32_t>();
  const auto records = frontend.records().as<gpu_types::TriangleRecord>();
  const glm::ivec2 low = glm::ivec2(pixel) * SUBPIXEL_SNAP, high = low + SUBPIXEL_SNAP;
  std::vector<PixelFragment> found;
  for (std::uint32_t slot = 0; slot < frontend.triangle_slots(); ++slot) {
    const bool clipped = (counts[slot] & COUNT_CLIPPED) != 0;
    const std::uint32_t count = counts[slot] & COUNT_MASK, pieces = clipped ? count : std::min(count, 1u);
    const std::uint32_t first = clipped ? frontend.triangle_slots() + piece_bases[slot] : slot;
    for (std::uint32_t number = first; number < first + pieces; ++number) {
      const gpu_types::TriangleRecord& record = records[number];
      const glm::ivec2 a(record.v01.x, record.v01.y), b(record.v01.z, record.v01.w),
          c(record.v2_ref.x, record.v2_ref.y);
      const glm::ivec2 least = glm::min(glm::min(a, b), c), most = glm::max(glm::max(a, b), c);
      if (least.x > high.x || least.y > high.y || most.x < low.x || most.y < low.y) continue;
      PixelFragment& fragment = found.emplace_back();
      fragment.record = number;
      fragment.first_index = record.hull2_id.z;
      fragment.instance = record.hull2_id.w;
      fragment.material = record.v2_ref.w >> RECORD_MATERIAL_SHIFT;
      fragment.back_face = (record.v2_ref.w & RECORD_BACK_FACE) != 0;
      fragment.clipped = clipped;
    }
  }
  return found;
}

std::vector<FragmentLists::Batch> batches_of(const GpuScene& scene, std::span<const PixelFragment> fragments) {
  std::vector<FragmentLists::Batch> batches;
  for (std::size_t i = 0; i < fragments.size(); ++i) {
    const std::uint32_t material = fragments[i].material;
    if (batches.empty() || batches.back().material != material)
      batches.push_back({i, i, material, scene.alpha_tested(material)});
    batches.back().last = i + 1;
  }
  return batches;
}

}  // namespace

TriangleSource triangle_source(const GpuScene& scene, std::uint32_t first_index, std::uint32_t instance) {
  const std::vector<DrawItem>& draws = scene.draws();
  const auto next = std::ranges::upper_bound(draws, instance, {}, &DrawItem::first_instance);
  const auto draw = std::prev(next);
  return {static_cast<std::uint32_t>(draw - draws.begin()), instance - draw->first_instance,
          (first_index - draw->first_index) / 3};
}

std::vector<PixelFragment> find_pixel_fragments(const FrontendFrame& frame, glm::uvec2 pixel) {
  Frontend& frontend = frame.frontend;
  {
    gpu::PassRecorder setup(frontend.device());
    frontend.record_setup(setup);
    setup.run();
  }
  std::vector<PixelFragment> fragments = touching_triangles(frontend, pixel);
  gpu::PassRecorder recorder(frontend.device());
  gpu::Buffer& found = recorder.buffer("story fragments", fragments.size() * sizeof(gpu_types::StoryFragment));
  ListedPass pass;
  pass.name = "story fragments";
  pass.shader = "story/fragments.comp";
  pass.constants = {{CONSTANT_ALPHA_MODE, static_cast<std::uint32_t>(frame.alpha)},
                    {FRONTEND_CONSTANT_WITH_MASKS, static_cast<std::uint32_t>(ListedMasks::later)}};
  pass.bindings = {gpu::writes(STORY_SLOT_FRAGMENTS, found)};
  const FragmentLists lists = pixel_lists(recorder, frame, pixel, fragments, ListedMasks::later);
  record_listed_fragments(recorder, frame, lists, pass);
  recorder.run();
  for (std::size_t i = 0; i < fragments.size(); ++i) fragments[i].found = found.as<gpu_types::StoryFragment>()[i];
  std::erase_if(fragments, [](const PixelFragment& fragment) { return fragment.found.more.w == 0.0f; });
  return fragments;
}

FragmentLists pixel_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame, glm::uvec2 pixel,
                          std::span<const PixelFragment> fragments, ListedMasks masks) {
  FragmentLists lists;
  lists.count = fragments.size();
  lists.parts = list_parts(lists.count);
  lists.batches = batches_of(frame.frontend.scene(), fragments);
  lists.fragments = &recorder.buffer("story list", lists.count * 16);
  lists.numbers = &recorder.buffer("story list numbers", lists.count * 4);
  lists.ends = &recorder.buffer("story list ends", std::uint64_t{frame.width} * frame.height * 4);
  lists.addresses = &recorder.address_table("story list addresses", sizeof(gpu_types::ListAddresses));
  lists.addresses->set(gpu_types::ListAddresses{.fragments = lists.addresses->of(*lists.fragments),
                                                .numbers = lists.addresses->of(*lists.numbers),
                                                .ends = lists.addresses->of(*lists.ends),
                                                .bases = 0});
  // Each run begins with what the one before it changed.
  recorder.host([lists, width = frame.width, pixel, masks,
                 found = std::vector<PixelFragment>(fragments.begin(), fragments.end())] {
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::uint32_t mask = masks == ListedMasks::collected ? found[i].found.masks.x : 0;
      lists.fragments->as<glm::uvec4>()[i] = {found[i].record, pixel.x | pixel.y << 16, mask, 0};
      lists.numbers->as<std::uint32_t>()[i] = static_cast<std::uint32_t>(i);
    }
    const auto ends = lists.ends->as<std::uint32_t>();
    const auto own = static_cast<std::ptrdiff_t>(std::size_t{pixel.y} * width + pixel.x);
    std::fill(ends.begin() + own, ends.end(), static_cast<std::uint32_t>(found.size()));
  });
  return lists;
}

}  // namespace subpixel::replay
