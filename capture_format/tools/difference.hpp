// What differs between two captures, frame by frame and draw by draw, by what is drawn and not by how it is stored.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Frames are compared by number. Of a frame, draws are first matched among those of one name, in passes, each in the
// order of submission among what the passes before left: equal in all; next to a matched draw in both frames and equal
// in mesh, material or placement; equal in mesh and material; mesh and placement; material and placement; mesh; then
// those that are left, one after the other. Draws that have none of their name ("renamed") are matched with others that
// are equal in mesh and placement; then in mesh, the nearest; then in the positions of the mesh, the nearest; then with
// those of as many triangles whose boxes in world space are the same but for rounding; then with those that are alike
// in triangles, material and box (draw_matching.cpp). The rest was added or is gone. A mesh is equal when the decoded
// values of its triangles' corners are, one after the other, bit by bit: formats, buffers, indices and vertices that
// nobody reads do not matter. A placement is the world matrices of all instances in their order. Textures are equal in
// bytes, encoding, size and sampler. Names of buffers, textures and materials and the metadata but metres_per_unit do
// not count.
//
// {same, fields: [{field, a, b}], frames_a, frames_b, frames: [{frame, same, fields: [{field, a, b}],
//  draws_a, draws_b, equal, matched_by: {name, "mesh and placement", mesh, positions, bounds, likeness}, reordered,
//  added: [{draw, name}], gone: [{draw, name}],
//  changed: [{a, b, name, renamed, matched_by, moved, mesh: [names], material: [{field, a, b}],
//             textures: [{field, a, b}]}]}]}
// The first `fields` hold metres_per_unit, those of frames their camera, size, lights and the rest of their record;
// numbers of draws are those in their own frame. reordered: matched draws that would have to be taken out so that the
// others are in the same order. moved is null or {transform, instances: [a, b], distance}: how far the farthest point
// of the mesh's box went, world units, null where that can't be said. `mesh` has the streams and "triangles". Both
// captures must be ones that were read. Linear in draws and bytes but for sorting, and for the pairs of draws without
// their name's like of which none is equal in mesh and placement: those of up to 2^22 in a group are all looked at.
nlohmann::json difference(const Capture& a, const Capture& b,
                          std::optional<std::pair<std::uint32_t, std::uint32_t>> frames = {});

// The same for people, a line for each thing; names are made fit for a terminal.
std::string difference_text(const nlohmann::json& difference);

}  // namespace subpixel::capture
