#include "replay/measure/image_channels.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <map>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

constexpr std::size_t kMostNamed = 12;  // in a message

// Colours of one layer of one part.
struct Layer {
  std::size_t part = 0;
  std::string part_name, name;
  std::vector<int> channels;  // empty without colours
  bool has_alpha = false;

  std::string full_name() const {
    if (part_name.empty() || name.empty() || part_name == name) return name.empty() ? part_name : name;
    return part_name + "." + name;
  }
};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMostNamed; ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMostNamed) text += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return text;
}

// The layers of a part that have colours, in order of their first channel.
std::vector<Layer> layers_of(const ImagePart& part, std::size_t index) {
  std::vector<std::string> names;
  std::map<std::string, std::map<std::string, int>> channels_of;  // of each layer, by the channel's own name
  for (std::size_t i = 0; i < part.channels.size(); ++i) {
    const std::string& full = part.channels[i];
    const std::size_t dot = full.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : full.substr(0, dot);
    if (!channels_of.contains(layer)) names.push_back(layer);
    channels_of[layer].try_emplace(lower(dot == std::string::npos ? full : full.substr(dot + 1)), static_cast<int>(i));
  }
  std::vector<Layer> layers;
  for (const std::string& name : names) {
    const std::map<std::string, int>& channels = channels_of.at(name);
    Layer layer{index, part.name, name, {}, false};
    const auto take = [&](std::initializer_list<const char*> wanted) {
      if (!layer.channels.empty() || !std::ranges::all_of(wanted, [&](auto w) { return channels.contains(w); })) return;
      for (const char* const w : wanted) layer.channels.push_back(channels.at(w));
    };
    take({"r", "g", "b"});
    take({"red", "green", "blue"});
    if (!channels.contains("ry") && !channels.contains("by")) take({"y"});
    if (layer.channels.empty()) continue;
    for (const char* const alpha : {"a", "alpha"}) {
      if (layer.has_alpha || !channels.contains(alpha)) continue;
      layer.channels.push_back(channels.at(alpha));
      layer.has_alpha = true;
    }
    layers.push_back(std::move(layer));
  }
  return layers;
}

std::vector<std::string> names_of(const std::vector<Layer>& layers) {
  std::vector<std::string> names;
  for (const Layer& layer : layers) names.push_back(layer.full_name().empty() ? "(no name)" : layer.full_name());
  return names;
}

Layer choose(const std::vector<Layer>& layers, std::string_view wanted, const std::string& path) {
  if (!wanted.empty()) {
    for (const Layer& layer : layers)
      if (layer.name == wanted || layer.part_name == wanted || layer.full_name() == wanted) return layer;
    throw InputError(
        "image", "it has no layer " + std::string(wanted) + " with colours, only " + joined(names_of(layers)), path);
  }
  for (const Layer& layer : layers)
    if (layer.name.empty()) return layer;
  if (layers.size() == 1) return layers.front();
  throw InputError("image", "several layers have colours, and --layer names none: " + joined(names_of(layers)), path);
}

}  // namespace

ChosenChannels choose_channels(const std::vector<ImagePart>& parts, std::string_view layer, const std::string& path) {
  std::vector<Layer> layers;
  std::vector<std::string> all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (Layer& found : layers_of(parts[i], i)) layers.push_back(std::move(found));
    all.insert(all.end(), parts[i].channels.begin(), parts[i].channels.end());
  }
  if (layers.empty()) throw InputError("image", "it has no colours (R, G, B or Y), only " + joined(all), path);
  const Layer chosen = choose(layers, layer, path);
  ChosenChannels result{chosen.part, chosen.channels, chosen.has_alpha, {}};
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t c = 0; c < parts[p].channels.size(); ++c) {
      const bool taken =
          p == chosen.part && std::ranges::find(chosen.channels, static_cast<int>(c)) != chosen.channels.end();
      if (taken) continue;
      const std::string part = parts[p].name.empty() ? std::to_string(p) : parts[p].name;
      result.left_out.push_back((parts.size() > 1 ? part + ":" : "") + parts[p].channels[c]);
    }
  }
  return result;
}

}  // namespace subpixel::replay
