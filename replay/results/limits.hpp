// What a replay can be asked for: one table for the engine, the command line, the HTTP API, a night's configuration and
// the page, so that no door takes what another refuses. What a capture may hold is in capture_format/limits.hpp, what a
// technique's parameters may be in the registry.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "capture_format/limits.hpp"

namespace subpixel {
class JsonField;
}

namespace subpixel::replay {

struct Limit {
  std::string_view name;  // as requests and configurations spell it
  std::uint64_t low, high;
  std::uint32_t multiple_of = 1;
  bool power_of_two = false;
  std::string_view unit, meaning;

  bool holds(std::uint64_t value) const;
  // "a whole number from 1 to 1000"
  std::string expected() const;
  // "0 is not a whole number from 1 to 1000"; `given` is what stands there, number or not.
  std::string refusal(std::string_view given) const;
  // The number that `text` writes in decimal digits. Throws UsageError "`name`: refusal: `where`" for anything else and
  // for what the limit does not hold.
  std::uint32_t parse(std::string_view text, std::string_view where) const;
  // Throws UsageError "`name`: refusal: `name`".
  void require(std::uint64_t value) const;
};

inline constexpr Limit kSamplesLimit{
    .name = "samples",
    .low = 1,
    .high = 64,
    .power_of_two = true,
    .unit = "samples per pixel",
    .meaning = "of techniques that are not given their own",
};
inline constexpr Limit kWidthLimit{
    .name = "width",
    .low = 1,
    .high = capture::kMaxFrameSide,
    .unit = "pixels",
    .meaning = "of the image; together with height",
};
inline constexpr Limit kHeightLimit{
    .name = "height",
    .low = 1,
    .high = capture::kMaxFrameSide,
    .unit = "pixels",
    .meaning = "of the image; together with width",
};
inline constexpr Limit kRepeatLimit{
    .name = "repeat",
    .low = 1,
    .high = 1000,
    .unit = "runs",
    .meaning = "timed runs of each frame; the median counts",
};
// Four visibility samples make one shading sample of the reference.
inline constexpr Limit kReferenceSamplesLimit{
    .name = "reference_samples",
    .low = 0,
    .high = 4096,
    .multiple_of = 4,
    .unit = "samples per pixel",
    .meaning = "of the reference, for the error; 0: none",
};
inline constexpr Limit kPointLightsLimit{
    .name = "point_lights",
    .low = 0,
    .high = 1024,  // SUBPIXEL_MAX_POINT_LIGHTS of the shaders
    .unit = "lights",
    .meaning = "the first of the capture, extra ones are placed in the scene",
};
inline constexpr Limit kMemoryLimit{
    .name = "memory_mib",
    .low = 0,
    .high = 16'777'216,
    .unit = "MiB",
    .meaning = "that a frame's passes may hold; a frame that needs more is drawn in bands of rows; 0: no limit",
};
inline constexpr Limit kTechniquesLimit{
    .name = "techniques",
    .low = 1,
    .high = 256,
    .unit = "techniques",
    .meaning = "of one run, every setting of a sweep counted",
};
inline constexpr Limit kResultsLimit{
    .name = "results",
    .low = 1,
    .high = 100'000,
    .unit = "results",
    .meaning = "of one run: frames times techniques",
};

inline constexpr Limit kPriorityLimit{
    .name = "priority",
    .low = 0,
    .high = 9,
    .unit = "",
    .meaning = "of a run of the service; the highest is next",
};
inline constexpr Limit kRetriesLimit{
    .name = "retries",
    .low = 0,
    .high = 1000,
    .unit = "starts",
    .meaning = "of a run whose worker died, in a row without a new result",
};

// All of the above.
std::span<const Limit> limits();

// [{name, low, high, multiple_of, values, unit, meaning}]; `values` lists what is taken where that is not all multiples
// in the range, else it is null.
nlohmann::json limits_json();

// "1280x720" as width and height, which the limits hold. Throws UsageError that names `where`: "--size".
std::pair<std::uint32_t, std::uint32_t> parse_size(std::string_view text, std::string_view where);

// "512M" or "2G", powers of two, in MiB, which the limit of memory holds. Throws UsageError that names `where`.
std::uint32_t parse_memory(std::string_view text, std::string_view where);

// The member of `object` that the limit is named after; `absent` when it is null or not there. Throws InputError.
std::uint32_t limited(const JsonField& object, const Limit& limit, std::uint32_t absent);

}  // namespace subpixel::replay
