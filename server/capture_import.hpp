// Uploads that are models or frames of RenderDoc become captures in a process of their own.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "server/job_queue.hpp"
#include "server/store/data_folder.hpp"

namespace subpixel::server {

// What an upload is by its first bytes: ".glb", ".zip" (of glTF or OBJ with textures) or ".rdc"; nothing when it is not
// imported.
std::optional<std::string> imported_kind(const std::filesystem::path& upload);

// A capture made of an upload, in a folder of its own that goes with this object.
class CaptureImport {
 public:
  // `name` is what the user calls the upload; messages and the capture's title have what of it makes a file name.
  // Throws HttpError 422 with the importer's reason, 503 when the service ends meanwhile.
  CaptureImport(const DataFolder& folder, const std::filesystem::path& upload, const std::string& kind,
                const std::string& name, const WorkerOptions& worker, std::uint64_t largest_bytes,
                std::stop_token stop);
  CaptureImport(const CaptureImport&) = delete;
  CaptureImport& operator=(const CaptureImport&) = delete;
  ~CaptureImport();

  std::filesystem::path file() const { return folder_ / "out" / "capture"; }

 private:
  void run(const std::filesystem::path& model, const std::string& kind, const WorkerOptions& worker,
           std::uint64_t largest_bytes, std::stop_token stop) const;

  std::filesystem::path folder_;
};

}  // namespace subpixel::server
