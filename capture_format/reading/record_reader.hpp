// The records of SPEC.md, read field by field and checked by the rules of checks.hpp. Private to the reader.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/reading/chunk_reader.hpp"

namespace subpixel::capture {

// Reads the records of a file of one version; fields that the version lacks stay as capture.hpp initialises them.
// Every function throws InputError naming the first field that is missing or breaks a rule.
class RecordReader {
 public:
  explicit RecordReader(std::uint32_t version) : version_(version), has_version_2_(version >= 2) {}

  Metadata metadata(FieldReader& in) const;

  // `take_data` reads the data number and returns its bytes, or none. What comes back is for check_buffer() and
  // check_texture().
  using TakeData = std::function<std::vector<std::byte>(FieldReader&)>;
  Buffer buffer(FieldReader& in, const TakeData& take_data) const;
  Texture texture(FieldReader& in, const TakeData& take_data) const;

  std::vector<Material> materials(FieldReader& in, std::size_t texture_count) const;

  // Held to `bounds`; each draw is handed to `check_indices`, whose report names the draw's place.
  Frame frame(FieldReader& in, const DrawBounds& bounds,
              const std::function<void(const Draw&, const Report&)>& check_indices) const;

 private:
  Sampler sampler(FieldReader& in) const;
  UvMapping uv_mapping(FieldReader& in, std::string_view name) const;
  Material material(FieldReader& in) const;
  PointLight point_light(FieldReader& in) const;
  VertexStream stream(FieldReader& in, std::string_view name) const;
  Draw draw(FieldReader& in) const;

  std::uint32_t version_;
  bool has_version_2_;
};

// Says in the notices that chunks of these kinds were skipped; nothing when there are none.
void add_skip_notice(Metadata& metadata, const std::set<std::string>& kinds);

// A report that throws, for checks of what was just read from `in`.
Report fail_in(const FieldReader& in);

}  // namespace subpixel::capture
