// All textures of a scene in one buffer, for a pass that can't know which of them it will read.
#pragma once

#include "capture_format/capture.hpp"
#include "replay/gpu/resources.hpp"

namespace subpixel::replay {

struct TextureTable {
  gpu::Buffer texels;     // four bytes each, levels one after the other
  gpu::Buffer levels;     // TextureLevel
  gpu::Buffer materials;  // uvec4: each material's textures in the order of textures_of()
};

// The same texels and mipmaps as the scene's images. Throws InputError (a texture that can't be decoded) and
// DeviceError (more texels than the device's largest buffer holds).
TextureTable make_texture_table(gpu::Device& device, const capture::Capture& capture);

}  // namespace subpixel::replay
