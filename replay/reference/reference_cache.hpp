// References on disk, by what they are made from.
//
// A file is a header (magic, form, width, height, payload bytes, XXH3-128 of all that and the payload) and the payload:
// both images' floats, split into byte planes and compressed with zstd. A file that is not exactly that counts as
// absent.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "replay/reference/reference.hpp"

namespace subpixel::replay {

// 32 hex digits: XXH3-128 of everything the image depends on: capture, frame, resolution, lights and all other frame
// constants, features, options, driver with version, CPU model, the SPIR-V of the passes and a revision of the host's
// part.
std::string reference_key(const gpu::Device& device, const GpuScene& scene, std::string_view capture_hash,
                          std::uint32_t frame, const ReferenceOptions& options);

class ReferenceCache {
 public:
  explicit ReferenceCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path path_of(std::string_view key) const;
  // The image, or none when there is no file of that key or anything in it is wrong.
  std::optional<ReferenceImage> load(std::string_view key) const;
  // Complete or not at all, also when several processes store at once. Throws InputError when it can't be written.
  void store(std::string_view key, const ReferenceImage& image) const;

 private:
  std::filesystem::path folder_;
};

struct CachedReference {
  ReferenceImage image;
  bool from_cache = false;
  std::string store_error;  // why the image could not be kept; empty when it was
};

// The reference of the scene's current frame, number `frame`, from the cache or computed and kept.
CachedReference cached_reference(gpu::Device& device, GpuScene& scene, std::string_view capture_hash,
                                 std::uint32_t frame, const ReferenceOptions& options, const ReferenceCache& cache,
                                 const ReferenceProgress& progress = {});
// The same of a capture that is in no file.
CachedReference cached_reference(gpu::Device& device, GpuScene& scene, std::uint32_t frame,
                                 const ReferenceOptions& options, const ReferenceCache& cache);

}  // namespace subpixel::replay
