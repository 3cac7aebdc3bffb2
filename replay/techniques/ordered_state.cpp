#include "replay/techniques/ordered_state.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "replay/frame/frame_images.hpp"
#include "shaders/include/ordered_state.h"

namespace subpixel::replay {
namespace {

// INTERLOCK where the device orders accesses to buffers, else BUFFER, whose order the start-up litmus has proven.
const char* buffer_variant(const gpu::Device& device) {
  return device.info().pixel_interlock ? "INTERLOCK" : "BUFFER";
}

// Of the fragments that reach a buffer: the interlock's, or that which the litmus at start-up has proven.
void require_order(const gpu::Device& device, const std::string& pass) {
  const gpu::DeviceInfo& info = device.info();
  if (info.ordered_attachments || info.pixel_interlock) return;
  throw DeviceError("device",
                    fmt::format("{} has neither {} nor {}, so that the pass has no order of fragments; only lists "
                                "(order=lists, of frames that have them) do without",
                                info.device, gpu::kOrderedAttachments, gpu::kPixelInterlock),
                    "pass " + pass);
}

gpu::AddressTable& address_of(gpu::PassRecorder& recorder, gpu::Buffer& buffer) {
  gpu::AddressTable& table = recorder.address_table(buffer.name() + " address", sizeof(VkDeviceAddress));
  table.set(table.of(buffer));
  return table;
}

}  // namespace

std::uint64_t padded_pixels(const FrameSetup& setup) {
  return std::uint64_t{setup.width} * ((setup.height + 3) / 4 * 4) + 4;
}

void OrderedState::bind(gpu::RasterPass& pass) const {
  pass.bindings.push_back(image != nullptr ? gpu::samples(ORDERED_SLOT_ATTACHMENTS, *image)
                                           : gpu::reads(ORDERED_SLOT_ADDRESS, *address));
  if (entries != nullptr) pass.bindings.push_back(gpu::reads(ORDERED_SLOT_ENTRIES, *entries_address));
}

OrderedState make_ordered_state(gpu::PassRecorder& recorder, const FrameSetup& setup, const std::string& name,
                                std::uint32_t quads, bool in_buffer) {
  OrderedState state;
  const std::uint32_t most = recorder.device().info().eight_attachments ? ORDERED_MOST_ATTACHMENTS : 4u;
  if (quads <= most && !in_buffer && recorder.device().info().ordered_attachments) {
    state.image = &target_array(recorder, setup, name, VK_FORMAT_R32G32B32A32_UINT,
                                std::max<std::uint32_t>(quads, ORDERED_FEWEST_ATTACHMENTS));
  } else {
    state.words = &recorder.buffer(name, padded_pixels(setup) * quads * 16);
    state.address = &address_of(recorder, *state.words);
  }
  return state;
}

void add_entries(gpu::PassRecorder& recorder, const FrameSetup& setup, OrderedState& state, const std::string& name,
                 std::uint32_t words) {
  constexpr std::uint64_t kTile = ORDERED_TILE;
  const std::uint64_t tiles = (setup.width + kTile - 1) / kTile * ((setup.height + kTile - 1) / kTile);
  state.entries = &recorder.buffer(name, tiles * kTile * kTile * words * 4);
  state.entries_address = &address_of(recorder, *state.entries);
}

void record_ordered(gpu::PassRecorder& recorder, const FrameSetup& setup, const OrderedState& state,
                    Frontend::GeometryPass geometry, const std::string& shader) {
  geometry.by_material = true;
  if (state.image != nullptr) {
    geometry.fragment_opaque = shader + ":" + std::to_string(state.image->description().layers);
    attach_ordered(geometry.pass, *state.image);
  } else {
    require_order(recorder.device(), geometry.pass.name);
    geometry.fragment_opaque = shader + ":" + buffer_variant(recorder.device());
    recorder.fill(geometry.pass.name, *state.words, 0);
    geometry.pass.bindings.push_back(gpu::writes(ORDERED_SLOT_ADDRESS, *state.address));
    geometry.pass.size = {setup.width, setup.height};
  }
  if (state.entries != nullptr)
    geometry.pass.bindings.push_back(gpu::writes(ORDERED_SLOT_ENTRIES, *state.entries_address));
  setup.frontend.record_geometry(recorder, std::move(geometry));
}

void attach_ordered(gpu::RasterPass& pass, gpu::Image& image) {
  pass.pipeline.targets.ordered_read = true;
  pass.pipeline.targets.clear = true;
  for (std::uint32_t i = 0; i < image.description().layers; ++i) pass.colours.emplace_back(image, i);
  pass.clear_colours.assign(pass.colours.size(), {});
}

ListedState::ListedState(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists,
                         const OrderedState& state, std::uint64_t surface_bytes)
    : recorder_(recorder),
      setup_(setup),
      lists_(lists),
      state_(state),
      kept_(recorder.buffer("kept fragments", std::uint64_t{setup.width} * setup.height * 4)),
      surfaces_(recorder.buffer("fragment surfaces", lists.count * surface_bytes)),
      surfaces_address_(address_of(recorder, surfaces_)) {}

gpu::Binding ListedState::surfaces() const {
  return gpu::writes(ORDERED_SLOT_SURFACES, surfaces_address_);
}

void ListedState::record_keep(gpu::ComputePass pass) const {
  const gpu_types::OrderedKeepPush push{.lists = lists_.writes(pass),
                                        .records = pass.reads(setup_.frontend.records()),
                                        .kept = pass.writes(kept_),
                                        .state = pass.writes(*state_.words),
                                        .width = setup_.width,
                                        .height = setup_.height};
  pass.push = gpu::PushConstants(push);
  record(std::move(pass));
}

void ListedState::record_merge(const gpu::ComputePass& pass, std::uint32_t parts) const {
  for (std::uint32_t part = 0; part < parts; ++part) {
    gpu::ComputePass merge = pass;
    merge.push = gpu::PushConstants(gpu_types::OrderedMergePush{.lists = lists_.reads(merge),
                                                                .surfaces = merge.reads(surfaces_),
                                                                .kept = merge.reads(kept_),
                                                                .state = merge.writes(*state_.words),
                                                                .width = setup_.width,
                                                                .height = setup_.height,
                                                                .part = part});
    record(std::move(merge));
  }
}

void ListedState::record(gpu::ComputePass pass) const {
  for (const auto& constant : setup_.frontend.constants()) pass.constants.push_back(constant);
  pass.bindings.push_back(gpu::uniform(setup_.scene.frame_constants));
  pass.groups = {(setup_.width + 7) / 8, (setup_.height + 7) / 8, 1};
  recorder_.compute(std::move(pass));
}

}  // namespace subpixel::replay
