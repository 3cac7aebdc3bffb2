#include "replay/frame/pixel_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "shaders/frontend/sample_patterns.h"

namespace subpixel::replay {
namespace {

using nlohmann::json;

// Where in the capture a triangle comes from.
json triangle_json(const FrameSetup& setup, const PixelFragment& fragment) {
  const TriangleSource source = triangle_source(setup.scene, fragment.first_index, fragment.instance);
  json triangle{{"draw", source.draw},           {"instance", source.instance},     {"triangle", source.triangle},
                {"material", fragment.material}, {"back_face", fragment.back_face}, {"record", fragment.record}};
  if (fragment.clipped) triangle["clipped"] = true;
  const auto& materials = setup.scene.capture().materials;
  if (fragment.material < materials.size()) triangle["material_name"] = materials[fragment.material].name;
  return triangle;
}

float unorm(std::uint32_t word, int shift) {
  return static_cast<float>(word >> shift & 255u) / 255.0f;
}

json lighting_json(const gpu_types::LightingLog& log) {
  json executions = json::array();
  for (std::uint32_t i = 0; i < log.head.z; ++i) {
    const gpu_types::LightingExecution& one = log.execution[i];
    const std::uint64_t samples = mask_of(one.of.z, one.of.w);
    executions.push_back({{"of", one.of.x},
                          {"samples", mask_text(samples)},
                          {"weight", one.of.y},
                          {"position", vector_json(one.position)},
                          {"value", vector_json(one.value)}});
  }
  return executions;
}

// What the mean over samples is of. `left_out`: samples that it leaves out.
json resolve_json(const json& story, const FrameSetup& setup) {
  const std::uint32_t samples = setup.samples, left_out = story.value("left_out", 0u);
  std::uint32_t lit = 0;
  for (const json& execution : story.value("executions", json::array()))
    lit += execution["weight"].get<std::uint32_t>();
  lit = std::min(lit, samples - std::min(left_out, samples));
  const std::uint32_t sky = samples - left_out - lit;
  std::string what =
      fmt::format("the mean of {} samples: {} of what is lit, {} of the sky", samples - left_out, lit, sky);
  if (left_out > 0) what += fmt::format("; {} are left out", left_out);
  if (setup.common.resolve == Resolve::tone_mapped) what += "; of values after the tone curve";
  return {{"lit", lit}, {"sky", sky}, {"left_out", left_out}, {"what", what}};
}

}  // namespace

glm::vec3 octahedral_normal(std::uint32_t word, int bits) {
  const auto component = [bits](std::uint32_t low) {
    const auto value = static_cast<std::int32_t>(low << (32 - bits)) >> (32 - bits);
    return std::max(static_cast<float>(value) / static_cast<float>((1 << (bits - 1)) - 1), -1.0f);
  };
  glm::vec3 n(component(word), component(word >> bits), 0);
  n.z = 1 - std::abs(n.x) - std::abs(n.y);
  const float fold = std::max(-n.z, 0.0f);
  n.x += n.x >= 0 ? -fold : fold;
  n.y += n.y >= 0 ? -fold : fold;
  return n / std::max(glm::length(n), 1e-10f);
}

std::string mask_text(std::uint64_t mask) {
  return fmt::format("{:#x}", mask);
}

std::uint64_t mask_of(std::uint32_t low, std::uint32_t high) {
  return low | std::uint64_t{high} << 32;
}

json vector_json(const glm::vec4& v, int components) {
  json list = json::array();
  for (int c = 0; c < components; ++c) list.push_back(v[c]);
  return list;
}

json surface_json(const glm::uvec4& packed) {
  json albedo = json::array();
  for (const int shift : {0, 8, 16}) albedo.push_back(unorm(packed.x, shift) * unorm(packed.x, shift));
  const float scale = std::ldexp(1.0f, static_cast<int>(packed.w >> 27) - 24);
  json emissive = json::array();
  for (const int shift : {0, 9, 18}) emissive.push_back(static_cast<float>(packed.w >> shift & 511u) * scale);
  return {{"words", {packed.x, packed.y, packed.z, packed.w}},
          {"albedo", albedo},
          {"metallic", unorm(packed.x, 24)},
          {"normal", vector_json(glm::vec4(octahedral_normal(packed.y, 16), 0))},
          {"roughness", unorm(packed.z, 0)},
          {"emissive", emissive}};
}

void light_surfaces(json& story) {
  for (json& execution : story["executions"])
    for (const json& surface : story["surfaces"])
      if (surface["slot"] == execution["of"]) execution["samples"] = surface["covers"];
}

glm::vec4 pixel_of(gpu::Device& device, gpu::Image& image, glm::uvec2 pixel) {
  const auto bytes = gpu::download(device, image);
  glm::vec4 value;
  std::memcpy(&value, &bytes[(std::size_t{pixel.y} * image.description().width + pixel.x) * sizeof(value)],
              sizeof(value));
  return value;
}

std::vector<PixelStory::Shown> PixelStory::shown(std::uint32_t samples) const {
  std::vector<Shown> shown(fragments_.size());
  for (std::uint32_t s = 0; s < samples; ++s) {
    float nearest = 0;
    std::size_t owner = fragments_.size();
    for (std::size_t i = 0; i < fragments_.size(); ++i) {
      const gpu_types::StoryFragment& found = fragments_[i].found;
      const bool covers = (mask_of(found.masks.z, found.masks.w) >> s & 1u) != 0;
      if (!covers || !(found.depths[s] > nearest)) continue;
      nearest = found.depths[s];
      owner = i;
    }
    if (owner < fragments_.size()) shown[owner].samples |= std::uint64_t{1} << s;
  }
  for (std::size_t i = 0; i < shown.size(); ++i) shown[i].fragment = static_cast<std::uint32_t>(i);
  std::erase_if(shown, [](const Shown& one) { return one.samples == 0; });
  return shown;
}

json PixelStory::unseen_steps(std::uint32_t samples) const {
  json told = json::array();
  const std::vector<Shown> visible = shown(samples);
  for (std::uint32_t i = 0; i < fragments_.size(); ++i) {
    const gpu_types::StoryFragment& found = fragments_[i].found;
    if (mask_of(found.masks.x, found.masks.y) == 0) continue;
    if (std::ranges::find(visible, i, &Shown::fragment) != visible.end()) continue;
    if (mask_of(found.masks.z, found.masks.w) == 0)
      told.push_back({{"fragment", i}, {"kind", "transparent"}, {"what", "dropped: alpha leaves no sample"}});
    else
      told.push_back(
          {{"fragment", i}, {"kind", "hidden"}, {"what", "hidden: another is in front at each of its samples"}});
  }
  return told;
}

std::pair<float, float> PixelStory::depths_shown(std::uint32_t all_samples, std::uint64_t samples) const {
  std::pair<float, float> depths{0.0f, 1e30f};
  for (const Shown& one : shown(all_samples))
    for (std::uint32_t s = 0; s < all_samples; ++s) {
      if ((one.samples & samples & std::uint64_t{1} << s) == 0) continue;
      const float depth = fragments_[one.fragment].found.depths[s];
      depths = {std::max(depths.first, depth), std::min(depths.second, depth)};
    }
  return depths;
}

void PixelStory::record_again(gpu::PassRecorder& recorder, gpu::RasterPass pass, const std::string& shader,
                              const gpu::Binding& log, glm::uvec2 extent) {
  for (gpu::Attachment& target : pass.colours) target = recorder.image(target.image->description());
  pass.name = "story";
  pass.pipeline.fragment = shader;
  pass.pipeline.additive = false;
  pass.pipeline.targets.clear = true;
  pass.clear_colours.assign(pass.colours.size(), {});
  pass.bindings.push_back(log);
  pass.draws = [at = glm::vec2(pixel_), extent = glm::vec2(extent)](gpu::DrawEncoder& encoder) {
    encoder.viewport(at.x, at.y, extent.x, extent.y);
    encoder.draw(3);
  };
  recorder.raster(std::move(pass));
}

void PixelStory::record_lighting(gpu::PassRecorder& recorder, gpu::RasterPass pass, const std::string& shader) {
  if (lighting_ == nullptr) {
    lighting_ = &recorder.buffer("story of lighting", sizeof(gpu_types::LightingLog));
    recorder.host([this] { lighting_->as<gpu_types::LightingLog>()[0].head = {pixel_, 0, 0}; });
    tell("executions", [this] { return lighting_json(lighting_->as<gpu_types::LightingLog>()[0]); });
  }
  record_again(recorder, std::move(pass), shader, gpu::writes(STORY_SLOT_LIGHTING, *lighting_));
}

void PixelStory::tell_listed_values(const FrameSetup& setup, const FragmentLists& lists) {
  tell("executions", [this, lists, width = setup.width, samples = setup.samples] {
    const auto ends = lists.ends->as<std::uint32_t>();
    const std::size_t p = std::size_t{pixel_.y} * width + pixel_.x;
    const std::uint32_t begin = p == 0 ? 0 : ends[p - 1], end = ends[p];
    json executions = json::array();
    const std::vector<Shown> visible = shown(samples);
    for (std::uint32_t i = begin; i < end; ++i) {
      const glm::uvec4 words = lists.fragments->as<glm::uvec4>()[lists.numbers->as<std::uint32_t>()[i]];
      json one{
          {"weight", words.w},
          {"value", {std::bit_cast<float>(words.x), std::bit_cast<float>(words.y), std::bit_cast<float>(words.z)}}};
      // Lists have one fragment of each visible triangle, in submission order.
      if (i - begin < visible.size()) {
        one["of"] = visible[i - begin].fragment;
        one["samples"] = mask_text(visible[i - begin].samples);
      }
      executions.push_back(one);
    }
    return executions;
  });
}

// `nearest`: of each sample, the depth so far.
json PixelStory::fragment_json(const FrameSetup& setup, std::size_t number, std::vector<float>& nearest) const {
  const PixelFragment& fragment = fragments_[number];
  const gpu_types::StoryFragment& found = fragment.found;
  const std::uint64_t geometry = mask_of(found.masks.x, found.masks.y), left = mask_of(found.masks.z, found.masks.w);
  std::uint64_t passed = 0;
  json depths = json::array();
  for (std::uint32_t s = 0; s < setup.samples; ++s) {
    depths.push_back(found.depths[s]);
    if ((left >> s & 1u) == 0 || !(found.depths[s] > nearest[s])) continue;
    passed |= std::uint64_t{1} << s;
    nearest[s] = found.depths[s];
  }
  json told{{"number", number},
            {"triangle", triangle_json(setup, fragment)},
            {"covers", mask_text(geometry)},
            {"passes", mask_text(passed)},
            {"plane",
             {{"depth", found.plane.x},
              {"dx", found.plane.y},
              {"dy", found.plane.z},
              {"smallest", found.plane.w},
              {"largest", found.more.x}}},
            {"depths", depths},
            {"shaded_at", {found.more.y, found.more.z}},
            {"surface", surface_json(found.surface)}};
  if (left != geometry) told["alpha_leaves"] = mask_text(left);
  return told;
}

json PixelStory::document(gpu::Device& device, const FrameSetup& setup) const {
  json story{{"samples", setup.samples}};
  json fragments = json::array();
  std::vector<float> nearest(setup.samples, 0.0f);
  for (std::size_t i = 0; i < fragments_.size(); ++i) fragments.push_back(fragment_json(setup, i, nearest));
  story["fragments"] = std::move(fragments);

  json pattern = json::array();
  for (std::uint32_t s = 0; s < setup.samples; ++s) {
    const auto [x, y] = gpu_types::sample_offset(setup.samples, s);
    pattern.push_back(
        {{"at", {static_cast<float>(x) / SUBPIXEL_SAMPLE_GRID, static_cast<float>(y) / SUBPIXEL_SAMPLE_GRID}},
         {"fragment", nullptr},
         {"depth", nearest[s]}});
  }
  for (const Shown& one : shown(setup.samples))
    for (std::uint32_t s = 0; s < setup.samples; ++s)
      if ((one.samples >> s & 1u) != 0) pattern[s]["fragment"] = one.fragment;
  story["pattern"] = std::move(pattern);

  for (const auto& [name, told] : told_) story[name] = told();

  const glm::vec4 radiance = replay::pixel_of(device, *setup.outputs.radiance, pixel_);
  story["sky"] = vector_json(setup.scene.constants().sky);
  story["result"] = {{"radiance", vector_json(radiance)},
                     {"executions", radiance.w},
                     {"display", vector_json(replay::pixel_of(device, *setup.outputs.display, pixel_))}};
  story["maps"] = json::object();
  for (const auto& [name, map] : setup.outputs.maps) {
    const auto bytes = gpu::download(device, *map);
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes[(std::size_t{pixel_.y} * setup.width + pixel_.x) * sizeof(value)], sizeof(value));
    story["maps"][name] = value;
  }
  for (const auto& more : amended_) more(story);
  story["resolve"] = resolve_json(story, setup);
  story.erase("left_out");
  return story;
}

}  // namespace subpixel::replay
