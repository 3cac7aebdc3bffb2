#include "capture_format/texture_reads.hpp"

#include <algorithm>

namespace subpixel::capture {

std::vector<TextureRead> texture_reads(const Material& material) {
  std::vector<TextureRead> reads;
  for (const TextureRead& read :
       {TextureRead{"base_colour_uv", material.base_colour_texture, &material.base_colour_uv},
        TextureRead{"metallic_roughness_uv", material.metallic_roughness_texture, &material.metallic_roughness_uv},
        TextureRead{"normal_uv", material.normal_texture, &material.normal_uv},
        TextureRead{"emissive_uv", material.emissive_texture, &material.emissive_uv}}) {
    if (read.texture != kNone) reads.push_back(read);
  }
  return reads;
}

bool reads_uv_set(const Material& material, std::uint32_t set) {
  const std::vector<TextureRead> reads = texture_reads(material);
  return std::any_of(reads.begin(), reads.end(), [&](const TextureRead& read) { return read.uv->set == set; });
}

}  // namespace subpixel::capture
