// Reads the fields of a JSON object written by hand: every error names file and field, and a field nobody asked for is
// one, so that a typing mistake can't pass for a default.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace subpixel::capture {

// The document in a file. Throws InputError with line and column when it is no JSON, or when it can't be read.
nlohmann::json parse_json_file(const std::filesystem::path& path);

class JsonFields {
 public:
  // `object` must outlive this; `file` and `path` ("placements[3]") are for messages.
  JsonFields(const nlohmann::json& object, std::string file, std::string path);

  bool has(const std::string& key) const { return object_.contains(key); }

  // Required, unless there is a fallback. Throw InputError when missing or of another type; numbers must be finite.
  double number(const std::string& key, std::optional<double> fallback = {});
  double number_between(const std::string& key, double low, double high, std::optional<double> fallback = {});
  std::uint32_t whole(const std::string& key, std::uint32_t low, std::uint32_t high,
                      std::optional<std::uint32_t> fallback = {});
  bool flag(const std::string& key, bool fallback);
  std::string text(const std::string& key, std::optional<std::string> fallback = {});
  glm::dvec3 vec3(const std::string& key, std::optional<glm::dvec3> fallback = {});
  glm::dvec3 light(const std::string& key);  // a vec3 of numbers not below 0
  std::vector<double> numbers(const std::string& key, std::size_t count);
  std::vector<glm::dvec2> points2(const std::string& key);
  std::vector<std::string> texts(const std::string& key);

  // Sub-objects: one, a list of them (empty when the key is missing), or all values of an object with their keys.
  JsonFields object(const std::string& key);
  std::vector<JsonFields> objects(const std::string& key);
  std::vector<std::pair<std::string, JsonFields>> named_objects(const std::string& key);

  // The value itself, for fields of several forms; counts as asked for.
  const nlohmann::json* value(const std::string& key);

  // Throws InputError naming the first field that was never asked for.
  void finish() const;

  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  const nlohmann::json& require(const std::string& key);
  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  const nlohmann::json& object_;
  std::string file_;
  std::string path_;
  std::set<std::string> asked_;
};

}  // namespace subpixel::capture
