#include "cli/option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/error.hpp"
#include "base/numbers.hpp"

namespace subpixel::cli {
namespace {

// `expected` is said of a `text` whose `digits` are none.
std::uint32_t parse_frame(std::string_view digits, const std::string& text, std::string_view expected,
                          const char* where) {
  const auto frame = parse_number<std::uint32_t>(digits);
  if (!frame) throw UsageError("frames", fmt::format("'{}' is {}", text, expected), where);
  return *frame;
}

}  // namespace

CLI::Validator within(const replay::Limit& limit) {
  const auto check = [&limit](std::string& text) -> std::string {
    try {
      text = std::to_string(limit.parse(text, ""));
    } catch (const UsageError&) {
      return limit.refusal(text.empty() ? "nothing" : text);
    }
    return "";
  };
  return CLI::Validator(check, limit.expected());
}

std::pair<std::uint32_t, std::uint32_t> parse_frames(const std::string& text) {
  constexpr std::string_view kExpected = "neither FIRST-LAST nor one frame's number";
  const std::string_view view = text;
  const std::size_t dash = view.find('-');
  const std::uint32_t first = parse_frame(view.substr(0, dash), text, kExpected, "--frames");
  if (dash == std::string_view::npos) return {first, first};
  return {first, parse_frame(view.substr(dash + 1), text, kExpected, "--frames")};
}

std::pair<std::uint32_t, std::string> parse_frame_of_technique(const std::string& text) {
  const std::string_view view = text;
  const std::size_t colon = std::min(view.find(':'), view.size());
  const std::string_view technique = view.substr(std::min(colon + 1, view.size()));
  return {parse_frame(view.substr(0, technique.empty() ? 0 : colon), text, "not FRAME:TECHNIQUE", "--capture-frame"),
          std::string(technique)};
}

std::pair<std::uint32_t, std::uint32_t> parse_pixel(const std::string& text) {
  const std::string_view view = text;
  const std::size_t comma = std::min(view.find(','), view.size());
  const auto x = parse_number<std::uint32_t>(view.substr(0, comma));
  const auto y = parse_number<std::uint32_t>(view.substr(std::min(comma + 1, view.size())));
  if (!x || !y) throw UsageError("pixel", fmt::format("'{}' is not X,Y, two whole numbers", text), "--at");
  return {*x, *y};
}

}  // namespace subpixel::cli
