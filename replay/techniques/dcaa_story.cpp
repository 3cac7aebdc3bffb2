#include "replay/techniques/dcaa_story.hpp"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace subpixel::replay {
namespace {

using gpu_types::DcaaStep;
using gpu_types::DcaaStorySurface;
using nlohmann::json;

std::uint32_t bits_of(std::uint32_t word, std::uint32_t shift, std::uint32_t bits) {
  return word >> shift & ((1u << bits) - 1);
}
std::uint32_t more_in(const DcaaStep& step, std::uint32_t shift, std::uint32_t bits) {
  return bits_of(step.head.z, shift, bits) - bits_of(step.head.y, shift, bits);
}

bool same(const DcaaStorySurface& a, const DcaaStorySurface& b) {
  return a.words == b.words && a.more == b.more;
}
bool same_plane(const DcaaStorySurface& a, const DcaaStorySurface& b) {
  return a.facet == b.facet;
}

// Means of normals keep their length with DCAA_DISTRIBUTION: 12 bits a component, 8 of the root of what is missing
// to 1.
glm::vec3 shading_normal(std::uint32_t word, const DcaaForm& form) {
  if ((form.options & DCAA_DISTRIBUTION) == 0) return octahedral_normal(word, 16);
  const float root = static_cast<float>(word >> 24) / 255.0f;
  return octahedral_normal(word, 12) * (1 - root * root);
}

json story_json(const DcaaStorySurface& s, const DcaaForm& form) {
  json surface = surface_json({s.more.x, s.more.y, s.more.z | 255u << 8, s.more.w});
  surface["normal"] = vector_json(glm::vec4(shading_normal(s.more.y, form), 0));
  return {{"covers", mask_text(mask_of(s.words.x, s.words.y))},
          {"facet", vector_json(s.facet)},
          {"facet_word", s.words.z},
          {"depth_of", "reversed depth"},
          {"depth", s.facet.w},
          {"nearest", s.interval.y},
          {"farthest", s.interval.x},
          {"surface", surface}};
}

// Why the first attempt did not take each surface.
std::string reasons(const DcaaStep& step, std::uint32_t count, const DcaaForm& form) {
  std::string text;
  for (std::uint32_t slot = 0; slot < count; ++slot) {
    const glm::vec4& compared = step.before[slot].interval;
    std::string why;
    if (!(compared.z > form.normal_cosine))
      why = fmt::format("cosine of facets {:.4f}, not above {:.4f}", compared.z, form.normal_cosine);
    if (compared.w < 0)
      why += fmt::format("{}depths {:.7g} to {:.7g} apart", why.empty() ? "" : ", ", compared.x, compared.y);
    text += fmt::format("{}surface {}: {}", text.empty() ? "; not merged with " : "; ", slot, why);
  }
  return text;
}

// With the list full: what left, and where to.
void tell_room_made(json& told, const DcaaStep& step, const DcaaForm& form) {
  std::vector<std::uint32_t> changed;
  std::uint32_t taken = form.surfaces;  // by the fragment as it came
  for (std::uint32_t slot = 0; slot < form.surfaces; ++slot) {
    if (same(step.before[slot], step.after[slot])) continue;
    changed.push_back(slot);
    if (same(step.after[slot], step.fragment)) taken = slot;
  }
  const bool joined = more_in(step, DCAA_SECOND_SHIFT, DCAA_SECOND_BITS) > 0;
  const bool discarded = more_in(step, DCAA_DISCARD_SHIFT, DCAA_DISCARD_BITS) > 0;
  std::string what;
  if (joined && changed.size() == 2 && taken < form.surfaces) {
    const std::uint32_t partner = changed[0] == taken ? changed[1] : changed[0];
    told["kind"] = "second merge";
    told["slot"] = taken;
    told["into"] = partner;
    what = fmt::format("surface {}, which shows least, merges into surface {}; the fragment takes its place", taken,
                       partner);
  } else if (joined && !changed.empty()) {
    told["kind"] = "second merge";
    told["slot"] = changed[0];
    const bool keeps = same_plane(step.before[changed[0]], step.after[changed[0]]);
    what =
        (form.options & DCAA_NEAREST) == 0 ? fmt::format("the fragment and surface {} become one", changed[0])
        : keeps
            ? fmt::format("of all it shows least: what shows of it joins surface {}, which keeps its plane", changed[0])
            : fmt::format("surface {}, which shows least, joins the fragment, which takes its place", changed[0]);
  } else if (taken < form.surfaces) {
    told["kind"] = discarded ? "replaced" : "hidden surface left";
    told["slot"] = taken;
    what = fmt::format("surface {}, which {}, is dropped and the fragment stored in its place", taken,
                       discarded ? "shows least" : "shows nothing");
  } else {
    told["kind"] = discarded ? "dropped" : "hidden";
    what = fmt::format("dropped: of all it shows {}", discarded ? "least" : "nothing");
  }
  told["what"] = "no room: " + what + reasons(step, form.surfaces, form);
}

json step_json(const DcaaStep& step, const DcaaForm& form) {
  const std::uint32_t count = bits_of(step.head.y, 0, DCAA_COUNT_BITS);
  json told{{"fragment", step.head.x}, {"count_word", step.head.z}, {"brings", story_json(step.fragment, form)}};
  for (std::uint32_t slot = 0; slot < bits_of(step.head.z, 0, DCAA_COUNT_BITS); ++slot)
    told["surfaces"].push_back(story_json(step.after[slot], form));
  if (step.fragment.words.x == 0 && step.fragment.words.y == 0) {
    told["kind"] = "hidden";
    told["what"] = "dropped: surfaces in front over the whole pixel cover each of its samples";
  } else if (more_in(step, DCAA_FIRST_SHIFT, DCAA_FIRST_BITS) > 0) {
    std::uint32_t slot = 0;
    while (slot + 1 < count && same(step.before[slot], step.after[slot])) ++slot;
    const glm::vec4& compared = step.before[slot].interval;
    told["kind"] = "merged";
    told["slot"] = slot;
    told["what"] =
        fmt::format("merged into surface {}: cosine of facets {:.4f}, shares {:.3f} of the shorter depth interval",
                    slot, compared.z, compared.w);
  } else if (count < form.surfaces) {
    told["kind"] = "stored";
    told["slot"] = count;
    told["what"] = fmt::format("stored as surface {}{}", count, reasons(step, count, form));
  } else {
    tell_room_made(told, step, form);
  }
  return told;
}

}  // namespace

json dcaa_steps(const PixelStory& story, const DcaaForm& form, std::span<const DcaaStep> steps,
                std::span<const glm::uvec4> listed) {
  json told = json::array();
  std::size_t next = 0;
  for (std::size_t i = 0; i < story.fragments().size(); ++i) {
    if (next < steps.size() && steps[next].head.x == i) {
      told.push_back(step_json(steps[next++], form));
      continue;
    }
    const gpu_types::StoryFragment& found = story.fragments()[i].found;
    const bool bound = found.masks.z != 0 || found.masks.w != 0 || (listed[i].z | listed[i].w) != 0;
    if (bound)
      told.push_back(
          {{"fragment", i}, {"kind", "hidden"}, {"what", "dropped: behind the plane that the depth prepass left"}});
    else if (found.masks.x != 0 || found.masks.y != 0)
      told.push_back({{"fragment", i}, {"kind", "transparent"}, {"what", "dropped: alpha leaves no sample"}});
  }
  return told;
}

json dcaa_surfaces(const DcaaForm& form, std::span<const DcaaStep> steps) {
  json kept = json::array();
  if (steps.empty()) return kept;
  const DcaaStep& last = steps.back();
  for (std::uint32_t slot = 0; slot < bits_of(last.head.z, 0, DCAA_COUNT_BITS); ++slot) {
    kept.push_back(story_json(last.after[slot], form));
    kept.back()["slot"] = slot;
  }
  return kept;
}

}  // namespace subpixel::replay
