// How the image is shifted from turn to turn, so that a few samples a pixel become many.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "shaders/reference/reference_interface.h"

namespace subpixel::replay {

// Samples of a turn in each row and column of a pixel: 4 where there are 256 samples or more, a multiple of 16, and the
// image has at most 4 million pixels and 4096 each way, else 2. Sixteen at once are cheaper each. A triangle is shaded
// once for all four of a quarter that see it.
std::uint32_t turn_side(std::uint32_t samples, std::uint32_t width, std::uint32_t height);

// Constants of turns 0 to `turns` - 1 for an image of width x height pixels, drawn at `side` times that.
//
// Each sample stays in its cell of the pixel; the shifts are a Hammersley set in a cell, so all turns together cover
// the pixel evenly. The root mean square error of a half-plane's area is then 0.014 with 16 turns of four and 0.0029
// with 128, against 0.015 and 0.0031 for 64- and 512-point Hammersley sets in the pixel.
//
// Which of four samples is shaded that all see the same is chosen by the bits of the turn's number so that with 2^m
// turns each rectangle of 1/2^m of the pixel (of a quarter, where there are sixteen samples), cut by halves, has one
// shading point, as of a Hammersley set there: a shift's x begins with the number's high bits and its y with the low
// ones, so that any two neighbouring bits between choose the sample. Of the part that a triangle fills each sample is
// chosen equally often.
std::vector<gpu_types::TurnConstants> turn_constants(std::uint32_t turns, std::uint32_t side, std::uint32_t width,
                                                     std::uint32_t height);

// Where sample `s` of a turn lies in its pixel, [0, 1) each way; as sample_place() of the shaders.
glm::vec2 sample_place(const gpu_types::TurnConstants& turn, std::uint32_t s);

// Which of four samples a triangle is shaded at in this turn that all of them see.
std::uint32_t shaded_sample(const gpu_types::TurnConstants& turn);

}  // namespace subpixel::replay
