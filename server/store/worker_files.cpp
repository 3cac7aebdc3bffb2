#include "server/store/worker_files.hpp"

#include "base/error.hpp"
#include "base/plain_file.hpp"
#include "base/printable.hpp"

namespace subpixel::server {
namespace {

// The bytes of a plain file named by the worker, which must not lead out of its folder.
std::string read_worker_file(const std::filesystem::path& folder, const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name.front() == '.' ||
      name.find('\0') != std::string::npos) {
    throw InputError("worker result", "an image's name is not a plain file name", printable(name, 80));
  }
  return read_plain_file(folder / name, kMaxImageBytes, "worker result: an image it names", printable(name, 80));
}

}  // namespace

std::string media_type_of(std::string_view file_name) {
  if (file_name.ends_with(".png")) return "image/png";
  if (file_name.ends_with(".exr")) return "image/x-exr";
  if (file_name.ends_with(".json")) return "application/json";
  return "application/octet-stream";
}

std::map<std::string, Blob> read_worker_images(const std::filesystem::path& folder, const replay::FrameResult& result) {
  if (result.images.size() > kMaxImages) {
    throw InputError("worker result", "it names too many images", std::to_string(result.images.size()));
  }
  std::map<std::string, Blob> images;
  for (const auto& [role, file] : result.images) {
    images[role] = Blob{media_type_of(file), read_worker_file(folder, file)};
  }
  return images;
}

}  // namespace subpixel::server
