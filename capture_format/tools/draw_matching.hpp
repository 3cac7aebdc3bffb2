// Which draw of one frame is which of another. Private to the tools.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "capture_format/tools/draw_content.hpp"

namespace subpixel::capture {

// A draw as it is matched.
struct Drawn {
  const Draw* draw;
  const MeshContent* mesh;
  Hash material, placement;
};

std::vector<Drawn> drawn(DrawContents& contents, const Frame& frame);

// By what a pair was found, in the order in which it is tried (difference.hpp).
enum class MatchedBy { name, mesh_and_placement, mesh, positions, bounds, likeness };
inline constexpr std::array kWaysToMatch{MatchedBy::name,   MatchedBy::mesh_and_placement,
                                         MatchedBy::mesh,   MatchedBy::positions,
                                         MatchedBy::bounds, MatchedBy::likeness};

const char* name_of(MatchedBy by);

class DrawMatching {
 public:
  struct Match {
    std::size_t in_b;
    MatchedBy by;
  };

  // The draws of a frame of either capture, as drawn() gives them.
  DrawMatching(const DrawContents& in_a, const std::vector<Drawn>& a, const DrawContents& in_b,
               const std::vector<Drawn>& b);

  const std::vector<std::optional<Match>>& of_a() const { return match_; }
  bool is_taken(std::size_t in_b) const { return taken_[in_b]; }

  // Matched draws less those of the longest run that is in the same order in both.
  std::size_t reordered() const;

 private:
  void match_by_name();
  void match_by_content(const DrawContents& in_a, const DrawContents& in_b);
  void follow();

  template <typename KeyOf>
  void pass(MatchedBy by, KeyOf key_of);
  template <typename KeyOf, typename CostOf>
  void nearest(MatchedBy by, double most, KeyOf key_of, CostOf cost_of);

  void match(std::size_t i, std::size_t j, MatchedBy by) {
    match_[i] = Match{j, by};
    taken_[j] = true;
  }

  const std::vector<Drawn>&a_, &b_;
  std::vector<std::optional<Match>> match_;
  std::vector<bool> taken_;
};

}  // namespace subpixel::capture
