#include "capture_format/tools/draw_selection.hpp"

#include "base/error.hpp"
#include "base/numbers.hpp"

namespace subpixel::capture {

// The last star is what a mismatch goes back to: at most pattern times text steps, whatever the number of stars.
bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0, star = std::string_view::npos, star_text = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      star_text = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p, ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++star_text;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

DrawSelection::DrawSelection(const std::string& list, const std::string& where) : where_(where) {
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    Element element;
    element.text = list.substr(begin, end - begin);
    if (element.text.empty()) throw UsageError("draws", "an element of '" + list + "' is empty", where_);
    const std::size_t dash = element.text.find('-');
    const auto first = parse_number<std::uint32_t>(std::string_view(element.text).substr(0, dash));
    const auto last = dash == std::string::npos
                          ? first
                          : parse_number<std::uint32_t>(std::string_view(element.text).substr(dash + 1));
    if (first && last) {
      if (*last < *first) throw UsageError("draws", "'" + element.text + "' runs backwards", where_);
      element.is_range = true;
      element.first = *first;
      element.last = *last;
    }
    elements_.push_back(std::move(element));
    begin = end + 1;
  }
}

std::vector<bool> DrawSelection::of(const Frame& frame) {
  std::vector<bool> selected(frame.draws.size(), false);
  for (Element& element : elements_) {
    for (std::size_t d = 0; d < frame.draws.size(); ++d) {
      const bool is_meant =
          element.is_range ? d >= element.first && d <= element.last : matches(element.text, frame.draws[d].name);
      if (!is_meant) continue;
      selected[d] = true;
      element.met = true;
    }
  }
  return selected;
}

void DrawSelection::require_all_met() const {
  for (const Element& element : elements_) {
    if (!element.met) throw UsageError("draws", "no draw of the frames is '" + element.text + "'", where_);
  }
}

}  // namespace subpixel::capture
