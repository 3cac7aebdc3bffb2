// Texture files to mipmapped texels.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/scene/materials.hpp"

namespace subpixel::replay {

// Largest side kept; larger images are halved until they fit.
inline constexpr std::uint32_t kMaxTextureSide = 4096;

// Four 8-bit channels, top row first, straight alpha. Level i is max(1, size >> i) texels wide and high.
struct Mipmaps {
  std::uint32_t width = 0, height = 0;  // of level 0
  bool srgb = false;                    // colour channels are sRGB-encoded
  std::vector<std::vector<std::uint8_t>> levels;
};

// The texels of a captured texture at full size, one level. Grey becomes RGB, missing alpha 255. Throws InputError
// naming the texture when it can't be decoded or is larger than a capture may hold.
Mipmaps decode_texture(const capture::Texture& texture);

// Adds all levels down to 1x1 by a box filter in linear light, after halving level 0 to fit kMaxTextureSide.
// `alpha_weighted`: colours are averaged by alpha, so that what is cut away doesn't bleed in, and fully transparent
// texels take the colour around them. `alpha_cutoff`: each level's alpha is scaled so that as many texels pass the
// cutoff as at level 0 (Castano, "Computing alpha mipmaps", 2010), or foliage would thin out with distance. Not for
// textures whose sampler says that their levels are means.
void build_mipmaps(Mipmaps& image, bool alpha_weighted, std::optional<float> alpha_cutoff);

// Both for one use of a captured texture; of one whose sampler knows no other, level 0 alone.
Mipmaps load_texture(const capture::Capture& capture, const TextureUse& use);

}  // namespace subpixel::replay
