#include "cli/option_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "capture_format/error.hpp"

namespace subpixel::cli {
namespace {

std::uint32_t parse_frame(std::string_view digits, const std::string& text) {
  std::uint32_t frame = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), frame);
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    throw UsageError("frames", fmt::format("'{}' is neither FIRST-LAST nor one frame's number", text), "--frames");
  }
  return frame;
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

std::pair<std::uint32_t, std::uint32_t> parse_size(const std::string& text) {
  const std::string_view view = text;
  const std::size_t x = view.find('x');
  if (x == std::string_view::npos) throw UsageError("size", fmt::format("'{}' is not WIDTHxHEIGHT", text), "--size");
  const std::string where = "--size " + text;
  return {replay::kWidthLimit.parse(view.substr(0, x), where), replay::kHeightLimit.parse(view.substr(x + 1), where)};
}

std::pair<std::uint32_t, std::uint32_t> parse_frames(const std::string& text) {
  const std::string_view view = text;
  const std::size_t dash = view.find('-');
  const std::uint32_t first = parse_frame(view.substr(0, dash), text);
  return {first, dash == std::string_view::npos ? first : parse_frame(view.substr(dash + 1), text)};
}

}  // namespace subpixel::cli
