// Whether a claim holds, decided by numbers alone.
#pragma once

#include <string>
#include <vector>

namespace subpixel::report {

// A measured value and how far it may be off; equal ends for what is counted and not timed.
struct Interval {
  double low = 0, value = 0, high = 0;
};
inline Interval exactly(double value) {
  return {value, value, value};
}

// undecided: the limit lies within the spread.
enum class Outcome { held, not_held, undecided };

Outcome at_most(const Interval& ours, double limit);
Outcome at_least(const Interval& ours, double limit);
Outcome equal(double ours, double published, double tolerance);

// One comparison of a claim: a scene, a sample count, a format.
struct Comparison {
  std::string where, published, ours;
  Outcome outcome = Outcome::not_held;
  double value = 0;        // what the claim's overview gives the range of
  std::string scene = {};  // whose runs it is about; empty when it is about none in particular
};

// all: every comparison holds. none: not one does. some: as `words` says. unknown: nothing was measured, or nothing
// that decides.
enum class Verdict { all, some, none, unknown };
Verdict verdict(const std::vector<Comparison>& comparisons);

// "held", "not held", "held on 3 of 8", with the undecided ones counted apart.
std::string words(const std::vector<Comparison>& comparisons);
std::string words(Outcome outcome);

}  // namespace subpixel::report
