// What each publication says in its headline numbers, and whether it comes out here. A claim holds numbers of the
// publication and how to look ours up; the verdict follows from them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/report/measured.hpp"

namespace subpixel::report {

struct Claim {
  std::string technique, publication, where;  // "table 1"
  std::string title;                          // what is claimed, in a few words
  std::string published;                      // its numbers, short
  std::string criterion;                      // how it is judged here, and why that is what was said
  std::string column;                         // what Comparison::where names: "scene"
  const char* number = "{:.2f}";              // how a Comparison::value is written ...
  const char* overview = "{}";                // ... and what is said about their range: "{} times the MSE"
  std::function<std::vector<Comparison>(const Measured&)> compare;
  // Why it does not hold, with measured numbers; asked for only when a comparison fails, of the runs of the scenes that
  // fail.
  std::function<std::string(const Measured& failed)> reason;
  // Pixels across of the publication's images: stills of that width decide, those of 640 stand beside. 0: all runs.
  std::uint32_t width = 0;
  // Stand-ins for the publication's scenes: only they decide, others are told in a line. Empty: all decide.
  std::vector<std::string> scenes = {};
};

// In the order of the page.
std::vector<Claim> all_claims();

std::vector<Claim> streaming_claims();
std::vector<Claim> sbaa_claims();
std::vector<Claim> linked_list_claims();
std::vector<Claim> agaa_claims();
std::vector<Claim> dcaa_claims();
std::vector<Claim> today_claims();

// FLIP or MSE of two images of each still: `test` to `base` is at most `factor` times what the yardstick's pair has.
struct LookAlike {
  replay::TechniqueRequest test, base, yardstick, yardstick_base;
  double factor = 1;
};
std::vector<Comparison> as_alike_as(const Measured& measured, const LookAlike& claim, double PairError::*measure);

// Mean flicker over the frames of each run of several: of `technique` at its defaults no more than that of `other`.
std::vector<Comparison> steadier_than(const Measured& measured, std::string_view technique, std::string_view other,
                                      const replay::ParameterValues& others = {});

// "12 to 34", "12", or "none". Those that are not a number are left out.
std::string range_text(const std::vector<double>& values, const char* format);
// One number of each run.
std::string range_text(const std::vector<const Run*>& runs, const std::function<double(const Run&)>& number,
                       const char* format);

}  // namespace subpixel::report
