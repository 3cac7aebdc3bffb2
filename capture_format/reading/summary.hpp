// What `subpixel info` prints of a capture, and the service lists.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// What of shading and geometry the capture uses, in words: "textures", "alpha test", "normal maps", "emissive",
// "metal", "two-sided", "blending", "instancing", "shadows", "spot lights", "vertex colours", "second UV set",
// "texture transforms", "samplers" (others than repeat and linear), "unlit". Only materials that some draw uses count.
struct UsedFeature {
  std::string name;
  std::string why;  // "2 of 9 materials: leaf, grass", "12 of 40 draws": of all frames
};
std::vector<UsedFeature> used_features(const Capture& capture);

// {title, application, tool, licence, metres_per_unit, notices: [...], hash, file_bytes, frame_count, width, height,
// triangles, draws,
//  point_lights, buffers: {count, bytes}, textures: {count, bytes}, materials, features: [...],
//  feature_reasons: {FEATURE: why}, frames: [{name, time_s, width, height, draws, triangles, point_lights}]}
// width and height are the first frame's; triangles, draws and point_lights those of the frame that has most of each.
// `hash` is the content hash of the file, `file_bytes` its size.
nlohmann::json summarize(const Capture& capture, const std::string& hash, std::uint64_t file_bytes);

// The same of a capture whose buffers and textures have these sizes, whether or not their bytes are there.
nlohmann::json summarize(const Capture& capture, std::span<const std::uint64_t> buffer_bytes,
                         std::span<const std::uint64_t> texture_bytes, const std::string& hash,
                         std::uint64_t file_bytes);

}  // namespace subpixel::capture
