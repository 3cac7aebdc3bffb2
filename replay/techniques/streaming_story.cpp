#include "replay/techniques/streaming_story.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace subpixel::replay {
namespace {

using gpu_types::StreamStep;
using nlohmann::json;

std::uint32_t bits_of(std::uint32_t word, std::uint32_t shift, std::uint32_t bits) {
  return word >> shift & ((1u << bits) - 1);
}
std::uint32_t count_of(std::uint32_t word) {
  return bits_of(word, 0, STREAM_COUNT_BITS);
}
std::uint32_t slot_at(std::uint32_t word, std::uint32_t place) {
  return bits_of(word, STREAM_ORDER_SHIFT + 2 * place, 2);
}

json words_json(const glm::uvec4 (&words)[2]) {
  json list = json::array();
  for (const glm::uvec4& four : words)
    for (int c = 0; c < 4; ++c) list.push_back(four[c]);
  return list;
}

// Of a slot, all but the depth-resolved coverage, which surfaces lose without being touched otherwise.
bool same_surface(const glm::uvec4& a0, const glm::uvec4& a1, const glm::uvec4& b0, const glm::uvec4& b1) {
  return glm::uvec3(a0) == glm::uvec3(b0) && a1 == b1;
}

// Why the fragment may not merge with the surface of a slot; empty where it may.
std::string why_not(const StreamStep& step, std::uint32_t slot, const StreamingParameters& p) {
  const glm::vec4& compared = step.compared[slot];
  std::string why;
  const auto add = [&](const std::string& one) {
    if (!why.empty()) why += ", ";
    why += one;
  };
  if (p.merge_coverage && compared.w > 0) add(fmt::format("{} samples shared", compared.w));
  if (p.merge_normals && !(compared.x > static_cast<float>(std::cos(p.normal_angle))))
    add(fmt::format("cosine of normals {:.4f}, not above {:.4f}", compared.x, std::cos(p.normal_angle)));
  if (p.merge_depth && !(compared.y <= step.interval.y && step.interval.x <= compared.z))
    add(fmt::format("depths {:.6g} to {:.6g} apart from its {:.6g} to {:.6g}", compared.y, compared.z, step.interval.x,
                    step.interval.y));
  return why;
}

std::string reasons(const StreamStep& step, std::uint32_t count, const StreamingParameters& p) {
  std::string text;
  for (std::uint32_t slot = 0; slot < count; ++slot)
    text += fmt::format("{}surface {}: {}", slot == 0 ? "" : "; ", slot, why_not(step, slot, p));
  return text;
}

// What one step did. `before`: the step before, all 0 for the first.
json step_json(const StreamStep& step, const StreamStep& before, const StreamingParameters& p) {
  const std::uint32_t word = step.head.z, word_before = before.head.z;
  const std::uint32_t count = count_of(word_before), matches = step.head.w;
  json told{{"fragment", step.head.x},
            {"passed", mask_text(step.head.y)},
            {"count_word", word},
            {"fragment_words", words_json(step.fragment)}};
  for (std::uint32_t slot = 0; slot < p.surfaces; ++slot)
    told["surface_words"].push_back(words_json({step.surface[2 * slot], step.surface[2 * slot + 1]}));
  if (matches != 0) {
    std::uint32_t place = 0;
    while ((matches >> slot_at(word_before, place) & 1u) == 0) ++place;
    const std::uint32_t slot = slot_at(word_before, place);
    told["kind"] = "merged";
    told["slot"] = slot;
    const glm::vec4& compared = step.compared[slot];
    const std::string against = why_not(step, slot, p);
    told["what"] = fmt::format(
        "merged into surface {}, the nearest that it may merge with: cosine of normals {:.4f}, {} samples shared, "
        "depths {:.6g} to {:.6g} and its {:.6g} to {:.6g}{}{}",
        slot, compared.x, compared.w, compared.y, compared.z, step.interval.x, step.interval.y,
        against.empty() ? "" : "; against the parameters: ", against);
    return told;
  }
  if (count < p.surfaces) {
    told["kind"] = "stored";
    told["slot"] = count;
    told["what"] =
        fmt::format("stored as surface {}{}{}", count, count > 0 ? "; not merged with " : "", reasons(step, count, p));
    return told;
  }
  // The list was full: all are fused from front to back and what shows least goes.
  std::optional<std::uint32_t> taken;
  for (std::uint32_t slot = 0; slot < p.surfaces; ++slot)
    if (!same_surface(step.surface[2 * slot], step.surface[2 * slot + 1], before.surface[2 * slot],
                      before.surface[2 * slot + 1]))
      taken = slot;
  const std::uint32_t left = bits_of(word, STREAM_DROPPED_SHIFT, STREAM_DROPPED_BITS) -
                             bits_of(word_before, STREAM_DROPPED_SHIFT, STREAM_DROPPED_BITS);
  const bool flagged = (word & ~word_before & 1u << STREAM_DISCARD_SHIFT) != 0;
  told["kind"] = taken ? "replaced" : "dropped";
  told["left"] = left;
  told["flagged"] = flagged;
  if (taken) told["slot"] = *taken;
  const std::string gone =
      taken ? fmt::format("surface {}, which shows least, is dropped and the fragment stored in its place", *taken)
            : std::string("of all it shows least and is dropped");
  told["what"] = fmt::format("no room: fused from front to back, {}; {} visible samples lost{}; not merged with {}",
                             gone, left, flagged ? ", pixel flagged" : "", reasons(step, count, p));
  return told;
}

}  // namespace

json streaming_steps(const PixelStory& story, const StreamingParameters& parameters,
                     std::span<const StreamStep> steps) {
  json told = json::array();
  std::size_t next = 0;
  for (std::size_t i = 0; i < story.fragments().size(); ++i) {
    const gpu_types::StoryFragment& found = story.fragments()[i].found;
    if (next < steps.size() && steps[next].head.x == i) {
      told.push_back(step_json(steps[next], next == 0 ? StreamStep{} : steps[next - 1], parameters));
      ++next;
    } else if (found.masks.z != 0) {
      told.push_back(
          {{"fragment", i}, {"kind", "hidden"}, {"what", "dropped: fails the depth test at each of its samples"}});
    } else if (found.masks.x != 0) {
      told.push_back({{"fragment", i}, {"kind", "transparent"}, {"what", "dropped: alpha leaves no sample"}});
    }
  }
  return told;
}

json streaming_surfaces(const StreamingParameters& parameters, std::span<const StreamStep> steps) {
  json kept = json::array();
  if (steps.empty()) return kept;
  const StreamStep& last = steps.back();
  for (std::uint32_t place = 0; place < count_of(last.head.z); ++place) {
    const std::uint32_t slot = slot_at(last.head.z, place);
    const glm::uvec4 &words = last.surface[2 * slot], &more = last.surface[2 * slot + 1];
    const glm::vec2 slope = glm::unpackHalf2x16(words.y);
    const float depth = std::bit_cast<float>(words.x), reach = std::abs(slope.x) + std::abs(slope.y);
    kept.push_back({{"slot", slot},
                    {"covers", mask_text(words.z)},
                    {"depth_resolved", mask_text(words.w)},
                    {"depth_of", parameters.depth_space == StreamingDepth::clip ? "reversed depth, negated,"
                                                                                : "distance along the view"},
                    {"depth", depth},
                    {"slopes", {slope.x, slope.y}},
                    {"nearest", depth - reach},
                    {"farthest", depth + reach},
                    {"surface", surface_json({more.x, more.y, more.z | 255u << 8, more.w})}});
  }
  return kept;
}

}  // namespace subpixel::replay
