// What techniques share whose fragments go into a state of their pixel in submission order: where the state lies, the
// ordered pass or the passes over fragment lists that fill it, and how later passes read it. The shaders' side is
// shaders/include/ordered_state*.glsl; what a fragment does to the state is the technique's.
#pragma once

#include <cstdint>
#include <string>

#include "replay/frame/frame_setup.hpp"
#include "replay/frontend/fragment_lists.hpp"

namespace subpixel::replay {

// Each pixel's 32-bit words, in one of the two: four each in the layers of an RGBA32UI image, or together, pixel after
// pixel, row by row.
struct OrderedState {
  gpu::Image* image = nullptr;
  gpu::Buffer* words = nullptr;
  gpu::AddressTable* address = nullptr;  // of the words
  // Further words in entries, where the technique keeps those apart (shaders/include/ordered_entries.glsl). Not
  // cleared.
  gpu::Buffer* entries = nullptr;
  gpu::AddressTable* entries_address = nullptr;

  // Variant of shaders that read the state: IMAGE or BUFFER, with entries TILED_IMAGE or TILED_BUFFER.
  std::string variant() const {
    return std::string(entries != nullptr ? "TILED_" : "") + (image != nullptr ? "IMAGE" : "BUFFER");
  }
  // Binds what they read.
  void bind(gpu::RasterPass& pass) const;
};

// Pixels to allot to a buffer that full-screen passes read by address: devices shade whole blocks of up to 4x4 pixels,
// of which those beyond the border read, too.
std::uint64_t padded_pixels(const FrameSetup& setup);

// A state of `quads` times four words a pixel. Up to 32 words lie in attachments, whose order the device promises;
// more, and what lists fill, in a buffer.
OrderedState make_ordered_state(gpu::PassRecorder& recorder, const FrameSetup& setup, const std::string& name,
                                std::uint32_t quads, bool in_buffer);

// Gives the state entries: `words` a pixel, all together.
void add_entries(gpu::PassRecorder& recorder, const FrameSetup& setup, OrderedState& state, const std::string& name,
                 std::uint32_t words);

// Clears the state, but for entries, and puts the frame's fragments into it one by one. `geometry` comes with name,
// constants and bindings; `shader` has a variant for each number of attachments and for buffers, with and without
// interlock.
void record_ordered(gpu::PassRecorder& recorder, const FrameSetup& setup, const OrderedState& state,
                    Frontend::GeometryPass geometry, const std::string& shader);

// Every layer of `image` becomes a cleared attachment of `pass`, whose fragments read what those before left there.
void attach_ordered(gpu::RasterPass& pass, gpu::Image& image);

// The same state filled by passes over fragment lists: one over pixels sorts each list and keeps some of its fragments,
// the technique makes surfaces of those, another pass over pixels merges them.
class ListedState {
 public:
  // `surface_bytes`: what the technique keeps of a fragment. `lists` and `state` outlive this.
  ListedState(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists,
              const OrderedState& state, std::uint64_t surface_bytes);

  // For the pass that makes the surfaces.
  gpu::Binding surfaces() const;
  // Passes with the push constants OrderedKeepPush and OrderedMergePush, of the latter one for each part of the longest
  // list, or as many as `parts` says. `pass` comes with name, shader, the technique's constants and bindings.
  void record_keep(gpu::ComputePass pass) const;
  void record_merge(const gpu::ComputePass& pass) const { record_merge(pass, lists_.parts); }
  void record_merge(const gpu::ComputePass& pass, std::uint32_t parts) const;

 private:
  void record(gpu::ComputePass pass) const;

  gpu::PassRecorder& recorder_;
  const FrameSetup& setup_;
  const FragmentLists& lists_;
  const OrderedState& state_;
  gpu::Buffer &kept_, &surfaces_;
  gpu::AddressTable& surfaces_address_;
};

}  // namespace subpixel::replay
