// Which draws of a frame are meant by numbers, names and patterns.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Whether `pattern`, in which * stands for any characters and ? for one byte, is all of `text`.
bool matches(std::string_view pattern, std::string_view text);

// Draws by number in their frame ("12", "3-7") or else by name, in which * and ? stand for anything.
class DrawSelection {
 public:
  // `list` is separated by commas. Throws UsageError, saying `where`, when an element is empty or a range runs
  // backwards.
  DrawSelection(const std::string& list, const std::string& where);

  // For each draw of the frame whether it is among the selected. Remembers which elements met one.
  std::vector<bool> of(const Frame& frame);

  // Throws UsageError naming the first element that met no draw in all frames that were asked for.
  void require_all_met() const;

 private:
  struct Element {
    std::string text;
    bool is_range = false;
    std::uint32_t first = 0, last = 0;
    bool met = false;
  };
  std::string where_;
  std::vector<Element> elements_;
};

}  // namespace subpixel::capture
