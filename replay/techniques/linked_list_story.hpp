// Where one pixel's fragments are stored in `linked_list`, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/linked_list.hpp"
#include "shaders/techniques/linked_list/story_interface.h"

namespace subpixel::replay {

struct LinkForm {
  std::uint32_t samples = 8, first_dynamic = 0,
                capacity = 0;  // the number of the first dynamic block, how many there are
  BlockAllocation allocation = BlockAllocation::largest;
  FirstBlock first_block = FirstBlock::sample;
};

// What was done with each of the story's fragments. `places`: none with the counter, which leaves no trace of those
// that found the pool full.
nlohmann::json linked_list_steps(const PixelStory& story, const LinkForm& form,
                                 std::span<const gpu_types::LinkPlace> places,
                                 std::span<const gpu_types::LinkStoredBlock> blocks);
// The blocks with a surface, in the order of the list.
nlohmann::json linked_list_blocks(const PixelStory& story, const LinkForm& form,
                                  std::span<const gpu_types::LinkStoredBlock> blocks);

}  // namespace subpixel::replay
