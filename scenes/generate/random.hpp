// The generators' source of randomness: SplitMix64 (Steele, Lea, Flood 2014), integer arithmetic only.
// At most one draw from it in an expression, or several inside braces: the order of function arguments and operands is
// the compiler's choice, and the bytes would be, too.
#pragma once

#include <cstdint>

namespace subpixel::capture {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  // Uniform in [0, 1), 53 bits.
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  // Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }

  // Uniform in 0 .. bound - 1; the bias of 2^-64 * bound does not matter here.
  std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>((static_cast<unsigned __int128>(next()) * bound) >> 64);
  }

 private:
  std::uint64_t state_;
};

}  // namespace subpixel::capture
