// RenderDoc's in-application interface: captures what this process submits, when it runs under RenderDoc.
// https://renderdoc.org/docs/in_application_api.html
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

namespace subpixel::gpu {

// The functions of API 1.1.2 in their order, by which every later 1.x begins too; those unused here have no types.
struct RenderDocFunctions {
  void* unused_0[11];
  void (*set_capture_file_path_template)(const char* path);
  void* unused_12;
  std::uint32_t (*get_num_captures)();
  std::uint32_t (*get_capture)(std::uint32_t index, char* path, std::uint32_t* path_length, std::uint64_t* time);
  void* unused_15[4];
  void (*start_frame_capture)(void* device, void* window);
  void* unused_20;
  std::uint32_t (*end_frame_capture)(void* device, void* window);
};

class RenderDoc {
 public:
  // None when the process does not run under RenderDoc. Its Vulkan layer may load it with the first instance, so ask
  // once a device is there, and use it while that lives.
  static std::optional<RenderDoc> of_process();

  // Captures what `work` submits into a file whose path begins with `stem`, which is made absolute; returns the file.
  // Throws DeviceError when RenderDoc makes none, and what `work` throws.
  std::filesystem::path capture(const std::filesystem::path& stem, const std::function<void()>& work) const;

 private:
  explicit RenderDoc(const RenderDocFunctions* functions) : functions_(functions) {}
  const RenderDocFunctions* functions_;
};

}  // namespace subpixel::gpu
