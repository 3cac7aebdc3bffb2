// Reads members of a JSON document that someone else wrote: a missing member or a wrong type is an InputError that
// names the member by its path ("results[3].ms.total").
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace subpixel {

class JsonField {
 public:
  // `what` names the document in messages: "results", "worker job".
  JsonField(const nlohmann::json& json, std::string what, std::string path = {})
      : json_(&json), what_(std::move(what)), path_(std::move(path)) {}

  bool has(std::string_view name) const { return json_->is_object() && json_->contains(std::string(name)); }

  JsonField member(std::string_view name) const {
    if (!json_->is_object()) fail("expected an object");
    const auto found = json_->find(std::string(name));
    JsonField field(*json_, what_, path_.empty() ? std::string(name) : path_ + "." + std::string(name));
    if (found == json_->end()) field.fail("missing field");
    field.json_ = &*found;
    return field;
  }

  JsonField element(std::size_t index) const {
    JsonField field(*json_, what_, path_ + "[" + std::to_string(index) + "]");
    if (!json_->is_array() || index >= json_->size()) field.fail("missing element");
    field.json_ = &(*json_)[index];
    return field;
  }

  // Number of elements; the field must be an array.
  std::size_t array_size() const {
    if (!json_->is_array()) fail("expected an array");
    return json_->size();
  }

  const nlohmann::json& object() const {
    if (!json_->is_object()) fail("expected an object");
    return *json_;
  }

  const nlohmann::json& raw() const { return *json_; }

  std::string text() const {
    if (!json_->is_string()) fail("expected a string");
    return json_->get<std::string>();
  }

  double number() const {
    if (!json_->is_number()) fail("expected a number");
    return json_->get<double>();
  }

  bool truth() const {
    if (!json_->is_boolean()) fail("expected true or false");
    return json_->get<bool>();
  }

  // null reads as NaN: JSON has no NaN.
  double number_or_nan() const { return json_->is_null() ? std::numeric_limits<double>::quiet_NaN() : number(); }

  std::uint64_t u64() const {
    if (!json_->is_number_integer() || (!json_->is_number_unsigned() && json_->get<std::int64_t>() < 0)) {
      fail("expected a whole number of 0 or more");
    }
    return json_->get<std::uint64_t>();
  }

  std::uint32_t u32() const {
    const std::uint64_t value = u64();
    if (value > std::numeric_limits<std::uint32_t>::max()) fail("number above 4294967295");
    return static_cast<std::uint32_t>(value);
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(what_, why, path_.empty() ? "top level" : path_);
  }

 private:
  const nlohmann::json* json_;
  std::string what_, path_;
};

}  // namespace subpixel
