// The written-down error bounds of the hard cases (tests/hard_cases/bounds.json): for every case the largest MSE of a
// technique that resolves it, and for each technique that does worse a bound of its own with the reason.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace subpixel::replay {

struct ErrorBound {
  double mse = 0;
  std::string why;
};

class ErrorBounds {
 public:
  // Reads the table. Throws nlohmann::json::exception for one that is not there or damaged.
  explicit ErrorBounds(const std::filesystem::path& file) {
    std::ifstream text(file);
    table_ = nlohmann::json::parse(text);
  }

  bool has(std::string_view hard) const { return table_.at("cases").contains(hard); }

  // A technique that the table does not know yet is held to twice the case's largest bound.
  ErrorBound of(std::string_view hard, std::string_view technique) const {
    const auto& row = table_.at("cases").at(std::string(hard));
    const double resolved = row.at("mse").get<double>();
    double largest = resolved;
    for (const auto& [name, exception] : row.at("worse").items()) {
      if (name == technique) return {exception.at("mse").get<double>(), exception.at("why").get<std::string>()};
      largest = std::max(largest, exception.at("mse").get<double>());
    }
    if (!knows(technique)) return {2 * largest, "not in the table yet"};
    return {resolved, row.at("why").get<std::string>()};
  }

  bool knows(std::string_view technique) const {
    const auto& known = table_.at("techniques");
    return std::find(known.begin(), known.end(), technique) != known.end();
  }

 private:
  nlohmann::json table_;
};

}  // namespace subpixel::replay
