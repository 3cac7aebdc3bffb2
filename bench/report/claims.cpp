#include "bench/report/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace subpixel::report {

std::vector<Claim> all_claims() {
  std::vector<Claim> claims;
  for (const auto& some : {streaming_claims(), sbaa_claims(), agaa_claims(), dcaa_claims(), linked_list_claims()})
    claims.insert(claims.end(), some.begin(), some.end());
  return claims;
}

std::string range_text(const std::vector<double>& values, const char* format) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double value) { return std::isfinite(value); });
  if (finite.empty()) return "none";
  const auto [least, most] = std::ranges::minmax(finite);
  const std::string low = fmt::format(fmt::runtime(format), least), high = fmt::format(fmt::runtime(format), most);
  return low == high ? low : low + " to " + high;
}

std::string range_text(const std::vector<const Run*>& runs, const std::function<double(const Run&)>& number,
                       const char* format) {
  std::vector<double> values;
  for (const Run* run : runs) values.push_back(number(*run));
  return range_text(values, format);
}

}  // namespace subpixel::report
