#include "replay/techniques/linked_list_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace subpixel::replay {
namespace {

using gpu_types::LinkPlace;
using gpu_types::LinkStoredBlock;
using nlohmann::json;

// The samples that show a block: those of its fragment, and with the pixel's own those of fragments without a block.
std::uint64_t samples_of(const std::vector<PixelStory::Shown>& visible, std::span<const LinkStoredBlock> blocks,
                         const LinkStoredBlock& block) {
  std::uint64_t samples = 0;
  for (const PixelStory::Shown& one : visible) {
    const auto holds = [&one](const LinkStoredBlock& of) { return (one.samples >> of.of.z & 1u) != 0; };
    if (holds(block) || (block.of.w == 0 && std::ranges::none_of(blocks, holds))) samples |= one.samples;
  }
  return samples;
}

std::string rule_of(BlockAllocation allocation) {
  switch (allocation) {
    case BlockAllocation::largest:
      return "fragments of most samples first";
    case BlockAllocation::tiles:
      return "tile by tile";
    case BlockAllocation::atomic:
      break;
  }
  return "as fragments come";
}

json stored_step(const LinkForm& form, const PixelStory::Shown& one, const LinkStoredBlock& block) {
  const int samples = std::popcount(one.samples);
  json told{{"fragment", one.fragment}, {"samples", mask_text(one.samples)}, {"slot", block.of.x}};
  if (block.of.w == 0) {
    told["kind"] = "stored";
    told["what"] =
        fmt::format("stored in the pixel's own block, {}, which is that of {} {}", block.of.x,
                    form.first_block == FirstBlock::covered ? "the first covered sample," : "sample", block.of.z);
    return told;
  }
  told["kind"] = "linked";
  told["place"] = block.of.x - form.first_dynamic;
  told["pointer"] = block.of.w;
  told["what"] = fmt::format(
      "stored in block {}, place {} of the {} of the pool, which are handed out {}; a pointer leads to it with {} "
      "samples, known by sample {}",
      block.of.x, block.of.x - form.first_dynamic, form.capacity, rule_of(form.allocation), samples, block.of.z);
  return told;
}

json overflow_step(const LinkForm& form, const PixelStory::Shown& one, std::span<const LinkPlace> places,
                   bool own_block) {
  json told{{"fragment", one.fragment}, {"kind", "overflow"}, {"samples", mask_text(one.samples)}};
  const auto first = static_cast<std::uint32_t>(std::countr_zero(one.samples));
  std::string what = "without a block: ";
  const auto place = std::ranges::find(places, first, [](const LinkPlace& of) { return of.of.x; });
  if (place != places.end()) {
    told["place"] = place->of.z;
    what += fmt::format("its place {} lies beyond the {} of the pool, which are handed out {}", place->of.z,
                        form.capacity, rule_of(form.allocation));
  } else {
    what += fmt::format("the counter had handed out all {} of the pool", form.capacity);
  }
  told["what"] = what + (own_block ? "; its samples show the pixel's own block" : "; its samples show the sky");
  return told;
}

}  // namespace

json linked_list_steps(const PixelStory& story, const LinkForm& form, std::span<const LinkPlace> places,
                       std::span<const LinkStoredBlock> blocks) {
  json told = story.unseen_steps(form.samples);
  const bool own_block = !blocks.empty() && blocks.front().of.w == 0;
  for (const PixelStory::Shown& one : story.shown(form.samples)) {
    const auto block =
        std::ranges::find_if(blocks, [&one](const LinkStoredBlock& of) { return (one.samples >> of.of.z & 1u) != 0; });
    told.push_back(block == blocks.end() ? overflow_step(form, one, places, own_block)
                                         : stored_step(form, one, *block));
  }
  return told;
}

json linked_list_blocks(const PixelStory& story, const LinkForm& form, std::span<const LinkStoredBlock> blocks) {
  json told = json::array();
  const std::vector<PixelStory::Shown> visible = story.shown(form.samples);
  for (const LinkStoredBlock& block : blocks) {
    const std::uint64_t samples = samples_of(visible, blocks, block);
    const auto [nearest, farthest] = story.depths_shown(form.samples, samples);
    told.push_back({{"slot", block.of.x},
                    {"covers", mask_text(samples)},
                    {"weight", block.of.y},
                    {"known_by", block.of.z},
                    {"pointer", block.of.w},
                    {"depth_of", "reversed depth"},
                    {"nearest", nearest},
                    {"farthest", farthest},
                    {"surface", surface_json(block.surface)}});
  }
  return told;
}

}  // namespace subpixel::replay
