#include "replay/techniques/sbaa_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace subpixel::replay {
namespace {

using gpu_types::SbaaKept;
using gpu_types::SbaaStep;
using nlohmann::json;

// A surface that was found: its samples, the first of them.
struct Found {
  std::uint32_t mask = 0, first = 0;
  const SbaaKept* kept = nullptr;
};

std::vector<Found> found_surfaces(std::span<const SbaaStep> steps, std::span<const SbaaKept> kept) {
  std::vector<Found> found;
  for (const SbaaStep& step : steps) {
    if (step.head.z == found.size()) found.push_back({0, step.head.y});
    found.at(step.head.z).mask |= step.head.x;
  }
  for (Found& one : found)
    for (const SbaaKept& slot : kept)
      if (slot.head.y == one.first) one.kept = &slot;
  return found;
}

// The fragments that show in `samples`, the one of the first sample first.
std::vector<std::uint32_t> fragments_in(const PixelStory& story, std::uint32_t all_samples, std::uint32_t samples) {
  std::vector<PixelStory::Shown> in = story.shown(all_samples);
  std::erase_if(in, [samples](const auto& one) { return (one.samples & samples) == 0; });
  std::ranges::sort(in, {}, [samples](const auto& one) { return std::countr_zero(one.samples & samples); });
  std::vector<std::uint32_t> numbers;
  numbers.reserve(in.size());
  for (const PixelStory::Shown& one : in) numbers.push_back(one.fragment);
  return numbers;
}

// Why the group does not go into a surface that was there.
std::string why_not(const SbaaStep& step, std::uint32_t surface, const SbaaForm& form) {
  const glm::vec4& compared = step.compared[surface];
  const float nearest = step.depth.x + step.face.w, farthest = step.depth.x - step.face.w;
  std::string why;
  if (!(compared.x > form.cosine))
    why = fmt::format("cosine of normals {:.4f}, not above {:.4f}", compared.x, form.cosine);
  if (!(farthest <= compared.z && compared.y <= nearest))
    why += fmt::format("{}depths {:.7g} to {:.7g} apart from its {:.7g} to {:.7g}", why.empty() ? "" : ", ", compared.y,
                       compared.z, farthest, nearest);
  return why;
}

json group_json(const PixelStory& story, const SbaaForm& form, const SbaaStep& step) {
  const auto [samples, first, into, count] = std::tuple(step.head.x, step.head.y, step.head.z, step.head.w);
  const std::vector<std::uint32_t> fragments = fragments_in(story, form.samples, samples);
  json told{{"fragment", fragments.empty() ? 0 : fragments.front()},
            {"samples", mask_text(samples)},
            {"first", first},
            {"surface", into},
            {"normal", vector_json(step.face)},
            {"depth", step.depth.x},
            {"slope", step.face.w}};
  std::string what = fmt::format("samples {} have one hash of primitives, ", mask_text(samples));
  if (fragments.size() > 1) {
    what += "which the fragments";
    for (const std::uint32_t fragment : fragments) what += fmt::format(" {}", fragment);
    what += " share, ";
  }
  std::string others;
  if (form.merges)
    for (std::uint32_t j = 0; j < std::min(count, into); ++j) {
      const glm::vec4& compared = step.compared[j];
      told["compared"].push_back({{"cosine", compared.x}, {"nearest", compared.z}, {"farthest", compared.y}});
      others +=
          fmt::format("{}surface {}: {}", others.empty() ? "; not merged with " : "; ", j, why_not(step, j, form));
    }
  if (into < count) {
    const glm::vec4& compared = step.compared[into];
    told["kind"] = "merged";
    told["compared"].push_back({{"cosine", compared.x}, {"nearest", compared.z}, {"farthest", compared.y}});
    const std::string against = why_not(step, into, form);
    what += fmt::format(
        "merged into surface {}, the earliest that fits: cosine of normals {:.4f}, depths {:.7g} to {:.7g} and its "
        "{:.7g} to {:.7g}{}{}",
        into, compared.x, compared.y, compared.z, step.depth.x - step.face.w, step.depth.x + step.face.w,
        against.empty() ? "" : "; against the parameters: ", against);
  } else {
    told["kind"] = "stored";
    what += fmt::format("a new surface, {}", into);
  }
  told["what"] = what + others;
  return told;
}

}  // namespace

json sbaa_steps(const PixelStory& story, const SbaaForm& form, std::span<const SbaaStep> steps,
                std::span<const SbaaKept> kept) {
  json told = story.unseen_steps(form.samples);
  for (const SbaaStep& step : steps) {
    told.push_back(group_json(story, form, step));
    const std::vector<std::uint32_t> fragments = fragments_in(story, form.samples, step.head.x);
    for (std::size_t i = 1; i < fragments.size(); ++i)
      told.push_back({{"fragment", fragments[i]},
                      {"kind", "same hash"},
                      {"surface", step.head.z},
                      {"what", fmt::format("taken for fragment {}, whose hash of its primitive's number is the same",
                                           fragments.front())}});
  }
  const std::vector<Found> found = found_surfaces(steps, kept);
  for (std::size_t j = 0; j < found.size(); ++j) {
    const std::vector<std::uint32_t> fragments = fragments_in(story, form.samples, found[j].mask);
    const int samples = std::popcount(found[j].mask);
    json choice{{"fragment", fragments.empty() ? 0 : fragments.front()},
                {"kind", found[j].kept != nullptr ? "kept" : "dropped"},
                {"surface", j},
                {"samples", mask_text(found[j].mask)}};
    if (found[j].kept != nullptr) {
      choice["slot"] = found[j].kept->head.x;
      choice["what"] = fmt::format(
          "surface {} has {} of the samples and slot {}: the fragment, which shows in its first, {}, stores its "
          "attributes",
          j, samples, found[j].kept->head.x, found[j].first);
    } else {
      choice["what"] = fmt::format(
          "surface {} is dropped: it has {} of the samples, no more than any of the {} kept, and they are left out of "
          "the mean",
          j, samples, form.surfaces);
    }
    told.push_back(std::move(choice));
  }
  return told;
}

json sbaa_surfaces(const PixelStory& story, const SbaaForm& form, std::span<const SbaaStep> steps,
                   std::span<const SbaaKept> kept) {
  json told = json::array();
  const std::vector<Found> found = found_surfaces(steps, kept);
  for (const SbaaKept& slot : kept)
    for (std::size_t j = 0; j < found.size(); ++j) {
      if (found[j].kept != &slot) continue;
      const auto [nearest, farthest] = story.depths_shown(form.samples, found[j].mask);
      told.push_back({{"slot", slot.head.x},
                      {"found_as", j},
                      {"covers", mask_text(found[j].mask)},
                      {"weight", slot.head.z},
                      {"depth_of", "reversed depth"},
                      {"nearest", nearest},
                      {"farthest", farthest},
                      {"surface", surface_json(slot.surface)}});
    }
  return told;
}

}  // namespace subpixel::replay
