// Which textures a material reads, and where on them: the four pairs of fields of Material as one list.
#pragma once

#include <cstdint>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct TextureRead {
  const char* name;  // of the UvMapping's field in Material
  std::uint32_t texture;
  const UvMapping* uv;  // lives as long as the material
};

// The textures the material has, in the order of its fields.
std::vector<TextureRead> texture_reads(const Material& material);

// Whether one of them is read at UV set `set`.
bool reads_uv_set(const Material& material, std::uint32_t set);

}  // namespace subpixel::capture
