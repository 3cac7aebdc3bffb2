// Puts together a capture of a still scene seen from a moving camera: what generators and the importer make.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <span>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/recorder.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/builder/mesh.hpp"

namespace subpixel::capture {

class SceneBuilder {
 public:
  explicit SceneBuilder(Metadata metadata) : recorder_(std::move(metadata)) {}

  // Lights, sky, ambient and exposure of every frame. Its draws, matrices and size are not used.
  Frame environment;

  std::uint32_t add_texture(Texture texture) { return recorder_.add_texture(std::move(texture)); }
  std::uint32_t add_material(Material material) { return recorder_.add_material(std::move(material)); }

  // Stores a mesh that has normals and uvs, interleaved: position float32x3, normal snorm16x4, uv float32x2 and, where
  // there are any, tangents snorm16x4, second uvs float32x2, colours unorm16x4 (float32x4 when one is outside 0 to 1);
  // indices of 16 bits when they suffice. Returns a draw of it that only lacks
  // material, name and placement.
  Draw add_mesh(const std::string& name, const Mesh& mesh);

  // Adds a draw to every frame, placed once, or at each of the placements (none: no draw).
  void draw(Draw mesh, const std::string& name, std::uint32_t material, const glm::dmat4& placement = glm::dmat4(1));
  void draw_instances(Draw mesh, const std::string& name, std::uint32_t material,
                      std::span<const glm::dmat4> placements);

  // Records one frame of what was drawn since the last clear_draws(). `name`, matrices, size and time are the caller's.
  void record_frame(Frame frame);
  void clear_draws() { draws_.clear(); }
  Capture take() { return recorder_.take(); }

  // Ends the building; frame i is seen at i / frames_per_second along the path.
  Capture finish(const CameraPath& path, std::uint32_t frames, std::uint32_t width, std::uint32_t height,
                 double frames_per_second = 30);

 private:
  Recorder recorder_;
  std::vector<Draw> draws_;
};

}  // namespace subpixel::capture
