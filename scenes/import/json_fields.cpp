#include "scenes/import/json_fields.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "scenes/import/asset_source.hpp"

namespace subpixel::capture {
namespace {

constexpr double kLargest = 1e12;  // of a coordinate or radiance: float must hold it and what is computed with it

}  // namespace

nlohmann::json parse_json_file(const std::filesystem::path& path) {
  const auto bytes = open_folder(path.parent_path())->read(path.filename().string());
  if (!bytes) throw InputError("can't read the file", "there is no such file", path.string());
  const auto* text = reinterpret_cast<const char*>(bytes->data());
  try {
    return nlohmann::json::parse(text, text + bytes->size());
  } catch (const nlohmann::json::parse_error& error) {
    // The message reads "[json.exception...] parse error at line 3, column 5: ..."; only what follows the tag helps.
    const std::string message = error.what();
    const auto from = message.find("parse error");
    throw InputError("broken JSON", from == std::string::npos ? message : message.substr(from), path.string());
  }
}

JsonFields::JsonFields(const nlohmann::json& object, std::string file, std::string path)
    : object_(object), file_(std::move(file)), path_(std::move(path)) {
  if (!object_.is_object()) throw InputError("wrong field", "not an object", file_ + ", field " + path_);
}

void JsonFields::fail(const std::string& key, const std::string& why) const {
  throw InputError("wrong field", why, file_ + ", field " + path_of(key));
}

const nlohmann::json& JsonFields::require(const std::string& key) {
  asked_.insert(key);
  const auto found = object_.find(key);
  if (found == object_.end()) fail(key, "missing");
  return *found;
}

const nlohmann::json* JsonFields::value(const std::string& key) {
  asked_.insert(key);
  const auto found = object_.find(key);
  return found == object_.end() ? nullptr : &*found;
}

double JsonFields::number(const std::string& key, std::optional<double> fallback) {
  asked_.insert(key);
  if (fallback && !has(key)) return *fallback;
  const nlohmann::json& value = require(key);
  if (!value.is_number()) fail(key, "not a number");
  const double number = value.get<double>();
  if (!std::isfinite(number)) fail(key, "not finite");
  return number;
}

double JsonFields::number_between(const std::string& key, double low, double high, std::optional<double> fallback) {
  const double value = number(key, fallback);
  if (!(value >= low && value <= high)) fail(key, fmt::format("{} is outside {} to {}", value, low, high));
  return value;
}

std::uint32_t JsonFields::whole(const std::string& key, std::uint32_t low, std::uint32_t high,
                                std::optional<std::uint32_t> fallback) {
  const double value = number_between(key, low, high, fallback ? std::optional<double>(*fallback) : std::nullopt);
  if (value != std::floor(value)) fail(key, fmt::format("{} is not a whole number", value));
  return static_cast<std::uint32_t>(value);
}

bool JsonFields::flag(const std::string& key, bool fallback) {
  const nlohmann::json* found = value(key);
  if (found == nullptr) return fallback;
  if (!found->is_boolean()) fail(key, "neither true nor false");
  return found->get<bool>();
}

std::string JsonFields::text(const std::string& key, std::optional<std::string> fallback) {
  asked_.insert(key);
  if (fallback && !has(key)) return *fallback;
  const nlohmann::json& value = require(key);
  if (!value.is_string()) fail(key, "not a text");
  return value.get<std::string>();
}

std::vector<double> JsonFields::numbers(const std::string& key, std::size_t count) {
  const nlohmann::json& value = require(key);
  std::vector<double> list;
  if (value.is_array()) {
    for (const nlohmann::json& item : value) {
      if (item.is_number() && std::isfinite(item.get<double>())) list.push_back(item.get<double>());
    }
  }
  if (!value.is_array() || list.size() != count || value.size() != count) {
    fail(key, fmt::format("not an array of {} numbers", count));
  }
  return list;
}

glm::dvec3 JsonFields::vec3(const std::string& key, std::optional<glm::dvec3> fallback) {
  asked_.insert(key);
  if (fallback && !has(key)) return *fallback;
  const std::vector<double> list = numbers(key, 3);
  for (const double number : list) {
    if (std::abs(number) > kLargest) fail(key, fmt::format("{} is beyond {}", number, kLargest));
  }
  return {list[0], list[1], list[2]};
}

glm::dvec3 JsonFields::light(const std::string& key) {
  const glm::dvec3 value = vec3(key);
  if (value.x < 0 || value.y < 0 || value.z < 0) fail(key, "negative");
  return value;
}

std::vector<glm::dvec2> JsonFields::points2(const std::string& key) {
  const nlohmann::json& value = require(key);
  if (!value.is_array()) fail(key, "not an array of points");
  std::vector<glm::dvec2> points;
  for (const nlohmann::json& item : value) {
    if (!item.is_array() || item.size() != 2 || !item[0].is_number() || !item[1].is_number()) {
      fail(key, "not an array of points of 2 numbers");
    }
    points.emplace_back(item[0].get<double>(), item[1].get<double>());
  }
  return points;
}

std::vector<std::string> JsonFields::texts(const std::string& key) {
  const nlohmann::json& value = require(key);
  std::vector<std::string> list;
  if (!value.is_array()) fail(key, "not an array of texts");
  for (const nlohmann::json& item : value) {
    if (!item.is_string()) fail(key, "not an array of texts");
    list.push_back(item.get<std::string>());
  }
  return list;
}

JsonFields JsonFields::object(const std::string& key) {
  return {require(key), file_, path_of(key)};
}

std::vector<JsonFields> JsonFields::objects(const std::string& key) {
  const nlohmann::json* list = value(key);
  std::vector<JsonFields> fields;
  if (list == nullptr) return fields;
  if (!list->is_array()) fail(key, "not an array");
  for (const nlohmann::json& item : *list) {
    fields.emplace_back(item, file_, fmt::format("{}[{}]", path_of(key), fields.size()));
  }
  return fields;
}

std::vector<std::pair<std::string, JsonFields>> JsonFields::named_objects(const std::string& key) {
  const nlohmann::json* all = value(key);
  std::vector<std::pair<std::string, JsonFields>> fields;
  if (all == nullptr) return fields;
  if (!all->is_object()) fail(key, "not an object");
  for (const auto& [name, item] : all->items()) {
    fields.emplace_back(name, JsonFields(item, file_, path_of(key) + "." + name));
  }
  return fields;
}

void JsonFields::finish() const {
  for (const auto& [key, item] : object_.items()) {
    if (!asked_.contains(key)) fail(key, "unknown field");
  }
}

}  // namespace subpixel::capture
