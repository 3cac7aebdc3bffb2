#include "replay/gpu/renderdoc.hpp"

#include <dlfcn.h>

#include <string>

#include "base/error.hpp"

namespace subpixel::gpu {
namespace {

constexpr int kApiVersion = 10102;  // 1.1.2

}  // namespace

std::optional<RenderDoc> RenderDoc::of_process() {
  // Looked for, not loaded: it has to be there before Vulkan is. Its place is never given up, as it can't be unloaded.
  void* const library = dlopen("librenderdoc.so", RTLD_NOW | RTLD_NOLOAD);
  if (!library) return std::nullopt;
  using GetApi = int (*)(int version, void** functions);
  const auto get_api = reinterpret_cast<GetApi>(dlsym(library, "RENDERDOC_GetAPI"));
  void* functions = nullptr;
  if (!get_api || get_api(kApiVersion, &functions) != 1 || !functions) return std::nullopt;
  return RenderDoc(static_cast<const RenderDocFunctions*>(functions));
}

std::filesystem::path RenderDoc::capture(const std::filesystem::path& stem, const std::function<void()>& work) const {
  const std::string absolute = std::filesystem::absolute(stem).string();
  functions_->set_capture_file_path_template(absolute.c_str());
  const std::uint32_t before = functions_->get_num_captures();
  // No device and no window: the one device of the process.
  functions_->start_frame_capture(nullptr, nullptr);
  try {
    work();
  } catch (...) {
    functions_->end_frame_capture(nullptr, nullptr);
    throw;
  }
  const bool ended = functions_->end_frame_capture(nullptr, nullptr) == 1;
  const std::uint32_t captures = functions_->get_num_captures();
  if (!ended || captures == before) throw DeviceError("capture", "RenderDoc made none", absolute);
  std::uint32_t length = 0;
  functions_->get_capture(captures - 1, nullptr, &length, nullptr);
  std::string path(length, '\0');
  functions_->get_capture(captures - 1, path.data(), &length, nullptr);
  return path.c_str();  // the length counts the zero at its end
}

}  // namespace subpixel::gpu
