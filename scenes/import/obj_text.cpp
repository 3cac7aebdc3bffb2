#include "scenes/import/obj_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "base/numbers.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr double kLargest = std::numeric_limits<float>::max();  // captures hold positions as floats
constexpr std::uint32_t kMostElements = 0x7fffffffu;

class ObjParser {
 public:
  ObjParser(std::vector<std::byte> file, const std::string& where) : statements_(std::move(file), where, true) {}

  ObjText parse() {
    while (const std::optional<Statement> statement = statements_.next()) take(*statement);
    check_forward_references();
    finish_colours();
    for (const auto& [keyword, line] : ignored_) {
      text_.notices.push_back(fmt::format("ignored: statement {} of OBJ, first in line {}", in_quotes(keyword), line));
    }
    return std::move(text_);
  }

 private:
  void take(const Statement& statement) {
    const std::string& key = statement.keyword;
    if (key == "v") return take_position(without_comment(statement.rest));
    if (key == "vt") return take_uv(without_comment(statement.rest));
    if (key == "vn") return take_normal(without_comment(statement.rest));
    if (key == "f" || key == "fo") return take_face(without_comment(statement.rest), statement.line);
    if (key == "usemtl") return use_material(std::string(statement.rest), statement.line);
    if (key == "mtllib") return text_.libraries.push_back({std::string(statement.rest), statement.line});
    if (key == "o" || key == "g") return use_object(statement.rest);
    if (key == "s") return use_smoothing(without_comment(statement.rest));
    constexpr std::size_t kMostNotices = 50;
    if (ignored_.size() < kMostNotices) ignored_.try_emplace(key, statement.line);
  }

  // x y z, x y z w, x y z r g b, x y z r g b a.
  void take_position(std::string_view rest) {
    std::array<double, 7> values{};
    std::size_t count = 0;
    for (std::string_view token = take_token(rest); !token.empty() && count < values.size(); token = take_token(rest)) {
      values[count] = statements_.number(token, count < 3 ? "a coordinate of a position" : "a value after a position");
      if (std::abs(values[count]) > kLargest) {
        statements_.fail(fmt::format("{} is larger than a 32-bit float holds", in_quotes(token)));
      }
      ++count;
    }
    if (count < 3) statements_.fail(fmt::format("a position has {} coordinates, not 3", count));
    glm::dvec3 position(values[0], values[1], values[2]);
    if (count == 4 && values[3] != 1) {
      if (values[3] == 0) statements_.fail("the weight of a position is 0");
      position /= values[3];
    }
    require_room(text_.positions.size());
    text_.positions.push_back(position);
    if (count >= 6) {
      text_.colours.resize(text_.positions.size(), glm::vec3(kNoColour));
      text_.colours.back() = {values[3], values[4], values[5]};
    }
  }

  void take_uv(std::string_view rest) {
    glm::dvec2 uv(0);
    uv.x = number_or_nan(take_token(rest), "u of a texture coordinate");
    if (const std::string_view token = take_token(rest); !token.empty()) {
      uv.y = number_or_nan(token, "v of a texture coordinate");
    }
    if (!std::isfinite(uv.x + uv.y) || std::max(std::abs(uv.x), std::abs(uv.y)) > kLargest) {
      uv = {0, 0};
      if (!odd_uv_) text_.notices.push_back("ignored: a texture coordinate that is not finite, " + statements_.place());
      odd_uv_ = true;
    }
    require_room(text_.uvs.size());
    text_.uvs.push_back(uv);
  }

  // One that is no number is as good as none: normals.hpp makes another.
  void take_normal(std::string_view rest) {
    glm::dvec3 normal(0);
    for (int i = 0; i < 3; ++i) normal[i] = number_or_nan(take_token(rest), "a component of a normal");
    require_room(text_.normals.size());
    text_.normals.push_back(normal);
  }

  // NaN as C, Microsoft ("-1.#IND", "-nan(ind)") and others print it; anything else that is no number is an error.
  double number_or_nan(std::string_view token, const char* what) const {
    if (const std::optional<double> value = parse_number(token)) return *value;
    const std::string lower = lower_case(token);
    for (const char* spelling : {"nan", "inf", "1.#"}) {
      if (lower.find(spelling) != std::string::npos) return std::numeric_limits<double>::quiet_NaN();
    }
    return statements_.number(token, what);
  }

  void take_face(std::string_view rest, std::size_t line) {
    ObjFace face;
    face.first_corner = static_cast<std::uint32_t>(text_.corners.size());
    for (std::string_view token = take_token(rest); !token.empty(); token = take_token(rest)) {
      require_room(text_.corners.size());
      text_.corners.push_back(corner_of(token));
    }
    face.corner_count = static_cast<std::uint32_t>(text_.corners.size()) - face.first_corner;
    if (face.corner_count < 3) {
      if (!short_face_) {
        text_.notices.push_back("ignored: a face of fewer than 3 corners, " + statements_.place());
        short_face_ = true;
      }
      text_.corners.resize(face.first_corner);
      return;
    }
    if (text_.objects.empty()) use_object("");
    if (text_.materials.empty()) use_material("", 0);
    face.object = object_;
    face.material = material_;
    face.smoothing = smoothing_;
    face.line = line;
    text_.faces.push_back(face);
  }

  ObjCorner corner_of(std::string_view token) {
    std::array<std::string_view, 3> parts;
    std::string_view left = token;
    std::size_t count = 0;
    for (bool more = true; more; ++count) {
      if (count == parts.size()) statements_.fail("a face's corner is " + in_quotes(token) + ", not v/vt/vn");
      const std::size_t slash = left.find('/');
      parts[count] = left.substr(0, slash);
      more = slash != std::string_view::npos;
      if (more) left.remove_prefix(slash + 1);
    }
    ObjCorner corner;
    corner.position = index_of(parts[0], token, text_.positions.size(), "position");
    if (!parts[1].empty()) corner.uv = index_of(parts[1], token, text_.uvs.size(), "texture coordinate");
    if (!parts[2].empty()) corner.normal = index_of(parts[2], token, text_.normals.size(), "normal");
    return corner;
  }

  // From 1 upwards, or from -1 downwards for those read last. Larger than what was read so far may come yet.
  std::uint32_t index_of(std::string_view digits, std::string_view token, std::size_t count, const char* what) const {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
      statements_.fail(
          fmt::format("a face's corner is {}: {} is no index of a {}", in_quotes(token), in_quotes(digits), what));
    }
    const auto read = static_cast<std::int64_t>(count);
    if (error != std::errc() || index == 0 || index > kMostElements || index < -read) fail_index(digits, count, what);
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : read + index);
  }

  [[noreturn]] void fail_index(std::string_view digits, std::size_t count, const char* what) const {
    statements_.fail(
        fmt::format("index {} of a {} is out of range: the file has {} so far", in_quotes(digits), what, count));
  }

  void check_forward_references() const {
    const auto require = [&](const ObjFace& face, std::uint32_t index, std::size_t count, const char* what) {
      if (index == kNoElement || index < count) return;
      statements_.fail_at(face.line,
                          fmt::format("index \"{}\" of a {} is out of range: the file has {}", index + 1, what, count));
    };
    for (const ObjFace& face : text_.faces) {
      for (std::uint32_t i = 0; i < face.corner_count; ++i) {
        const ObjCorner& corner = text_.corners[face.first_corner + i];
        require(face, corner.position, text_.positions.size(), "position");
        require(face, corner.uv, text_.uvs.size(), "texture coordinate");
        require(face, corner.normal, text_.normals.size(), "normal");
      }
    }
  }

  // Some tools write bytes; positions without a colour among others that have one are white.
  void finish_colours() {
    if (text_.colours.empty()) return;
    text_.colours.resize(text_.positions.size(), glm::vec3(kNoColour));
    float largest = 0;
    for (const glm::vec3& c : text_.colours) largest = std::max({largest, c.r, c.g, c.b});
    const float scale = largest > 1 ? 1.0f / 255 : 1.0f;
    if (largest > 1) text_.notices.push_back("read: colours of positions above 1 as bytes of 0 to 255");
    for (glm::vec3& colour : text_.colours) {
      const bool has_one = colour != glm::vec3(kNoColour);
      for (int i = 0; i < 3; ++i) colour[i] = has_one ? std::clamp(colour[i] * scale, 0.0f, 1.0f) : 1.0f;
    }
  }

  void use_object(std::string_view name) {
    const auto [known, is_new] = object_numbers_.try_emplace(to_utf8(name), text_.objects.size());
    if (is_new) text_.objects.push_back(known->first);
    object_ = static_cast<std::uint32_t>(known->second);
  }

  void use_material(const std::string& name, std::size_t line) {
    const auto [known, is_new] = material_numbers_.try_emplace(name == "(null)" ? "" : name, text_.materials.size());
    if (is_new) text_.materials.push_back({known->first, line});
    material_ = static_cast<std::uint32_t>(known->second);
  }

  void use_smoothing(std::string_view rest) {
    const std::string_view token = take_token(rest);
    if (const auto number = subpixel::parse_number<std::uint32_t>(token)) {
      smoothing_ = std::min(*number, kByCreaseAngle - 1);
    } else {
      smoothing_ = lower_case(token) == "on" ? 1 : lower_case(token) == "off" ? 0 : kByCreaseAngle;
    }
  }

  void require_room(std::size_t count) const {
    if (count >= kMostElements)
      statements_.fail(fmt::format("there are more than {} elements of a kind", kMostElements));
  }

  static constexpr float kNoColour = -1e30f;

  Statements statements_;
  ObjText text_;
  std::map<std::string, std::size_t> object_numbers_, material_numbers_;
  std::map<std::string, std::size_t> ignored_;  // keyword, first line
  std::uint32_t object_ = 0, material_ = 0;
  SmoothingGroup smoothing_ = kByCreaseAngle;
  bool odd_uv_ = false, short_face_ = false;
};

}  // namespace

ObjText parse_obj(std::vector<std::byte> file, const std::string& where) {
  return ObjParser(std::move(file), where).parse();
}

}  // namespace subpixel::capture
