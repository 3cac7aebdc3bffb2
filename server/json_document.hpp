// JSON that someone else wrote: parsed with the place of a mistake, and without a way to exhaust the parser.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "replay/limits.hpp"
#include "replay/measure/json_fields.hpp"

namespace subpixel::server {

// Throws InputError "`what`: `noun` is no valid JSON: line 3, column 7", also for documents nested deeper than 16.
nlohmann::json parse_json_document(std::string_view text, const std::string& what, const std::string& noun);

// Refuses what a name list does not hold, so that a misspelt option is not silently ignored. Throws InputError.
void check_names(const replay::JsonField& object, std::initializer_list<std::string_view> known,
                 const std::string& what, const std::string& where);

// The member of `object` that the limit is named after; `absent` when it is null or not there. Throws InputError.
std::uint32_t limited(const replay::JsonField& object, const replay::Limit& limit, std::uint32_t absent);

}  // namespace subpixel::server
