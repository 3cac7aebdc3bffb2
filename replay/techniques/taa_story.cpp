#include "replay/techniques/taa_story.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "replay/frame/pixel_story.hpp"
#include "shaders/frontend/frontend_types.h"

namespace subpixel::replay {
namespace {

using gpu_types::TaaPush;
using gpu_types::TaaStory;
using nlohmann::json;

std::string three(const glm::vec4& v) {
  return fmt::format("{:.4f} {:.4f} {:.4f}", v.x, v.y, v.z);
}

json motion_step(const TaaStory& story, glm::uvec2 pixel) {
  const bool sky = story.front.z == SUBPIXEL_NO_TRIANGLE;
  const glm::vec2 from(story.motion), way = glm::vec2(pixel) + 0.5f - from;
  return {{"kind", "motion"},
          {"front", {story.front.x, story.front.y}},
          {"triangle", sky ? json() : json(story.front.z)},
          {"instance", story.front.w},
          {"depth", story.motion.z},
          {"came_from", {from.x, from.y}},
          {"depth_then", story.motion.w},
          {"inside", story.head.y != 0},
          {"what", fmt::format("{}: the pixel was at {:.3f}, {:.3f}, {:+.3f} {:+.3f} pixels away{}",
                               sky ? std::string("of 3x3 pixels none shows a surface, so it moves as the sky does")
                                   : fmt::format("of 3x3 pixels {}, {} is in front, whose motion is taken",
                                                 story.front.x, story.front.y),
                               from.x, from.y, -way.x, -way.y,
                               story.head.y != 0 ? "" : ", outside of the image: there is no history")}};
}

json bounds_step(const TaaStory& story, const TaaPush& push) {
  json step{{"kind", "bounds"}, {"kept", vector_json(story.kept)}, {"moved", story.head.w != 0}};
  if (push.bounds == TAA_BOUNDS_NONE) {
    step["what"] = "none, the history stays as it is";
    return step;
  }
  step["low"] = vector_json(story.low);
  step["high"] = vector_json(story.high);
  for (const glm::vec4& one : story.neighbourhood) step["colours"].push_back(vector_json(one));
  const std::string of =
      push.bounds == TAA_BOUNDS_VARIANCE
          ? fmt::format("mean and {:.3g} deviations of 3x3 colours", push.deviations)
          : std::string(push.bounds == TAA_BOUNDS_CLIP ? "box of 3x3 colours" : "box of 3x3 colours, each channel");
  step["what"] = fmt::format("{}, YCoCg {} to {}: {}", of, three(story.low), three(story.high),
                             story.head.w != 0 ? "outside, brought to " + three(story.kept) : "within them");
  return step;
}

}  // namespace

json taa_filter(const TaaStory& story, const TaaPush& push, glm::uvec2 pixel) {
  json told = json::array();
  const bool history = story.head.x != 0, open = story.head.z != 0;
  if (history) told.push_back(motion_step(story, pixel));
  if (!history) {
    told.push_back({{"kind", "history"}, {"what", "none: the first frame"}});
  } else if (open) {
    told.push_back({{"kind", "history"},
                    {"value", vector_json(story.before)},
                    {"frames", story.before.w},
                    {"what", fmt::format("{} of {:.0f} frames, read there {}", three(story.before), story.before.w,
                                         push.reading == TAA_CATMULL_ROM ? "by Catmull and Rom's filter"
                                                                         : "between four pixels")}});
    told.push_back(bounds_step(story, push));
  } else if (story.head.y != 0) {
    told.push_back(
        {{"kind", "history"}, {"what", "rejected: in 3x3 pixels there something nearer hid what is in front now"}});
  }
  told.push_back(
      {{"kind", "blend"},
       {"own", vector_json(story.own)},
       {"share", story.own.w},
       {"value", vector_json(story.value)},
       {"frames", story.value.w},
       {"compressed", push.compress != 0},
       {"what", open ? fmt::format("{:.4f} of this frame's {} and {:.4f} of the history: {}, {:.0f} frames",
                                   story.own.w, three(story.own), 1 - story.own.w, three(story.value), story.value.w)
                     : fmt::format("this frame's value, {}", three(story.own))}});
  return told;
}

}  // namespace subpixel::replay
