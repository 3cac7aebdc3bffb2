#include "replay/frame/frame_scene.hpp"

#include "replay/frontend/visibility.hpp"

namespace subpixel::replay {

FrameScene::FrameScene(gpu::Device& device, capture::Capture made, const SceneOptions& options,
                       const FrameChoice& choice)
    : capture(std::move(made)), scene(device, capture, options), frontend(device, scene) {
  set_frame(choice);
}

void FrameScene::set_frame(const FrameChoice& choice) {
  const capture::Frame& recorded = capture.frames.at(choice.frame);
  frame_ = choice.frame;
  width_ = choice.width == 0 ? recorded.width : choice.width;
  height_ = choice.height == 0 ? recorded.height : choice.height;
  scene.set_frame(frame_, width_, height_);
  band_ = {0, height_, 0, height_};
  chosen_small_.reset();
  jitter_ = {0, 0};
  prepared_samples_ = 0;
  forget_counts();
}

void FrameScene::set_jitter(const glm::dvec2& jitter) {
  if (jitter == jitter_) return;
  jitter_ = jitter;
  scene.set_jitter(jitter);
  prepared_samples_ = 0;
  forget_counts();
}

void FrameScene::set_band(const Band& band) {
  band_ = band;
  scene.set_band(band.first, band.rows);
  prepared_samples_ = 0;
  forget_counts();
}

void FrameScene::prepare(std::uint32_t samples) {
  if (prepared_samples_ == samples) return;
  frontend.prepare(samples);
  small_ = chosen_small_ ? *chosen_small_ : choose_small_triangles({frontend, width_, band_.rows});
  prepared_samples_ = samples;
}

void FrameScene::forget_counts() {
  fragments_.clear();
  visible_fragments_.clear();
}

std::uint64_t FrameScene::count_fragments() {
  const auto [found, is_new] = fragments_.try_emplace(prepared_samples_, 0);
  if (is_new)
    found->second = frontend.count_fragments(width_, band_.rows, band_.kept_first - band_.first, band_.kept_rows);
  return found->second;
}

const FragmentListSizes& FrameScene::visible_fragments(AlphaDecision alpha) {
  const std::pair key(prepared_samples_, alpha);
  const auto found = visible_fragments_.find(key);
  if (found != visible_fragments_.end()) return found->second;
  return visible_fragments_.emplace(key, measure_visible_fragments(frontend_frame(alpha))).first->second;
}

}  // namespace subpixel::replay
