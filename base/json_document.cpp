#include "base/json_document.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace subpixel {
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
                     "line " + std::to_string(std::ranges::count(before, '\n') + 1) + ", column " +
                         std::to_string(offset - line_start + 1));
  } catch (const json::out_of_range&) {  // 1e999
    throw InputError(what, "a number is larger than any that can be computed with", noun);
  }
}

std::optional<json> parse_json_line(std::string_view line) {
  try {
    json document = parse_json_document(line, "line", "it");
    if (document.is_object()) return document;
  } catch (const InputError&) {  // not said to anyone
  }
  return std::nullopt;
}

std::string text_or_empty(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

void check_names(const JsonField& object, std::initializer_list<std::string_view> known, const std::string& what,
                 const std::string& where) {
  for (const auto& item : object.object().items()) {
    if (std::ranges::find(known, item.key()) != known.end()) continue;
    std::string valid;
    for (const std::string_view name : known) valid.append(valid.empty() ? "" : ", ").append(name);
    throw InputError(what, "unknown field " + printable(item.key(), 60) + " (valid: " + valid + ")", where);
  }
}

}  // namespace subpixel
