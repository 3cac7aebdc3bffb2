// The fragments of a frame as lists by pixel, for passes that go through a pixel's fragments in submission order with
// full vectors: the device's rasteriser gives fragment shaders blocks of which small triangles fill little.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "replay/frontend/frontend_frame.hpp"
#include "shaders/frontend/frontend_interface.h"

namespace subpixel::replay {

// Buffers of shaders/frontend/fragment_lists.glsl. Fragments stand by triangle, in submission order; a pixel's numbers
// are not yet sorted.
struct FragmentLists {
  // Fragments [first, last) of consecutive draws with one material.
  struct Batch {
    std::uint64_t first = 0, last = 0;
    std::uint32_t material = 0;
    bool alpha_test = false;
  };

  gpu::Buffer *fragments = nullptr, *numbers = nullptr, *ends = nullptr, *bases = nullptr;
  gpu::AddressTable* addresses = nullptr;  // of the four above
  std::uint64_t count = 0;
  std::uint32_t parts = 1;  // list_parts() of the longest
  std::vector<Batch> batches;

  // Their addresses for the push constants of `pass`, which from then on reads them or writes them, too; 0 for those
  // that are not there yet.
  gpu_types::ListAddresses reads(gpu::AddressUses& pass) const;
  gpu_types::ListAddresses writes(gpu::AddressUses& pass) const;
};

// Fragments of one pixel that shaders go through: in one pass no more than a driver's loops take that ends them after
// 65,535 turns, all of an invocation together (Mesa 22.3).
inline constexpr std::uint32_t kLongestList = SUBPIXEL_LIST_PARTS * SUBPIXEL_LIST_PART;
// Fragments take 20 bytes each and what a technique adds. A frame may have a million of them, or so many a pixel or a
// triangle, and in no case more than the last. Where both pixels and triangles have more, most fragments are hidden
// ones of triangles that fill the vectors of an ordered pass, which is faster then.
inline constexpr std::uint64_t kAnyFragments = 1'000'000, kMostFragmentsPerPixel = 12, kMostFragmentsPerTriangle = 16;
inline constexpr std::uint64_t kMostFragments = 64'000'000;

// Parts of SUBPIXEL_LIST_PART fragments that a list of so many has, at least one.
constexpr std::uint32_t list_parts(std::uint64_t fragments) {
  return std::max(1u, static_cast<std::uint32_t>((fragments + SUBPIXEL_LIST_PART - 1) / SUBPIXEL_LIST_PART));
}

// Masks of up to 32 samples are collected: each fragment has a sample and carries those that geometry covers, before
// alpha. Or lists hold all pixels that a triangle's edges reach, and masks are the technique's to make. Or they hold
// what is visible. The first two are values of the specialization constant.
enum class ListedMasks : std::uint32_t { later = 0, collected = 1, visible = 2 };

// What has to be known of a frame's lists before they are recorded.
struct FragmentListSizes {
  ListedMasks masks = ListedMasks::later;
  std::uint64_t count = 0;
  std::uint64_t kept = 0;       // of `count`, those in rows that count (FrontendFrame)
  std::uint64_t triangles = 0;  // that have any
  std::uint32_t longest = 0;    // of a pixel; not of visible ones, which have no more than samples
  std::vector<FragmentLists::Batch> batches;
};

// Counts the fragments of the frame by a run on the spot. Nothing when it is not within the limits above and the
// device's.
std::optional<FragmentListSizes> measure_fragment_lists(const FrontendFrame& frame, ListedMasks masks);

// The parts of that, for frames in bands: could a device go through lists of a frame of so many pixels that has these
// triangles; the fragments of what is prepared; are they, the longest list of a pixel and the frame's triangles on the
// screen within the limits.
bool lists_are_possible(const Frontend& frontend, std::uint64_t pixels);
struct CountedFragments {
  FragmentListSizes sizes;
  std::uint64_t total = 0;
};
CountedFragments count_fragment_lists(const FrontendFrame& frame, ListedMasks masks);
bool lists_pay(std::uint64_t total, std::uint32_t longest, std::uint64_t pixels, std::uint64_t triangles);

// Collects the fragments of the frame that was measured, passes `name`. Set-up is recorded already.
FragmentLists record_fragment_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame,
                                    const FragmentListSizes& sizes, const std::string& name);

// Fragments that show in a sample, told from the visibility image alone: each with the samples that it shows in, up to
// 64 of them (z and w of shaders/frontend/fragment_lists.glsl). Of one triangle they stand in any order, since threads
// number them; a pixel has one of each triangle, so its numbers rise in submission order all the same. Measuring finds
// the visibility on the spot.
FragmentListSizes measure_visible_fragments(const FrontendFrame& frame);
FragmentLists record_visible_fragments(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& visibility,
                                       const FragmentListSizes& sizes, const std::string& name);

// A pass over the fragments material by material, textures bound: one invocation for each fragment of a batch, whose
// range the shader finds in its push constants (shaders/frontend/listed_fragment.glsl). With `alpha_only` over
// alpha-tested batches. Bindings and addresses beyond those are the caller's, as are constants.
struct ListedPass : gpu::AddressUses {
  std::string name, shader;
  gpu::Constants constants;
  std::vector<gpu::Binding> bindings;
  bool alpha_only = false;
};
void record_listed_fragments(gpu::PassRecorder& recorder, const FrontendFrame& frame, const FragmentLists& lists,
                             const ListedPass& pass);

}  // namespace subpixel::replay
