// What happens in one pixel of a frame: the fragments that come, what a technique does with each, what it keeps and
// lights, and what the pixel becomes. A technique whose FrameSetup has one adds to it beside the passes it records.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "replay/frame/frame_setup.hpp"
#include "replay/frontend/pixel_fragments.hpp"

namespace subpixel::replay {

class PixelStory {
 public:
  explicit PixelStory(glm::uvec2 pixel) : pixel_(pixel) {}
  PixelStory(const PixelStory&) = delete;
  PixelStory& operator=(const PixelStory&) = delete;

  // By a run on the spot; before passes are recorded.
  void find_fragments(const FrontendFrame& frame) { fragments_ = find_pixel_fragments(frame, pixel_); }

  glm::uvec2 pixel() const { return pixel_; }
  // In submission order.
  const std::vector<PixelFragment>& fragments() const { return fragments_; }
  // Which of them, in their order, show in some sample, and in which: the depth test of each sample, the first of equal
  // depths in front.
  struct Shown {
    std::uint32_t fragment = 0;
    std::uint64_t samples = 0;
  };
  std::vector<Shown> shown(std::uint32_t samples) const;
  // Of those that show in none, and of those alone, why not: "hidden" or "transparent", as steps.
  nlohmann::json unseen_steps(std::uint32_t samples) const;
  // The reversed depths that fragments show in `samples`: the nearest, which is the largest, and the farthest.
  std::pair<float, float> depths_shown(std::uint32_t all_samples, std::uint64_t samples) const;

  // For a technique's record(). `told` makes the story's member `name` once the passes have run.
  void tell(std::string name, std::function<nlohmann::json()> told) {
    told_.emplace_back(std::move(name), std::move(told));
  }
  // For what says more of what others tell: gets the whole story in the end. Samples that the resolve leaves out go
  // into the member "left_out".
  void amend(std::function<void(nlohmann::json&)> more) { amended_.push_back(std::move(more)); }
  // Has `extent` pixels, the story's in their upper left, and no others go through `pass` once more: a full-screen one,
  // whose targets are copied, with the variant `shader` of its fragment shader that tells of them, and `log` bound.
  void record_again(gpu::PassRecorder& recorder, gpu::RasterPass pass, const std::string& shader,
                    const gpu::Binding& log, glm::uvec2 extent = {1, 1});
  // The same of a pass that lights the pixel: `shader` tells each execution (shaders/story/lighting.glsl), for the
  // member "executions".
  void record_lighting(gpu::PassRecorder& recorder, gpu::RasterPass pass, const std::string& shader);
  // A buffer in which a pass logs up to `most` structures: a header of four words, of which it finds the pixel in the
  // first two and counts what it logs in the third, then those.
  template <typename T>
  gpu::Buffer& record_log(gpu::PassRecorder& recorder, std::string name, std::uint64_t most) {
    gpu::Buffer& log = recorder.buffer(std::move(name), sizeof(glm::uvec4) + most * sizeof(T));
    recorder.host([this, &log] {
      std::ranges::fill(log.mapped(), std::byte{0});
      log.as<glm::uvec4>()[0] = {pixel_, 0, 0};
    });
    return log;
  }
  template <typename T>
  static std::span<const T> log_of(const gpu::Buffer& log) {
    return {reinterpret_cast<const T*>(log.mapped().data() + sizeof(glm::uvec4)), log.as<glm::uvec4>()[0].z};
  }
  // Executions of techniques that light visible fragments in lists, whose values are there after the passes.
  void tell_listed_values(const FrameSetup& setup, const FragmentLists& lists);

  // The whole story, once the passes that left `outputs` have run.
  nlohmann::json document(gpu::Device& device, const FrameSetup& setup) const;

 private:
  nlohmann::json fragment_json(const FrameSetup& setup, std::size_t number, std::vector<float>& nearest) const;

  glm::uvec2 pixel_;
  std::vector<PixelFragment> fragments_;
  std::vector<std::pair<std::string, std::function<nlohmann::json()>>> told_;
  std::vector<std::function<void(nlohmann::json&)>> amended_;
  gpu::Buffer* lighting_ = nullptr;
};

// Masks as JSON and tables have them: hexadecimal, sample 0 in the lowest bit, "0x2f".
std::string mask_text(std::uint64_t mask);
std::uint64_t mask_of(std::uint32_t low, std::uint32_t high);
// Two components of `bits` each (Cigolle et al. 2014); unit.
glm::vec3 octahedral_normal(std::uint32_t word, int bits);
// A surface's packed words (shaders/include/packing.glsl): those words, and what they say.
nlohmann::json surface_json(const glm::uvec4& packed);
nlohmann::json vector_json(const glm::vec4& v, int components = 3);
// For amend(): executions of surfaces that are known by one sample get all that they cover.
void light_surfaces(nlohmann::json& story);
// The values of a pixel of an image of floats.
glm::vec4 pixel_of(gpu::Device& device, gpu::Image& image, glm::uvec2 pixel);

}  // namespace subpixel::replay
