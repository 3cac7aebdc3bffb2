#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/printable.hpp"
#include "replay/story.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

std::string numbers(const json& list, const char* format = "{:.4f}") {
  std::string text;
  for (const json& value : list) {
    if (!text.empty()) text += ' ';
    text += fmt::format(fmt::runtime(format), value.is_null() ? 0.0 : value.get<double>());
  }
  return text;
}

std::string name_of(const json& text) {
  return printable(text.get<std::string>(), 40);
}

std::string triangle_text(const json& triangle) {
  std::string text =
      fmt::format("draw {} instance {} triangle {}, material {}", triangle["draw"].get<int>(),
                  triangle["instance"].get<int>(), triangle["triangle"].get<int>(), triangle["material"].get<int>());
  if (triangle.contains("material_name") && !triangle["material_name"].get<std::string>().empty())
    text += fmt::format(" ({})", name_of(triangle["material_name"]));
  if (triangle.value("back_face", false)) text += ", back face";
  if (triangle.value("clipped", false)) text += ", clipped";
  return text;
}

// Of a surface, or of an aggregate, whose colours are split.
std::string surface_text(const json& surface) {
  const std::string colours = surface.contains("albedo")
                                  ? fmt::format("albedo {}", numbers(surface["albedo"], "{:.3f}"))
                                  : fmt::format("diffuse {}  reflectance {}", numbers(surface["diffuse"], "{:.3f}"),
                                                numbers(surface["reflectance"], "{:.3f}"));
  std::string text = fmt::format("normal {}  {}  roughness {:.3f}", numbers(surface["normal"], "{:.3f}"), colours,
                                 surface["roughness"].get<double>());
  if (surface.value("metallic", 0.0) > 0) text += fmt::format("  metallic {:.3f}", surface["metallic"].get<double>());
  for (const json& value : surface["emissive"])
    if (value.get<double>() > 0) return text + fmt::format("  emissive {}", numbers(surface["emissive"]));
  return text;
}

std::string samples_text(const json& story) {
  std::string text = "  samples: place from the centre, fragment that shows, reversed depth\n";
  for (std::size_t s = 0; s < story["pattern"].size(); ++s) {
    const json& sample = story["pattern"][s];
    text += fmt::format("    {:2}  {}  ", s, numbers(sample["at"], "{:+.4f}"));
    text += sample["fragment"].is_null()
                ? std::string("sky\n")
                : fmt::format("fragment {}  {:.7g}\n", sample["fragment"].get<int>(), sample["depth"].get<double>());
  }
  return text;
}

std::string fragments_text(const json& story) {
  std::string text = "  fragments in submission order: samples covered, samples nearest so far\n";
  std::size_t without = 0;
  for (const json& fragment : story["fragments"]) {
    if (fragment["covers"] == "0x0") {
      ++without;
      continue;
    }
    text += fmt::format(
        "    {:2}  {}\n        covers {}{}  passes {}  depth {:.7g} {:+.3g} {:+.3g}  lit at {}\n        {}\n",
        fragment["number"].get<int>(), triangle_text(fragment["triangle"]), fragment["covers"].get<std::string>(),
        fragment.contains("alpha_leaves")
            ? fmt::format(", of which alpha leaves {}", fragment["alpha_leaves"].get<std::string>())
            : std::string(),
        fragment["passes"].get<std::string>(), fragment["plane"]["depth"].get<double>(),
        fragment["plane"]["dx"].get<double>(), fragment["plane"]["dy"].get<double>(),
        numbers(fragment["shaded_at"], "{:+.3f}"), surface_text(fragment["surface"]));
  }
  if (without > 0) text += fmt::format("    {} more reach the pixel and cover no sample\n", without);
  return text;
}

std::string technique_text(const json& story) {
  std::string text = story["technique"].get<std::string>();
  for (const auto& [name, value] : story["parameters"].items())
    text += fmt::format(" {}={}", name, value.is_string() ? value.get<std::string>() : value.dump());
  text += '\n';
  text += samples_text(story);
  text += fragments_text(story);
  if (story.contains("steps")) {
    text += "  what was done with each\n";
    for (const json& step : story["steps"])
      text += fmt::format("    {:2}  {}\n", step["fragment"].get<int>(), step["what"].get<std::string>());
  }
  if (story.contains("surfaces")) {
    text += "  kept: slot, samples, depths, attributes\n";
    for (const json& one : story["surfaces"])
      text += fmt::format("    {:2}  covers {}{}  {} {:.7g} to {:.7g}\n        {}\n", one["slot"].get<int>(),
                          one["covers"].get<std::string>(),
                          one.contains("weight") ? fmt::format("  weight {}", one["weight"].get<int>()) : std::string(),
                          one["depth_of"].get<std::string>(), one["nearest"].get<double>(),
                          one["farthest"].get<double>(), surface_text(one["surface"]));
  }
  if (story.contains("executions")) {
    text += "  lighting: what is lit, for which samples, value\n";
    for (const json& one : story["executions"])
      text += fmt::format("    {:2}  {}  weight {}  {}\n", one.value("of", -1), one.value("samples", ""),
                          one["weight"].get<int>(), numbers(one["value"]));
  }
  text += fmt::format("  resolve: {}\n", story["resolve"]["what"].get<std::string>());
  if (story.contains("filter")) {
    text += "  the filter\n";
    for (const json& step : story["filter"])
      text += fmt::format("    {:<10}{}\n", step["kind"].get<std::string>(), step["what"].get<std::string>());
  }
  for (const auto& [name, value] : story["maps"].items()) text += fmt::format("  map {}: {}\n", name, value.get<int>());
  text +=
      fmt::format("  result  radiance {}  display {}  lighting executions {}\n", numbers(story["result"]["radiance"]),
                  numbers(story["result"]["display"]), story["result"]["executions"].get<double>());
  text += '\n';
  return text;
}

// Shadings by triangle: how many samples see it, and its mean radiance over them.
std::string reference_text(const json& reference) {
  struct Part {
    double samples = 0, shadings = 0, sum[3] = {0, 0, 0};
  };
  std::map<std::string, Part> parts;
  double seen = 0;
  for (const json& one : reference["shadings"]) {
    Part& part = parts[triangle_text(one["triangle"])];
    const double samples = one["samples"].get<double>();
    part.samples += samples;
    part.shadings += 1;
    seen += samples;
    for (std::size_t c = 0; c < 3; ++c) part.sum[c] += samples * one["radiance"][c].get<double>();
  }
  const double all = reference["samples"].get<double>();
  std::string text = fmt::format("reference, {} samples, {} of them sky\n", all, all - seen);
  for (const auto& [name, part] : parts)
    text += fmt::format("  {:4} samples, {:4} shadings  {}  mean {:.4f} {:.4f} {:.4f}\n", part.samples, part.shadings,
                        name, part.sum[0] / part.samples, part.sum[1] / part.samples, part.sum[2] / part.samples);
  return text + fmt::format("  result  radiance {}  display {}\n", numbers(reference["result"]["radiance"]),
                            numbers(reference["result"]["display"]));
}

}  // namespace

std::string story_text(const json& story) {
  std::string text = fmt::format("pixel {},{} of frame {}, {}x{}: {}\n\n", story["pixel"][0].get<int>(),
                                 story["pixel"][1].get<int>(), story["frame"].get<int>(), story["size"][0].get<int>(),
                                 story["size"][1].get<int>(), name_of(story["capture"]));
  for (const json& one : story["stories"]) text += technique_text(one);
  if (!story["reference"].is_null()) text += reference_text(story["reference"]);
  return text;
}

}  // namespace subpixel::replay
