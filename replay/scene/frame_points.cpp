#include "replay/scene/frame_points.hpp"

#include <algorithm>

#include "capture_format/streams.hpp"

namespace subpixel::replay {

std::vector<std::uint32_t> light_stage_frames(std::size_t frame_count) {
  constexpr std::size_t kMost = 8;
  const std::size_t count = std::min(frame_count, kMost);
  std::vector<std::uint32_t> frames;
  for (std::size_t i = 0; i < count; ++i) frames.push_back(static_cast<std::uint32_t>(i * frame_count / count));
  return frames;
}

LightStage light_stage(const capture::Capture& capture, std::uint32_t frame, const GeometryPlan& plan,
                       std::span<const float> positions, std::span<const std::uint32_t> indices) {
  LightStage stage;
  stage.camera = camera_of(capture.frames[frame], frame);
  stage.exposure = capture.frames[frame].exposure;
  std::vector<std::uint64_t> ends;  // triangles up to and including each draw
  for (const auto& draw : capture.frames[frame].draws) {
    stage.point_count += capture::triangle_count(draw);
    ends.push_back(stage.point_count);
  }
  stage.point = [&capture, frame, &plan, positions, indices, ends = std::move(ends)](std::uint64_t number) {
    const auto d = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), number) - ends.begin());
    const auto& draw = capture.frames[frame].draws[d];
    const auto& mesh = plan.meshes[plan.mesh_of_draw[frame][d]];
    const std::uint64_t in_draw = number - (d > 0 ? ends[d - 1] : 0);
    glm::dvec3 sum(0);
    for (std::uint64_t corner = 0; corner < 3; ++corner) {
      const std::size_t vertex = indices[mesh.first_index + 3 * (in_draw % mesh.triangle_count) + corner];
      sum += glm::dvec3(positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]);
    }
    const auto instance = static_cast<std::size_t>(in_draw / mesh.triangle_count);
    const glm::dmat4 world = matrix(capture::world_transforms(capture, draw)[instance]);
    return glm::dvec3(world * glm::dvec4(sum / 3.0, 1));
  };
  return stage;
}

}  // namespace subpixel::replay
