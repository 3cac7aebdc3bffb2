#include "replay/reference/texture_table.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "replay/scene/materials.hpp"
#include "replay/scene/textures.hpp"
#include "shaders/reference/reference_interface.h"

namespace subpixel::replay {
namespace {

std::uint32_t level_bits(const Mipmaps& mipmaps, const capture::Sampler& sampler) {
  std::uint32_t bits = mipmaps.srgb ? LEVEL_SRGB : 0u;
  bits |= static_cast<std::uint32_t>(sampler.wrap_u) << LEVEL_WRAP_U_SHIFT;
  bits |= static_cast<std::uint32_t>(sampler.wrap_v) << LEVEL_WRAP_V_SHIFT;
  if (sampler.magnify == capture::TexelFilter::nearest) bits |= LEVEL_MAGNIFY_NEAREST;
  if (sampler.minify == capture::TexelFilter::nearest) bits |= LEVEL_MINIFY_NEAREST;
  if (sampler.mip == capture::MipFilter::nearest || sampler.mip == capture::MipFilter::nearest_of_means)
    bits |= LEVEL_MIP_NEAREST;
  return bits;
}

}  // namespace

TextureTable make_texture_table(gpu::Device& device, const capture::Capture& capture) {
  std::vector<gpu_types::TextureLevel> levels;
  std::vector<Mipmaps> textures;
  std::map<std::uint32_t, std::uint32_t> references;
  std::uint64_t texels = 0;
  for (const auto& use : texture_uses(capture)) {
    const auto& mipmaps = textures.emplace_back(load_texture(capture, use));
    references[use.texture] =
        static_cast<std::uint32_t>(levels.size()) | static_cast<std::uint32_t>(mipmaps.levels.size()) << 24;
    const std::uint32_t bits = level_bits(mipmaps, capture.textures[use.texture].sampler);
    for (std::size_t l = 0; l < mipmaps.levels.size(); ++l) {
      levels.push_back({{static_cast<std::uint32_t>(texels), std::max(1u, mipmaps.width >> l),
                         std::max(1u, mipmaps.height >> l), bits}});
      texels += mipmaps.levels[l].size() / 4;
    }
  }
  if (texels > std::numeric_limits<std::uint32_t>::max() || levels.size() >= 1u << 24)
    throw DeviceError("reference", "more texels than 32-bit numbers address", "texture table");

  TextureTable table;
  table.texels = gpu::Buffer(device, "reference texels", texels * 4);
  auto to = table.texels.mapped();
  for (const auto& mipmaps : textures)
    for (const auto& level : mipmaps.levels) {
      std::memcpy(to.data(), level.data(), level.size());
      to = to.subspan(level.size());
    }
  // One level is always there, so that pixels without a texture have something valid to look at.
  if (levels.empty()) levels.push_back({{0, 1, 1, 0}});
  table.levels = gpu::Buffer(device, "reference texture levels", levels.size() * sizeof levels[0]);
  std::copy(levels.begin(), levels.end(), table.levels.as<gpu_types::TextureLevel>().begin());
  table.materials = gpu::Buffer(device, "reference material textures", capture.materials.size() * 16);
  const auto numbers = table.materials.as<std::uint32_t>();
  for (std::size_t m = 0; m < capture.materials.size(); ++m) {
    const auto captured = textures_of(capture.materials[m]);
    for (std::size_t i = 0; i < captured.size(); ++i) {
      const auto found = references.find(captured[i]);
      numbers[4 * m + i] = found == references.end() ? REFERENCE_NO_TEXTURE : found->second;
    }
  }
  return table;
}

}  // namespace subpixel::replay
