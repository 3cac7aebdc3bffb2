#include "replay/techniques/fxaa_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "replay/frame/pixel_story.hpp"

namespace subpixel::replay {
namespace {

using gpu_types::FxaaPush;
using gpu_types::FxaaStory;
using nlohmann::json;

json contrast_step(const FxaaStory& story, const FxaaPush& push, bool edge) {
  const glm::vec4& c = story.contrast;
  return {{"kind", "contrast"},
          {"highest", c.x},
          {"lowest", c.y},
          {"contrast", c.z},
          {"threshold", c.w},
          {"what", fmt::format("{:.4f} between {:.4f} and {:.4f} of the pixel and its four neighbours {} {:.4f}, the "
                               "larger of {:.4g} and {:.4g} of the brightest: {}",
                               c.z, c.y, c.x, edge ? "reaches" : "stays below", c.w, push.least_contrast,
                               push.relative_threshold, edge ? "an edge" : "no edge, the pixel stays as it is")}};
}

std::string side_of(const glm::vec4& across) {
  if (across.y != 0) return across.y > 0 ? "south" : "north";
  return across.x > 0 ? "east" : "west";
}

json direction_step(const FxaaStory& story) {
  const bool level = story.curvature.z > 0;
  return {{"kind", "direction"},
          {"down", story.curvature.x},
          {"right", story.curvature.y},
          {"level", level},
          {"across", {story.across.x, story.across.y}},
          {"what",
           fmt::format("second differences of {:.4f} down the columns and {:.4f} along the rows: a{} edge; the "
                       "larger step is towards the {}",
                       story.curvature.x, story.curvature.y, level ? " level" : "n upright", side_of(story.across))}};
}

json search_step(const FxaaStory& story, const FxaaPush& push) {
  const bool level = story.curvature.z > 0;
  json step{{"kind", "search"},
            {"edge", story.across.z},
            {"tolerance", story.across.w},
            {"steps", {story.ends.x, story.ends.y}},
            {"back", json::array()},
            {"ahead", json::array()}};
  for (int k = 0; k < static_cast<int>(story.ends.x); ++k) step["back"].push_back(story.back[k]);
  for (int k = 0; k < static_cast<int>(story.ends.y); ++k) step["ahead"].push_back(story.ahead[k]);
  if (push.steps == 0) {
    step["what"] = "the edge is not followed, search_steps is 0";
    return step;
  }
  const auto end = [&](const char* name, float steps, float difference) {
    return std::abs(difference) >= story.across.w
               ? fmt::format("after {:.0f} pixels {}, by {:+.4f}", steps, name, difference)
               : fmt::format("not within {:.0f} pixels {}", steps, name);
  };
  step["what"] = fmt::format("the mean of both sides, {:.4f} here, differs by {:.4f} or more {} and {}", story.across.z,
                             story.across.w, end(level ? "west" : "north", story.ends.x, story.ends.z),
                             end(level ? "east" : "south", story.ends.y, story.ends.w));
  return step;
}

json offset_step(const FxaaStory& story) {
  const float nearer = std::min(story.ends.x, story.ends.y), length = story.ends.x + story.ends.y - 1;
  const bool cuts = story.shares.x > 0;
  return {
      {"kind", "offset"},
      {"of_step", story.shares.x},
      {"of_blur", story.shares.y},
      {"share", story.shares.z},
      {"what",
       fmt::format("{}; the low-pass for dots and thin lines asks for {:.4f}; the larger counts, {:.4f}",
                   cuts ? fmt::format("a straight edge through the middle of the step of {:.0f} pixels, whose end is "
                                      "{:.0f} away, cuts off {:.4f} of the pixel",
                                      length, nearer, story.shares.x)
                        : std::string("the nearer end of the step cuts off nothing of this side"),
                   story.shares.y, story.shares.z)}};
}

}  // namespace

json fxaa_filter(const FxaaStory& story, const FxaaPush& push) {
  const bool edge = story.contrast.z >= story.contrast.w;
  json luma{{"kind", "luma"}, {"neighbourhood", json::array()}};
  for (const float one : story.luma) luma["neighbourhood"].push_back(one);
  luma["what"] = fmt::format("{:.4f} here; {:.4f} north, {:.4f} west, {:.4f} east, {:.4f} south", story.luma[4],
                             story.luma[1], story.luma[3], story.luma[5], story.luma[7]);
  json told = json::array({luma, contrast_step(story, push, edge)});
  if (edge) {
    told.push_back(direction_step(story));
    told.push_back(search_step(story, push));
    told.push_back(offset_step(story));
  }
  told.push_back({{"kind", "blend"},
                  {"share", story.shares.z},
                  {"own", vector_json(story.own)},
                  {"other", vector_json(story.other)},
                  {"mixed", vector_json(story.mixed)},
                  {"what", story.shares.z > 0 ? fmt::format("{:.4f} of the pixel's value and {:.4f} of that {} of it",
                                                            1 - story.shares.z, story.shares.z, side_of(story.across))
                                              : std::string("the pixel's own value")}});
  return told;
}

}  // namespace subpixel::replay
