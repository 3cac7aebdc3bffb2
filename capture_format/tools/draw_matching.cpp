#include "capture_format/tools/draw_matching.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace subpixel::capture {
namespace {

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

// Boxes of one draw by two APIs: transforms that were worked out from what each handed over differ in last bits.
constexpr double kSameOfDiagonal = 1e-3, kSameOfCoordinate = 1e-6;

// Above it draws are not alike: of the sum of the triangles' ratio as a logarithm, half a point for another material,
// and how far the boxes' faces are apart in diagonals.
constexpr double kMostUnlikeness = 1, kOfAnotherMaterial = 0.5;

// Of a group, looked at one by one: two thousand draws with two thousand.
constexpr std::size_t kMostPairs = std::size_t{1} << 22;

double largest_coordinate(const Box& box) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max({most, std::abs(box.low[i]), std::abs(box.high[i])});
  return most;
}

// Boxes that are not empty count as the same at 1 and below.
double distance_in_tolerances(const Box& a, const Box& b) {
  if (a.empty() || b.empty()) return kAnyDistance;
  const double tolerance =
      kSameOfDiagonal * std::max(a.diagonal(), b.diagonal()) +
      kSameOfCoordinate * std::max({largest_coordinate(a), largest_coordinate(b), std::numeric_limits<double>::min()});
  return distance(a, b) / tolerance;
}

double unlikeness(const Drawn& a, const Box& box_a, const Drawn& b, const Box& box_b) {
  if (box_a.empty() || box_b.empty()) return kAnyDistance;
  const double ratio = static_cast<double>(a.mesh->triangles) / static_cast<double>(b.mesh->triangles);
  const double size = std::max((box_a.diagonal() + box_b.diagonal()) / 2, std::numeric_limits<double>::min());
  return std::abs(std::log(ratio)) + (a.material == b.material ? 0 : kOfAnotherMaterial) +
         distance(box_a, box_b) / size;
}

}  // namespace

std::vector<Drawn> drawn(DrawContents& contents, const Frame& frame) {
  std::vector<Drawn> all;
  all.reserve(frame.draws.size());
  for (const Draw& draw : frame.draws) {
    all.push_back({&draw, &contents.mesh(draw), contents.material(draw.material), contents.placement(draw)});
  }
  return all;
}

const char* name_of(MatchedBy by) {
  switch (by) {
    case MatchedBy::name:
      return "name";
    case MatchedBy::mesh_and_placement:
      return "mesh and placement";
    case MatchedBy::mesh:
      return "mesh";
    case MatchedBy::positions:
      return "positions";
    case MatchedBy::bounds:
      return "bounds";
    case MatchedBy::likeness:
      return "likeness";
  }
  return "";
}

DrawMatching::DrawMatching(const DrawContents& in_a, const std::vector<Drawn>& a, const DrawContents& in_b,
                           const std::vector<Drawn>& b)
    : a_(a), b_(b), match_(a.size()), taken_(b.size(), false) {
  match_by_name();
  match_by_content(in_a, in_b);
}

void DrawMatching::match_by_name() {
  const auto name = [](const Drawn& d) { return d.draw->name; };
  const MatchedBy by = MatchedBy::name;
  pass(by, [&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.material, d.placement); });
  follow();
  pass(by, [&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.material); });
  pass(by, [&](const Drawn& d) { return std::tuple(name(d), d.mesh->all, d.placement); });
  pass(by, [&](const Drawn& d) { return std::tuple(name(d), d.material, d.placement); });
  pass(by, [&](const Drawn& d) { return std::tuple(name(d), d.mesh->all); });
  pass(by, name);
}

void DrawMatching::match_by_content(const DrawContents& in_a, const DrawContents& in_b) {
  pass(MatchedBy::mesh_and_placement, [](const Drawn& d) { return std::tuple(d.mesh->all, d.placement, d.material); });
  pass(MatchedBy::mesh_and_placement, [](const Drawn& d) { return std::tuple(d.mesh->all, d.placement); });

  // Only of what is left: boxes in world space take all corners of all instances.
  std::vector<Box> boxes_a(a_.size()), boxes_b(b_.size());
  const bool is_any_left = std::find(taken_.begin(), taken_.end(), false) != taken_.end();
  for (std::size_t i = 0; i < a_.size() && is_any_left; ++i) {
    if (!match_[i]) boxes_a[i] = in_a.world_box(*a_[i].draw);
  }
  const bool is_all_matched = std::all_of(match_.begin(), match_.end(), [](const auto& m) { return m.has_value(); });
  for (std::size_t j = 0; j < b_.size() && !is_all_matched; ++j) {
    if (!taken_[j]) boxes_b[j] = in_b.world_box(*b_[j].draw);
  }

  const auto apart = [&](std::size_t i, std::size_t j) { return distance(boxes_a[i], boxes_b[j]); };
  nearest(
      MatchedBy::mesh, kAnyDistance, [](const Drawn& d) { return std::tuple(d.mesh->all, d.material); }, apart);
  nearest(
      MatchedBy::mesh, kAnyDistance, [](const Drawn& d) { return d.mesh->all; }, apart);
  nearest(
      MatchedBy::positions, kAnyDistance, [](const Drawn& d) { return d.mesh->streams[kPositionOfDraw]; }, apart);
  nearest(
      MatchedBy::bounds, 1, [](const Drawn& d) { return d.mesh->triangles; },
      [&](std::size_t i, std::size_t j) { return distance_in_tolerances(boxes_a[i], boxes_b[j]); });
  nearest(
      MatchedBy::likeness, kMostUnlikeness, [](const Drawn&) { return 0; },
      [&](std::size_t i, std::size_t j) { return unlikeness(a_[i], boxes_a[i], b_[j], boxes_b[j]); });
}

std::size_t DrawMatching::reordered() const {
  std::vector<std::size_t> last;  // the smallest that a run of each length can end with
  std::size_t matched = 0;
  for (const std::optional<Match>& match : match_) {
    if (!match) continue;
    ++matched;
    const auto longer = std::lower_bound(last.begin(), last.end(), match->in_b);
    if (longer == last.end()) {
      last.push_back(match->in_b);
    } else {
      *longer = match->in_b;
    }
  }
  return matched - last.size();
}

// Matches draws that stand next to matched ones in both frames and are alike: of many draws of one name and mesh,
// content alone can't tell which of them moved.
void DrawMatching::follow() {
  const auto match_if_alike = [&](std::size_t i, std::size_t j) {
    if (match_[i] || taken_[j] || a_[i].draw->name != b_[j].draw->name) return;
    if (a_[i].mesh->all != b_[j].mesh->all && a_[i].material != b_[j].material && a_[i].placement != b_[j].placement) {
      return;
    }
    match(i, j, MatchedBy::name);
  };
  for (std::size_t i = 0; i < a_.size(); ++i) {
    const std::size_t j = i == 0 ? 0 : match_[i - 1] ? match_[i - 1]->in_b + 1 : b_.size();
    if (j < b_.size()) match_if_alike(i, j);
  }
  for (std::size_t i = a_.size(); i-- > 0;) {
    const std::size_t after = i + 1 == a_.size() ? b_.size() : match_[i + 1] ? match_[i + 1]->in_b : 0;
    if (after > 0) match_if_alike(i, after - 1);
  }
}

// Matches what has the same key, the first with the first.
template <typename KeyOf>
void DrawMatching::pass(MatchedBy by, KeyOf key_of) {
  std::map<decltype(key_of(a_[0])), std::pair<std::vector<std::size_t>, std::size_t>> left;
  for (std::size_t j = 0; j < b_.size(); ++j) {
    if (!taken_[j]) left[key_of(b_[j])].first.push_back(j);
  }
  for (std::size_t i = 0; i < a_.size() && !left.empty(); ++i) {
    if (match_[i]) continue;
    const auto found = left.find(key_of(a_[i]));
    if (found == left.end() || found->second.second == found->second.first.size()) continue;
    match(i, found->second.first[found->second.second++], by);
  }
}

// Matches what has the same key, the pair of the lowest cost first, up to `most`. Groups of more than kMostPairs pairs
// are matched in order where any cost will do, and else left.
template <typename KeyOf, typename CostOf>
void DrawMatching::nearest(MatchedBy by, double most, KeyOf key_of, CostOf cost_of) {
  std::map<decltype(key_of(a_[0])), std::pair<std::vector<std::size_t>, std::vector<std::size_t>>> groups;
  for (std::size_t j = 0; j < b_.size(); ++j) {
    if (!taken_[j]) groups[key_of(b_[j])].second.push_back(j);
  }
  for (std::size_t i = 0; i < a_.size() && !groups.empty(); ++i) {
    if (match_[i]) continue;
    const auto found = groups.find(key_of(a_[i]));
    if (found != groups.end()) found->second.first.push_back(i);
  }
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (const auto& [key, group] : groups) {
    const auto& [of_a, of_b] = group;
    if (of_a.size() * of_b.size() > kMostPairs) continue;
    pairs.clear();
    for (const std::size_t i : of_a) {
      for (const std::size_t j : of_b) {
        const double cost = cost_of(i, j);
        if (cost <= most) pairs.emplace_back(cost, i, j);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [cost, i, j] : pairs) {
      if (!match_[i] && !taken_[j]) match(i, j, by);
    }
  }
  if (most == kAnyDistance) pass(by, key_of);
}

}  // namespace subpixel::capture
