#include "bench/report/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace subpixel::report {

std::vector<Claim> all_claims() {
  std::vector<Claim> claims;
  for (const auto& some : {streaming_claims(), sbaa_claims(), agaa_claims(), dcaa_claims(), linked_list_claims()})
    claims.insert(claims.end(), some.begin(), some.end());
  return claims;
}

std::string range_text(const std::vector<const Run*>& runs, const std::function<double(const Run&)>& number,
                       const char* format) {
  std::vector<double> values;
  for (const Run* run : runs)
    if (const double value = number(*run); std::isfinite(value)) values.push_back(value);
  if (values.empty()) return "none";
  const auto [least, most] = std::ranges::minmax(values);
  const std::string low = fmt::format(fmt::runtime(format), least), high = fmt::format(fmt::runtime(format), most);
  return low == high ? low : low + " to " + high;
}

}  // namespace subpixel::report
