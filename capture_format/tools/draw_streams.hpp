// The vertex streams of a draw as one list. Private to the tools.
#pragma once

#include <array>
#include <cstddef>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct StreamOfDraw {
  const char* name;
  VertexStream Draw::*member;
  std::uint32_t components;  // that are read of it
};

inline constexpr std::array kStreamsOfDraw{StreamOfDraw{"position", &Draw::position, 3},
                                           StreamOfDraw{"normal", &Draw::normal, 3},
                                           StreamOfDraw{"uv", &Draw::uv, 2},
                                           StreamOfDraw{"tangent", &Draw::tangent, 4},
                                           StreamOfDraw{"uv2", &Draw::uv2, 2},
                                           StreamOfDraw{"colour", &Draw::colour, 4}};
inline constexpr std::size_t kPositionOfDraw = 0;  // in kStreamsOfDraw

struct TextureOfMaterial {
  const char* name;
  std::uint32_t Material::*member;
};

inline constexpr std::array kTexturesOfMaterial{
    TextureOfMaterial{"base_colour_texture", &Material::base_colour_texture},
    TextureOfMaterial{"metallic_roughness_texture", &Material::metallic_roughness_texture},
    TextureOfMaterial{"normal_texture", &Material::normal_texture},
    TextureOfMaterial{"emissive_texture", &Material::emissive_texture}};

}  // namespace subpixel::capture
