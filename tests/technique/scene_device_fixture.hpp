// One device for all tests of an executable: making one takes longer than most tests.
#pragma once

#include "replay/gpu/device.hpp"

namespace subpixel::replay {

inline gpu::Device& test_device() {
  static gpu::Device device;
  return device;
}

}  // namespace subpixel::replay
