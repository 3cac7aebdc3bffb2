#include "replay/techniques/agaa_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace subpixel::replay {
namespace {

using gpu_types::AgaaDefinition;
using gpu_types::AgaaPart;
using nlohmann::json;

std::uint32_t aggregate_of(const AgaaDefinition& definition, std::uint32_t sample) {
  return (definition.head.y >> sample & 1u) | (definition.head.z >> sample & 1u) << 1;
}

// The sample that an aggregate grows around: of equal ones the first was taken.
std::uint32_t seed_sample(const AgaaForm& form, const AgaaDefinition& definition, std::uint32_t aggregate) {
  for (std::uint32_t s = 0; s < form.samples; ++s)
    if ((definition.head.x >> s & 1u) != 0 &&
        glm::vec3(definition.position[s]) == glm::vec3(definition.seed_position[aggregate]) &&
        glm::vec3(definition.normal[s]) == glm::vec3(definition.seed_normal[aggregate]))
      return s;
  return form.samples;
}

// The fragment that shows in a sample.
std::uint32_t fragment_at(const std::vector<PixelStory::Shown>& visible, std::uint32_t sample) {
  const auto at =
      std::ranges::find_if(visible, [sample](const auto& one) { return (one.samples >> sample & 1u) != 0; });
  return at == visible.end() ? 0 : at->fragment;
}

json seed_step(const AgaaForm& form, const AgaaDefinition& definition, std::uint32_t aggregate,
               const std::vector<PixelStory::Shown>& visible) {
  const std::uint32_t sample = seed_sample(form, definition, aggregate);
  const float distance = definition.seed_position[aggregate].w;
  std::string what = fmt::format("aggregate {} grows around its sample {}: ", aggregate, sample);
  if (aggregate == 0)
    what += fmt::format("of all it is farthest from the mean, at a distance of {:.6g}", distance);
  else
    what += fmt::format(
        "of those farther than {:.4g} from each seed before, its distances from them have the largest sum, {:.6g}",
        form.separation, distance);
  const std::uint32_t count = definition.head.w;
  if (aggregate + 1 == count && count < form.aggregates)
    what += fmt::format("; no other: each sample is within {:.4g} of a seed", form.separation);
  return {{"fragment", fragment_at(visible, sample)},
          {"kind", "seed"},
          {"slot", aggregate},
          {"sample", sample},
          {"distance", distance},
          {"what", what}};
}

// Means as shading gets them.
json attributes_json(const AgaaForm& form, const AgaaPart& part) {
  json words = json::array();
  for (std::uint32_t i = 0; i < form.words; ++i) words.push_back(part.words[i]);
  return {{"normal", vector_json(part.normal)},     {"roughness", part.normal.w},
          {"diffuse", vector_json(part.diffuse)},   {"reflectance", vector_json(part.reflectance)},
          {"emissive", vector_json(part.emissive)}, {"words", words}};
}

json part_step(const AgaaForm& form, const AgaaPart& part, std::uint32_t fragment, const AgaaDefinition* definition) {
  const std::uint32_t slot = part.head.x, mask = part.head.y;
  const int samples = std::popcount(mask);
  const auto first = static_cast<std::uint32_t>(std::countr_zero(mask));
  json told{{"fragment", fragment},       {"kind", "added"},   {"slot", slot},
            {"samples", mask_text(mask)}, {"weight", samples}, {"adds", attributes_json(form, part)}};
  std::string what = fmt::format("added to aggregate {} with weight {}/{}", slot, samples, form.samples);
  if (definition == nullptr) {
    what += form.aggregates > 1 ? ": the pixel shows one triangle" : "";
  } else {
    what += fmt::format(", that of its first sample {}, at a distance of {:.6g} from the seed", first,
                        definition->distance[first][static_cast<int>(slot)]);
    told["distance"] = definition->distance[first][static_cast<int>(slot)];
    for (std::uint32_t a = 0; a < definition->head.w; ++a)
      if (a != slot)
        what += fmt::format(", {:.6g} from that of {}", definition->distance[first][static_cast<int>(a)], a);
    std::uint32_t elsewhere = 0;
    for (std::uint32_t s = 0; s < form.samples; ++s)
      if ((mask >> s & 1u) != 0 && aggregate_of(*definition, s) != slot) elsewhere |= 1u << s;
    if (elsewhere != 0) what += fmt::format("; its samples {} lie nearer to another", mask_text(elsewhere));
  }
  told["what"] = what;
  return told;
}

}  // namespace

json agaa_definition(const AgaaForm& form, std::span<const AgaaDefinition> definitions) {
  if (definitions.empty()) return nullptr;
  const AgaaDefinition& definition = definitions.front();
  json told{
      {"covered", mask_text(definition.head.x)},
      {"mean", {{"position", vector_json(definition.mean_position)}, {"normal", vector_json(definition.mean_normal)}}},
      {"seeds", json::array()},
      {"samples", json::array()}};
  for (std::uint32_t a = 0; a < definition.head.w; ++a) told["seeds"].push_back(seed_sample(form, definition, a));
  for (std::uint32_t s = 0; s < form.samples; ++s) {
    json sample{{"position", vector_json(definition.position[s])},
                {"normal", vector_json(definition.normal[s])},
                {"from_mean", definition.position[s].w},
                {"from_seeds", vector_json(definition.distance[s], static_cast<int>(definition.head.w))}};
    sample["aggregate"] = nullptr;
    if ((definition.head.x >> s & 1u) != 0) sample["aggregate"] = aggregate_of(definition, s);
    told["samples"].push_back(std::move(sample));
  }
  return told;
}

json agaa_steps(const PixelStory& story, const AgaaForm& form, std::span<const AgaaDefinition> definitions,
                std::span<const AgaaPart> parts) {
  const AgaaDefinition* const definition = definitions.empty() ? nullptr : &definitions.front();
  const std::vector<PixelStory::Shown> visible = story.shown(form.samples);
  json told = story.unseen_steps(form.samples);
  for (std::uint32_t a = 0; definition != nullptr && a < definition->head.w; ++a)
    told.push_back(seed_step(form, *definition, a, visible));
  for (const PixelStory::Shown& one : visible)
    for (const AgaaPart& part : parts)
      if (part.head.z == 1 && part.head.y == one.samples)
        told.push_back(part_step(form, part, one.fragment, definition));
  return told;
}

json agaa_surfaces(const PixelStory& story, const AgaaForm& form, std::span<const AgaaPart> parts) {
  json told = json::array();
  for (const AgaaPart& part : parts) {
    if (part.head.z == 1) continue;
    const auto [nearest, farthest] = story.depths_shown(form.samples, part.head.y);
    told.push_back({{"slot", part.head.x},
                    {"covers", mask_text(part.head.y)},
                    {"weight", std::popcount(part.head.y)},
                    {"depth_of", "reversed depth"},
                    {"nearest", nearest},
                    {"farthest", farthest},
                    {"surface", attributes_json(form, part)}});
  }
  return told;
}

}  // namespace subpixel::replay
