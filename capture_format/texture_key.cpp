#include "capture_format/texture_key.hpp"

#include <cstdint>

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

}  // namespace subpixel::capture
