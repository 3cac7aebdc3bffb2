// Every Vulkan call of the library that makes, allocates, binds or maps something can be made to fail, and what was
// made is counted. The linker puts these functions in the calls' place (tests/CMakeLists.txt).
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace subpixel::tests {

// The call of that number from now on fails with VK_ERROR_OUT_OF_DEVICE_MEMORY; 1 is the next, 0 none.
void fail_vulkan_call(std::size_t number);
// Calls that could have failed since.
std::size_t vulkan_calls();
// Objects that were made and not yet destroyed, by the name of the call that makes them.
std::map<std::string, int> live_vulkan_objects();

}  // namespace subpixel::tests
