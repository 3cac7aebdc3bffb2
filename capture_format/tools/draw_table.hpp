// The draws of a frame as `subpixel info --draws` prints them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Of `frame`, which is below the number of frames, in the order of submission:
// {frame, name, draws: [{draw, name, material: {number, name}, triangles, instances, vertices,
//  index_type: "none" | "u8" | "u16" | "u32", textures: [{slot, texture, name}], bytes}]}
// triangles are those of all instances, bytes what the draw reads of buffers: elements of its streams, indices and
// instance matrices, also where other draws read the same. The buffers' own bytes are not looked at.
nlohmann::json draw_table(const Capture& capture, std::uint32_t frame);

}  // namespace subpixel::capture
