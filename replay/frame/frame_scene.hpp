// A capture on the device with one frame current, for any number of techniques to be run on.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "capture_format/capture.hpp"
#include "replay/frontend/fragment_lists.hpp"
#include "replay/scene/gpu_scene.hpp"

namespace subpixel::replay {

struct FrameChoice {
  std::uint32_t frame = 0;
  std::uint32_t width = 0, height = 0;  // pixels; 0: as the frame was recorded
};

// Rows of a frame that are drawn at a time, and of those the ones that count: the others are there for what looks at
// neighbours.
struct Band {
  std::uint32_t first = 0, rows = 0;
  std::uint32_t kept_first = 0, kept_rows = 0;
};

class FrameScene {
 public:
  // Throws what GpuScene throws.
  explicit FrameScene(gpu::Device& device, capture::Capture made, const SceneOptions& options = {},
                      const FrameChoice& choice = {});

  // Makes another frame current, or the same at another size.
  void set_frame(const FrameChoice& choice);

  // GpuScene::set_jitter().
  void set_jitter(const glm::dvec2& jitter);

  // Has passes draw these rows of it; of a new frame: all.
  void set_band(const Band& band);
  // How its small triangles are rasterised; nothing, and of a new frame: as prepare() finds it to pay.
  void set_small_triangles(std::optional<SmallTriangles> small) { chosen_small_ = small; }
  const Band& band() const { return band_; }

  // Sizes the front-end for the current frame at `samples` a pixel, by runs on the spot; nothing when it is sized so.
  void prepare(std::uint32_t samples);
  // The current frame as it is prepared.
  FrontendFrame frontend_frame(AlphaDecision alpha) {
    return {frontend, width_, band_.rows, alpha, small_, band_.kept_first - band_.first, band_.kept_rows};
  }
  // Of what is prepared, by a run on the spot the first time: Frontend::count_fragments(), and what
  // measure_visible_fragments() says.
  std::uint64_t count_fragments();
  const FragmentListSizes& visible_fragments(AlphaDecision alpha);

  const capture::Capture capture;  // the scene refers to it
  GpuScene scene;
  Frontend frontend;
  std::uint32_t frame() const { return frame_; }
  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }

 private:
  std::uint32_t frame_ = 0, width_ = 0, height_ = 0;
  Band band_;
  glm::dvec2 jitter_{0};
  std::uint32_t prepared_samples_ = 0;  // 0: the front-end is not prepared for this frame
  SmallTriangles small_ = SmallTriangles::as_hulls;
  std::optional<SmallTriangles> chosen_small_;
  std::map<std::uint32_t, std::uint64_t> fragments_;                                        // by samples
  std::map<std::pair<std::uint32_t, AlphaDecision>, FragmentListSizes> visible_fragments_;  // by samples
  void forget_counts();
};

}  // namespace subpixel::replay
