// Proof at start-up that fragments of a pixel see each other's writes in primitive order.
#pragma once

#include "replay/gpu/device.hpp"

namespace subpixel::gpu {

// attachment: read and written in the order that VK_EXT_rasterization_order_attachment_access promises. buffer: plain
// reads and writes of a storage buffer, which nothing promises; techniques use it for states of more than 32 words a
// pixel.
enum class OrderedMemory { attachment, buffer };

struct LitmusResult {
  std::uint64_t fragments = 0, order_violations = 0, lost_updates = 0;
};

// Draws overlapping triangles whose fragments read the pixel, check that the triangle before them wrote it, and write.
LitmusResult run_order_litmus(Device& device, OrderedMemory memory);
// Throws DeviceError with the counts when any fragment was out of order or lost, in either memory. Of a device without
// ordered attachments nothing is asked: passes that need order refuse it (require_order()).
void require_ordered_access(Device& device);

}  // namespace subpixel::gpu
