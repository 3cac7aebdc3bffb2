#include "replay/gpu/litmus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/error.hpp"
#include "replay/gpu/pass_recorder.hpp"
#include "shaders/frontend/frontend_interface.h"

namespace subpixel::gpu {
namespace {

constexpr std::uint32_t kSide = 256;       // several tiles in each direction
constexpr std::uint32_t kTriangles = 512;  // over each pixel

const char* name(OrderedMemory memory) {
  return memory == OrderedMemory::attachment ? "attachment" : "buffer";
}

}  // namespace

LitmusResult run_order_litmus(Device& device, OrderedMemory memory) {
  PassRecorder recorder(device);
  constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
  const bool attachment = memory == OrderedMemory::attachment;
  RasterPass pass;
  pass.name = "order litmus";
  pass.pipeline.vertex = "frontend/litmus.vert";
  pass.pipeline.fragment = attachment ? "frontend/litmus.frag:ATTACHMENT" : "frontend/litmus.frag:BUFFER";
  pass.pipeline.constants = {{FRONTEND_CONSTANT_LITMUS_WIDTH, kSide}};
  Image* image = nullptr;
  Buffer* buffer = nullptr;
  if (attachment) {
    image = &recorder.image({"order litmus", kWords, kSide, kSide, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                             VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false});
    pass.pipeline.targets.ordered_read = pass.pipeline.targets.clear = true;
    pass.colours = {{*image}};
    pass.clear_colours = {{}};
  } else {
    buffer = &recorder.buffer("order litmus", std::uint64_t{kSide} * kSide * 16);
    pass.size = {kSide, kSide};
    pass.bindings = {writes(FRONTEND_SLOT_LITMUS_STATES, *buffer)};
  }
  pass.draws = [](DrawEncoder& encoder) { encoder.draw(3 * kTriangles); };
  recorder.raster(std::move(pass));
  recorder.run();

  std::vector<std::uint32_t> states(std::size_t{kSide} * kSide * 4);
  if (attachment) {
    const auto bytes = download(device, *image);
    std::memcpy(states.data(), bytes.data(), bytes.size());
  } else {
    std::ranges::copy(buffer->as<std::uint32_t>(), states.begin());
  }
  LitmusResult result;
  for (std::size_t i = 0; i < states.size(); i += 4) {
    result.fragments += kTriangles;
    result.order_violations += states[i + 2];
    result.lost_updates += kTriangles - std::min(kTriangles, states[i + 1]);
  }
  return result;
}

void require_ordered_access(Device& device) {
  if (!device.info().ordered_attachments) return;
  for (const OrderedMemory memory : {OrderedMemory::attachment, OrderedMemory::buffer}) {
    if (memory == OrderedMemory::buffer && !device.info().fragment_stores) continue;
    const LitmusResult result = run_order_litmus(device, memory);
    if (result.order_violations == 0 && result.lost_updates == 0) continue;
    throw DeviceError(
        "device",
        fmt::format(
            "fragments of a pixel are not in primitive order: {} violations and {} lost updates in {} through {}",
            result.order_violations, result.lost_updates, result.fragments, name(memory)),
        "ordered-access litmus on " + device.info().device);
  }
}

}  // namespace subpixel::gpu
