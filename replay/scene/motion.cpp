#include "replay/scene/motion.hpp"

#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "capture_format/streams.hpp"
#include "replay/scene/camera.hpp"

namespace subpixel::replay {
namespace {

double radical_inverse(std::uint64_t number, std::uint32_t base) {
  double result = 0, digit = 1.0 / base;
  for (; number > 0; number /= base, digit /= base) result += static_cast<double>(number % base) * digit;
  return result;
}

// What tells draws of a frame apart: names, or geometry where there are none; then the how-manieth of those.
using DrawKey = std::tuple<std::string, std::uint32_t, std::uint64_t, std::uint64_t, std::uint32_t>;
DrawKey key_of(const capture::Draw& draw, std::map<DrawKey, std::uint32_t>& seen) {
  DrawKey key{draw.name, 0, 0, 0, 0};
  if (draw.name.empty()) key = {"", draw.position.buffer, draw.position.offset, draw.index_offset, 0};
  std::get<4>(key) = seen[key]++;
  return key;
}

bool finite(const glm::dmat4& m) {
  double sum = 0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) sum += std::abs(m[c][r]);
  return std::isfinite(sum);
}

}  // namespace

glm::dvec2 jitter_of(std::int64_t time, std::uint32_t length) {
  if (length == 1) return {0, 0};
  const std::int64_t turn = (time % length + length) % length;
  const auto number = static_cast<std::uint64_t>(turn + 1);
  return glm::dvec2(radical_inverse(number, 2), radical_inverse(number, 3)) - 0.5;
}

FrameMotion frame_motion(const capture::Capture& capture, std::uint32_t frame, std::uint32_t before,
                         const glm::dvec2& jitter, const glm::dvec2& size) {
  const capture::Frame &now = capture.frames.at(frame), &past = capture.frames.at(before);
  const Camera camera = camera_of(now, frame), camera_before = camera_of(past, before);
  const glm::dmat4 unjitter = moved_image(jitter, size);
  FrameMotion motion;
  motion.unjitter = glm::vec2(unjitter[3]);
  const glm::dmat4 unproject = camera_before.view * camera_before.inverse_view_projection;
  motion.distance_before = glm::vec4(-unproject[2][2], -unproject[3][2], unproject[2][3], unproject[3][3]);

  const auto difference = [&](const glm::dmat4& moved) {
    if (camera.view_projection == camera_before.view_projection && moved == glm::dmat4(1)) return glm::mat4(0);
    return glm::mat4(camera_before.view_projection * moved * camera.inverse_view_projection * unjitter - unjitter);
  };
  std::map<DrawKey, std::uint32_t> seen_before, seen;
  std::map<DrawKey, const capture::Draw*> draws_before;
  for (const capture::Draw& draw : past.draws) draws_before.emplace(key_of(draw, seen_before), &draw);
  for (const capture::Draw& draw : now.draws) {
    const auto found = draws_before.find(key_of(draw, seen));
    if (capture::triangle_count(draw) == 0) continue;  // GpuScene has no instances of it
    const bool matched = found != draws_before.end() && found->second->instance_count == draw.instance_count &&
                         found->second->index_count == draw.index_count;
    const auto worlds = capture::world_transforms(capture, draw);
    const auto worlds_before = matched ? capture::world_transforms(capture, *found->second) : worlds;
    if (!matched) motion.unmatched += draw.instance_count;
    for (std::size_t i = 0; i < worlds.size(); ++i) {
      glm::dmat4 moved(1);
      if (worlds[i] != worlds_before[i]) moved = matrix(worlds_before[i]) * glm::inverse(matrix(worlds[i]));
      motion.differences.push_back(difference(finite(moved) ? moved : glm::dmat4(1)));
    }
  }
  motion.differences.push_back(difference(glm::dmat4(1)));
  return motion;
}

}  // namespace subpixel::replay
