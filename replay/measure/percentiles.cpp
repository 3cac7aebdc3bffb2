#include "replay/measure/percentiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace subpixel::replay {
namespace {

// Bits of floats of 0 or more are ordered as the floats are; the upper 16 make the buckets.
std::size_t bucket_of(float value) {
  return std::bit_cast<std::uint32_t>(value) >> 16;
}

}  // namespace

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle : 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

Percentiles::Percentiles(std::span<const float> values) : values_(values), counts_(1U << 15), sums_(1U << 15) {
  minimum_ = values.front();
  maximum_ = values.front();
  for (const float value : values) {
    const std::size_t bucket = bucket_of(value);
    ++counts_[bucket];
    sums_[bucket] += value;
    minimum_ = std::min(minimum_, static_cast<double>(value));
    maximum_ = std::max(maximum_, static_cast<double>(value));
  }
  for (const double sum : sums_) sum_ += sum;
}

std::vector<float> Percentiles::sorted_bucket(std::size_t bucket) const {
  std::vector<float> members;
  members.reserve(counts_[bucket]);
  for (const float value : values_) {
    if (bucket_of(value) == bucket) members.push_back(value);
  }
  std::ranges::sort(members);
  return members;
}

double Percentiles::at(double share) const {
  const double size = static_cast<double>(values_.size());
  const auto rank = static_cast<std::uint64_t>(std::clamp(std::ceil(share * size), 1.0, size));
  std::uint64_t below = 0;
  std::size_t bucket = 0;
  while (below + counts_[bucket] < rank) below += counts_[bucket++];
  return sorted_bucket(bucket)[rank - below - 1];
}

double Percentiles::weighted_at(double share) const {
  const double target = share * sum_;
  double below = 0;
  std::size_t bucket = 0;
  // The last bucket that holds anything ends the search, whatever rounding does to the sums.
  const std::size_t last = bucket_of(static_cast<float>(maximum_));
  while (bucket < last && below + sums_[bucket] < target) below += sums_[bucket++];
  const std::vector<float> members = sorted_bucket(bucket);
  for (const float value : members) {
    below += value;
    if (below >= target) return value;
  }
  return members.empty() ? 0 : members.back();
}

}  // namespace subpixel::replay
