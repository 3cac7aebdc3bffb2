// Tests under the Khronos validation layer, its checks of synchronization included.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "replay/gpu/device.hpp"

namespace subpixel::replay {

class Validation : public testing::Test {
 protected:
  void SetUp() override {
    if (!gpu::validation_layer_is_installed())
      GTEST_SKIP() << "no VK_LAYER_KHRONOS_validation (Debian: vulkan-validationlayers)";
  }

  // What the layer says while a device runs `work`, from its making to its end.
  template <typename Work>
  std::vector<std::string> messages(Work work, gpu::DeviceOptions options = {}) {
    std::vector<std::string> said;
    options.validation_messages = &said;
    {
      gpu::Device device(options);
      work(device, said);
    }
    return said;
  }
};

}  // namespace subpixel::replay
