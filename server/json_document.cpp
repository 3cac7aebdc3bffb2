#include "server/json_document.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "capture_format/error.hpp"
#include "capture_format/printable.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

// Deeper than any valid document, far from the parser's stack.
constexpr int kMaxDepth = 16;

}  // namespace

json parse_json_document(std::string_view text, const std::string& what, const std::string& noun) {
  int depth = 0;
  const auto limit_depth = [&](int, json::parse_event_t event, json&) {
    if (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start) {
      if (++depth > kMaxDepth) throw InputError(what, "the JSON is nested too deeply", noun);
    } else if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) {
      --depth;
    }
    return true;
  };
  try {
    return json::parse(text, limit_depth);
  } catch (const json::parse_error& error) {
    const std::size_t offset = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    const std::string_view before = text.substr(0, offset);
    const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    throw InputError(what, noun + " is no valid JSON",
                     fmt::format("line {}, column {}", std::ranges::count(before, '\n') + 1, offset - line_start + 1));
  }
}

void check_names(const replay::JsonField& object, std::initializer_list<std::string_view> known,
                 const std::string& what, const std::string& where) {
  for (const auto& item : object.object().items()) {
    if (std::ranges::find(known, item.key()) == known.end()) {
      throw InputError(
          what, fmt::format("unknown field {} (valid: {})", printable(item.key(), 60), fmt::join(known, ", ")), where);
    }
  }
}

std::uint32_t limited(const replay::JsonField& object, const replay::Limit& limit, std::uint32_t absent) {
  if (!object.has(limit.name) || object.member(limit.name).raw().is_null()) return absent;
  const replay::JsonField field = object.member(limit.name);
  const json& value = field.raw();
  // The full 64 bits are compared: a value that wraps into the range is out of it.
  const bool whole = value.is_number_unsigned() || (value.is_number_integer() && value.get<std::int64_t>() >= 0);
  if (!whole || !limit.holds(value.get<std::uint64_t>())) {
    const std::string given = value.dump(-1, ' ', false, json::error_handler_t::replace);
    field.fail(limit.refusal(printable(given, 60)));
  }
  return value.get<std::uint32_t>();
}

}  // namespace subpixel::server
