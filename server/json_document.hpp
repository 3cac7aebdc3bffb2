// JSON that someone else wrote: parsed with the place of a mistake, and without a way to exhaust the parser.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "replay/measure/json_fields.hpp"

namespace subpixel::server {

// Throws InputError "`what`: `noun` is no valid JSON: line 3, column 7", also for documents nested deeper than 16.
nlohmann::json parse_json_document(std::string_view text, const std::string& what, const std::string& noun);

// Refuses what a name list does not hold, so that a misspelt option is not silently ignored. Throws InputError.
void check_names(const replay::JsonField& object, std::initializer_list<std::string_view> known,
                 const std::string& what, const std::string& where);

struct Range {
  std::uint32_t minimum, maximum;
};

// The member `name` of `object` as a whole number within `range`; `absent` when it is null or not there. Throws
// InputError.
std::uint32_t ranged(const replay::JsonField& object, std::string_view name, Range range, std::uint32_t absent);
// The member "samples": a number of samples per pixel the front-end has a pattern of.
std::uint32_t sample_count(const replay::JsonField& object, std::uint32_t absent);

}  // namespace subpixel::server
