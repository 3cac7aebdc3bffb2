#include "capture_format/recorder_parts.hpp"

#include <cstdint>

#include "base/error.hpp"
#include "base/hash.hpp"

namespace subpixel::capture {

std::string texture_key(const Texture& texture) {
  const Sampler& sampler = texture.sampler;
  std::string key = content_hash_hex(texture.bytes) + (texture.srgb ? " srgb " : " linear ");
  for (const std::uint32_t part :
       {texture.width, static_cast<std::uint32_t>(texture.encoding), static_cast<std::uint32_t>(sampler.wrap_u),
        static_cast<std::uint32_t>(sampler.wrap_v), static_cast<std::uint32_t>(sampler.magnify),
        static_cast<std::uint32_t>(sampler.minify), static_cast<std::uint32_t>(sampler.mip)}) {
    key += std::to_string(part) + " ";
  }
  return key;
}

Report refuse_to_record(std::string_view what) {
  return [what](std::string_view field, const std::string& why) {
    throw UsageError("can't record the " + std::string(what), why, "field " + std::string(field));
  };
}

void require_of_caller(bool holds, const char* what, const char* why) {
  if (!holds) throw UsageError(what, why, "");
}

}  // namespace subpixel::capture
