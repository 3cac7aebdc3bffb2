// Medians, and exact percentiles of many values without sorting them all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace subpixel::replay {

// The middle one of the values, at least one; of an even number the mean of the middle two.
double median(std::vector<double> values);

// Of finite values of 0 or more, at least one. Keeps a view of them.
class Percentiles {
 public:
  explicit Percentiles(std::span<const float> values);

  double mean() const { return sum_ / static_cast<double>(values_.size()); }
  double minimum() const { return minimum_; }
  double maximum() const { return maximum_; }

  // The smallest value that at least `share` of the values don't exceed (nearest rank).
  double at(double share) const;
  // The smallest value such that the values up to it add up to at least `share` of the sum of all.
  double weighted_at(double share) const;

 private:
  std::vector<float> sorted_bucket(std::size_t bucket) const;

  std::span<const float> values_;
  std::vector<std::uint64_t> counts_;
  std::vector<double> sums_;
  double sum_ = 0, minimum_ = 0, maximum_ = 0;
};

}  // namespace subpixel::replay
