// JSON that someone else wrote: parsed with the place of a mistake, and without a way to exhaust the parser.
#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/json_fields.hpp"

namespace subpixel {

// Throws InputError "`what`: `noun` is no valid JSON: line 3, column 7", also for documents nested deeper than 16.
nlohmann::json parse_json_document(std::string_view text, const std::string& what, const std::string& noun);

// A line of a process that writes JSON objects between words of its libraries: the object, or nothing for such words
// and for what is nested deeper than 16.
std::optional<nlohmann::json> parse_json_line(std::string_view line);

// A member that is text; empty when it isn't there or something else.
std::string text_or_empty(const nlohmann::json& object, const char* name);

// Refuses what a name list does not hold, so that a misspelt option is not silently ignored. Throws InputError.
void check_names(const JsonField& object, std::initializer_list<std::string_view> known, const std::string& what,
                 const std::string& where);

}  // namespace subpixel
