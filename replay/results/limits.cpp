#include "replay/results/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.hpp"
#include "base/json_fields.hpp"
#include "base/numbers.hpp"
#include "base/printable.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {
namespace {

constexpr std::array kLimits{kSamplesLimit,          kWidthLimit,       kHeightLimit, kRepeatLimit,
                             kReferenceSamplesLimit, kPointLightsLimit, kMemoryLimit, kTechniquesLimit,
                             kPriorityLimit,         kRetriesLimit,     kResultsLimit};
constexpr std::size_t kMaxQuotedBytes = 40;
static_assert(kPointLightsLimit.high == SUBPIXEL_MAX_POINT_LIGHTS);

std::vector<std::uint64_t> powers_of_two(const Limit& limit) {
  std::vector<std::uint64_t> values;
  for (std::uint64_t value = std::bit_ceil(limit.low); value <= limit.high; value *= 2) values.push_back(value);
  return values;
}

}  // namespace

bool Limit::holds(std::uint64_t value) const {
  return value >= low && value <= high && value % multiple_of == 0 && (!power_of_two || std::has_single_bit(value));
}

std::string Limit::expected() const {
  if (power_of_two) return fmt::format("one of {}", fmt::join(powers_of_two(*this), ", "));
  if (multiple_of == 1) return fmt::format("a whole number from {} to {}", low, high);
  const std::string multiple =
      fmt::format("a multiple of {} from {} to {}", multiple_of, low == 0 ? multiple_of : low, high);
  return low == 0 ? "0 or " + multiple : multiple;
}

std::string Limit::refusal(std::string_view given) const {
  const bool cut = given.size() > kMaxQuotedBytes;
  return fmt::format("{}{} is not {}", given.substr(0, kMaxQuotedBytes), cut ? "..." : "", expected());
}

std::uint32_t Limit::parse(std::string_view text, std::string_view where) const {
  const auto value = parse_number<std::uint64_t>(text);
  if (!value || !holds(*value)) {
    throw UsageError(std::string(name), refusal(text.empty() ? "nothing" : text), std::string(where));
  }
  return static_cast<std::uint32_t>(*value);
}

void Limit::require(std::uint64_t value) const {
  if (!holds(value)) throw UsageError(std::string(name), refusal(std::to_string(value)), std::string(name));
}

std::span<const Limit> limits() {
  return kLimits;
}

std::pair<std::uint32_t, std::uint32_t> parse_size(std::string_view text, std::string_view where) {
  const std::size_t x = text.find('x');
  if (x == std::string_view::npos) {
    throw UsageError("size", fmt::format("'{}' is not WIDTHxHEIGHT", text), std::string(where));
  }
  const std::string both = fmt::format("{} {}", where, text);
  return {kWidthLimit.parse(text.substr(0, x), both), kHeightLimit.parse(text.substr(x + 1), both)};
}

std::uint32_t parse_memory(std::string_view text, std::string_view where) {
  constexpr std::uint64_t kMibOfGib = 1024;
  const char unit = text.empty() ? '\0' : text.back();
  const auto value = parse_number<std::uint64_t>(text.substr(0, text.empty() ? 0 : text.size() - 1));
  if ((unit != 'M' && unit != 'G') || !value)
    throw UsageError("memory",
                     fmt::format("'{}' is not a whole number with M or G behind it, as in 512M", printable(text, 40)),
                     std::string(where));
  const std::uint64_t most = kMemoryLimit.high + 1;
  const std::uint64_t mib = unit == 'M' ? *value : std::min(*value, most) * kMibOfGib;
  if (!kMemoryLimit.holds(mib))
    throw UsageError("memory", kMemoryLimit.refusal(std::to_string(mib)) + " of MiB", std::string(where));
  return static_cast<std::uint32_t>(mib);
}

nlohmann::json limits_json() {
  nlohmann::json list = nlohmann::json::array();
  for (const Limit& limit : limits()) {
    list.push_back({{"name", limit.name},
                    {"low", limit.low},
                    {"high", limit.high},
                    {"multiple_of", limit.multiple_of},
                    {"values", limit.power_of_two ? nlohmann::json(powers_of_two(limit)) : nlohmann::json(nullptr)},
                    {"unit", limit.unit},
                    {"meaning", limit.meaning}});
  }
  return list;
}

std::uint32_t limited(const JsonField& object, const Limit& limit, std::uint32_t absent) {
  if (!object.has(limit.name) || object.member(limit.name).raw().is_null()) return absent;
  const JsonField field = object.member(limit.name);
  const nlohmann::json& value = field.raw();
  // The full 64 bits are compared: a value that wraps into the range is out of it.
  const bool whole = value.is_number_unsigned() || (value.is_number_integer() && value.get<std::int64_t>() >= 0);
  if (!whole || !limit.holds(value.get<std::uint64_t>())) {
    const std::string given = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    field.fail(limit.refusal(printable(given, 60)));
  }
  return value.get<std::uint32_t>();
}

}  // namespace subpixel::replay
