#include "base/fuzz/json_mutator.hpp"

#include <array>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

namespace subpixel {
namespace {

using nlohmann::json;

constexpr std::size_t kMostNodes = 4000;

std::vector<json*> nodes_of(json& document) {
  std::vector<json*> nodes;
  const auto collect = [&](auto& self, json& node) -> void {
    nodes.push_back(&node);
    if (nodes.size() < kMostNodes && node.is_structured())
      for (json& child : node) self(self, child);
  };
  collect(collect, document);
  return nodes;
}

// A member goes, comes twice, or becomes a copy of `other`.
void mutate_members(json& node, const json& other, std::minstd_rand& random) {
  auto victim = node.begin();
  std::advance(victim, static_cast<std::ptrdiff_t>(random() % node.size()));
  if (random() % 2 == 0) {
    node.erase(victim);
  } else if (node.is_array()) {
    const json copy = *victim;
    node.push_back(copy);
  } else {
    *victim = other;
  }
}

json changed_value(const json& node, const json& other, std::span<const std::string_view> words,
                   std::minstd_rand& random) {
  constexpr std::array kDoubles{-1.0, 0.0, 1.0, 0.5, 1e39, 255.0, 4294967295.0, 9007199254740992.0};
  constexpr std::array<std::uint64_t, 8> kIntegers{0, 1, 2, 5, 65536, 4294967295, 4294967296, 18446744073709551615u};
  switch (random() % 6) {
    case 0:
      return kDoubles[random() % kDoubles.size()];
    case 1:
      if (!node.is_number_integer()) return node;
      return node.get<std::int64_t>() % (std::int64_t{1} << 40) + static_cast<int>(random() % 5) - 2;
    case 2:
      return kIntegers[random() % kIntegers.size()];
    case 3:
      return words.empty() ? json("") : json(words[random() % words.size()]);
    case 4:
      return other;
    default:
      return nullptr;
  }
}

}  // namespace

std::string mutated_json(std::string_view text, std::span<const std::string_view> words, std::minstd_rand& random) {
  json document = json::parse(text, nullptr, false);
  if (document.is_discarded()) return {};
  for (unsigned long count = 1 + random() % 3; count > 0; --count) {
    const std::vector<json*> nodes = nodes_of(document);
    json& node = *nodes[random() % nodes.size()];
    const json other = *nodes[random() % nodes.size()];
    if (node.is_structured() && !node.empty() && random() % 3 == 0) {
      mutate_members(node, other, random);
    } else {
      node = changed_value(node, other, words, random);
    }
  }
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace subpixel
