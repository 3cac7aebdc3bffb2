// The fragments of a frame as lists by pixel, for passes that go through a pixel's fragments in submission order with
// full vectors: the device's rasteriser gives fragment shaders blocks of which small triangles fill little.
#pragma once

#include <optional>
#include <string>

#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

// Buffers of shaders/frontend/fragment_lists.glsl. Fragments stand by triangle, in submission order; a pixel's numbers
// are not yet sorted.
struct FragmentLists {
  gpu::Buffer *fragments = nullptr, *numbers = nullptr, *ends = nullptr, *bases = nullptr;
  gpu::Buffer* addresses = nullptr;  // of the four above, a ListAddresses
  std::uint64_t count = 0;
  // Fragments [first, last) of consecutive draws with one material.
  struct Batch {
    std::uint64_t first = 0, last = 0;
    std::uint32_t material = 0;
    bool alpha_test = false;
  };
  std::vector<Batch> batches;

  std::array<gpu::Buffer*, 4> buffers() const { return {fragments, numbers, ends, bases}; }
};

// Numbers of a pixel's fragments that shaders can sort within the 65,535 turns of loops that some drivers end at; what
// all fragments may be, at 16 bytes each and what a technique adds.
inline constexpr std::uint32_t kLongestList = 240;
inline constexpr std::uint64_t kMostFragments = 24'000'000;

// Collects the current frame's fragments, passes `name`; set-up is recorded already. Up to 16 samples each has a sample
// and carries their mask as geometry has it, before alpha; with more samples masks are the technique's to make. Nothing
// when the frame has more than the limits above: one run on the spot counts them.
std::optional<FragmentLists> record_fragment_lists(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                                   const std::string& name);

// A pass over the fragments material by material, textures bound: one invocation for each fragment of a batch, whose
// range the shader finds in its push constants (shaders/frontend/listed_fragment.glsl). With `alpha_only` over
// alpha-tested batches. Bindings and addresses beyond those are the caller's, as are constants.
struct ListedPass {
  std::string name, shader;
  gpu::Constants constants;
  std::vector<gpu::Binding> bindings;
  std::vector<gpu::Buffer*> by_address;
  bool alpha_only = false;
};
void record_listed_fragments(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists,
                             const ListedPass& pass);

}  // namespace subpixel::replay
