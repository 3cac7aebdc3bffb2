#include "replay/techniques/smaa_story.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "replay/frame/pixel_story.hpp"

namespace subpixel::replay {
namespace {

using gpu_types::SmaaBlendStory;
using gpu_types::SmaaEdgesStory;
using gpu_types::SmaaWeightsStory;
using nlohmann::json;

constexpr std::array<const char*, SMAA_STORY_PIXELS> kPixels{"the pixel", "its eastern neighbour",
                                                             "its southern neighbour"};

json edges_step(const SmaaEdgesStory& story, std::size_t pixel, const gpu_types::SmaaEdgesPush& push) {
  const bool west = (story.head.x & SMAA_EDGE_WEST) != 0, north = (story.head.x & SMAA_EDGE_NORTH) != 0;
  const auto why = [&](bool edge, float step) {
    if (edge) return fmt::format("an edge: a step of {:.4f}", step);
    if (!(step >= push.threshold)) return fmt::format("none: a step of {:.4f}, below {:.4g}", step, push.threshold);
    return fmt::format("none: a step of {:.4f}, and one of {:.4f} beside it, more than {:.4g} times as large", step,
                       story.more.z, push.adaptation);
  };
  return {{"kind", "edges"},
          {"of", kPixels.at(pixel)},
          {"west", west},
          {"north", north},
          {"steps", vector_json(story.steps, 4)},
          {"beyond", vector_json(story.more, 2)},
          {"most", story.more.z},
          {"what", fmt::format("{}: west {}; north {}", kPixels.at(pixel), why(west, story.steps.x),
                               why(north, story.steps.y))}};
}

std::string crossed(std::uint32_t bits, bool level) {
  const std::string before = level ? "above" : "left", after = level ? "below" : "right";
  if (bits == 0) return "not crossed";
  if (bits == SMAA_CROSSED_BEFORE) return "crossed " + before;
  if (bits == SMAA_CROSSED_AFTER) return "crossed " + after;
  return "crossed on both sides";
}

json line_json(const SmaaWeightsStory& story, int which) {
  const glm::uvec4& line = story.line[which];
  const glm::vec4& areas = story.line_areas[which];
  return {{"distances", {line.x, line.y}},
          {"crossed", {line.z, line.w}},
          {"areas", {areas.x, areas.y}},
          {"corners_leave", {areas.z, areas.w}}};
}
std::string line_text(const SmaaWeightsStory& story, int which) {
  const glm::uvec4& line = story.line[which];
  const glm::vec4& areas = story.line_areas[which];
  const bool level = which == 0;
  return fmt::format(
      "{} line goes {} pixels {} and {} {}, its ends {} and {}: areas {:.4f} of this side and {:.4f} of the other{}",
      level ? "level" : "upright", line.x, level ? "west" : "north", line.y, level ? "east" : "south",
      crossed(line.z, level), crossed(line.w, level), areas.x, areas.y,
      areas.z < 1 || areas.w < 1 ? fmt::format(", of which corners leave {:.3g} and {:.3g}", areas.z, areas.w) : "");
}

json diagonal_json(const SmaaWeightsStory& story, int which) {
  const glm::uvec4& line = story.diagonal[which];
  return {{"steps", {line.x, line.y}},
          {"crossed", {line.z, line.w}},
          {"areas", {story.diagonal_areas[which].x, story.diagonal_areas[which].y}}};
}
std::string diagonal_text(const SmaaWeightsStory& story, int which) {
  const glm::uvec4& line = story.diagonal[which];
  return fmt::format("a staircase {} to the right goes {} steps back and {} ahead: areas {:.4f} and {:.4f}",
                     which == 0 ? "rising" : "falling", line.x, line.y, story.diagonal_areas[which].x,
                     story.diagonal_areas[which].y);
}

json weights_step(const SmaaWeightsStory& story, std::size_t pixel) {
  const std::uint32_t told = story.head.x;
  json step{{"kind", "weights"}, {"of", kPixels.at(pixel)}, {"bytes", json::array()}, {"weights", json::array()}};
  for (int k = 0; k < 4; ++k) {
    step["bytes"].push_back(story.head.y >> (8 * k) & 255u);
    step["weights"].push_back(story.weights[k]);
  }
  std::string what;
  const auto add = [&](std::uint32_t bit, const char* name, const json& numbers, const std::string& text) {
    if ((told & bit) == 0) return;
    step[name] = numbers;
    what += (what.empty() ? "" : "; ") + text;
  };
  add(SMAA_TOLD_RISING, "rising", diagonal_json(story, 0), diagonal_text(story, 0));
  add(SMAA_TOLD_FALLING, "falling", diagonal_json(story, 1), diagonal_text(story, 1));
  add(SMAA_TOLD_LEVEL, "level", line_json(story, 0), line_text(story, 0));
  add(SMAA_TOLD_UPRIGHT, "upright", line_json(story, 1), line_text(story, 1));
  if (told == 0) what = "no edge, no weights";
  step["what"] = fmt::format(
      "{}: {}{}", kPixels.at(pixel), what,
      told == 0 ? ""
                : fmt::format("; in bytes {}, {} at the north edge, {}, {} at the west edge", story.head.y & 255u,
                              story.head.y >> 8 & 255u, story.head.y >> 16 & 255u, story.head.y >> 24));
  return step;
}

json blend_step(const SmaaBlendStory& story) {
  const bool sideways = story.head.x != 0, blended = story.head.y != 0;
  const float before = sideways ? story.weights.z : story.weights.x,
              after = sideways ? story.weights.w : story.weights.y;
  std::string what = fmt::format("weights {:.4f} north, {:.4f} south, {:.4f} west, {:.4f} east: ", story.weights.x,
                                 story.weights.y, story.weights.z, story.weights.w);
  what += blended ? fmt::format("the larger are those {}; {:.4f} of the pixel is theirs",
                                sideways ? "west and east" : "north and south", story.mixed.w)
                  : "the pixel's own value";
  return {{"kind", "blend"},
          {"weights", vector_json(story.weights, 4)},
          {"sideways", sideways},
          {"before", {{"weight", before}, {"value", vector_json(story.before)}}},
          {"after", {{"weight", after}, {"value", vector_json(story.after)}}},
          {"own", vector_json(story.own)},
          {"mixed", vector_json(story.mixed)},
          {"share", blended ? story.mixed.w : 0.0f},
          {"what", what}};
}

}  // namespace

json smaa_filter(std::span<const SmaaEdgesStory> edges, std::span<const SmaaWeightsStory> weights,
                 const SmaaBlendStory& blend, const gpu_types::SmaaEdgesPush& push) {
  json told = json::array();
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (edges[i].head.y != 0) told.push_back(edges_step(edges[i], i, push));
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i].head.z != 0) told.push_back(weights_step(weights[i], i));
  told.push_back(blend_step(blend));
  return told;
}

}  // namespace subpixel::replay
