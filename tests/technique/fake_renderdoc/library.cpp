// Stands in for librenderdoc.so when preloaded: writes to the file $FAKE_RENDERDOC_LOG when a capture starts and ends,
// under which path, and each submission to a queue. $FAKE_RENDERDOC_FAILS: it captures nothing.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "replay/gpu/renderdoc.hpp"

namespace {

void log(const std::string& line) {
  if (const char* const path = std::getenv("FAKE_RENDERDOC_LOG")) std::ofstream(path, std::ios::app) << line << "\n";
}

std::string capture_path;
std::uint32_t captures = 0;

subpixel::gpu::RenderDocFunctions functions() {
  subpixel::gpu::RenderDocFunctions table{};
  table.set_capture_file_path_template = [](const char* path) { capture_path = std::string(path) + "_frame7.rdc"; };
  table.get_num_captures = [] { return captures; };
  table.get_capture = [](std::uint32_t index, char* path, std::uint32_t* length, std::uint64_t*) {
    if (index >= captures) return 0u;
    if (path) std::memcpy(path, capture_path.c_str(), capture_path.size() + 1);
    if (length) *length = static_cast<std::uint32_t>(capture_path.size() + 1);
    return 1u;
  };
  table.start_frame_capture = [](void*, void*) { log("start"); };
  table.end_frame_capture = [](void*, void*) {
    if (std::getenv("FAKE_RENDERDOC_FAILS")) return 0u;
    log("end " + capture_path);
    ++captures;
    return 1u;
  };
  return table;
}

}  // namespace

extern "C" {

int RENDERDOC_GetAPI(int version, void** out) {
  static subpixel::gpu::RenderDocFunctions table = functions();
  if (version != 10102) return 0;
  *out = &table;
  return 1;
}

VkResult vkQueueSubmit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
  static const auto real = reinterpret_cast<PFN_vkQueueSubmit>(dlsym(RTLD_NEXT, "vkQueueSubmit"));
  log("submit");
  return real(queue, count, submits, fence);
}
}
