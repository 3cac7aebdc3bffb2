// Vertex streams, indices and instance transforms of a draw, decoded to plain arrays.
// Everything here trusts offsets and indices: call it on what read_capture() returned, or after check_draw() was clean.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

std::uint32_t component_count(VertexFormat format);
std::uint32_t element_bytes(VertexFormat format);

// The first `count` elements of `stream` as floats, tightly packed with `components` (1 to 4) of each. Components the
// format lacks are 0, the fourth is 1. Snorm values are max(v / max, -1) as Vulkan has it. NaN and infinities pass
// through. An absent stream gives an empty vector.
std::vector<float> decode_stream(const Capture& capture, const VertexStream& stream, std::uint32_t count,
                                 std::uint32_t components);

// The vertices of the draw in triangle-list order: three for each triangle, below vertex_count, base_vertex added; an
// unindexed list gives 0, 1, 2, ... Strips and fans become lists: triangle i of a strip has the corners i, i + 1, i +
// 2, the last two exchanged where i is odd, of a fan i + 1, i + 2, 0. Restarts begin anew.
std::vector<std::uint32_t> decode_indices(const Capture& capture, const Draw& draw);

// The vertices that the draw's indices name, whether or not they make triangles: all but restarts, base_vertex added,
// in their order. Of a list the same as decode_indices().
std::vector<std::uint32_t> named_vertices(const Capture& capture, const Draw& draw);

// Turns every strip and fan into a list of the same triangles, whose indices are in one more buffer; nothing else is
// changed. Throws InputError when that takes more than `most_bytes` or passes a limit.
void make_triangle_lists(Capture& capture, std::uint64_t most_bytes);

// Object-to-world matrices of the draw's instances: transform * instance matrix, instance_count of them.
std::vector<Matrix4> world_transforms(const Capture& capture, const Draw& draw);

std::uint32_t index_bytes(IndexType type);                   // of one index; 0 without
std::optional<std::uint32_t> restart_index(IndexType type);  // that begins a new strip or fan

// Triangles a draw submits, all instances together. Of strips and fans with restarts the most there can be; captures
// that were read have none of them.
std::uint64_t triangle_count(const Draw& draw);

// a * b, each element summed in float from the first column's product on, so that every user gets the same bits.
Matrix4 multiply(const Matrix4& a, const Matrix4& b);

float half_to_float(std::uint16_t half);

}  // namespace subpixel::capture
