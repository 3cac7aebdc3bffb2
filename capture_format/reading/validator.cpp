#include "capture_format/reading/validator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "capture_format/checks.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/texture_reads.hpp"

namespace subpixel::capture {
namespace {

constexpr std::size_t kMaxProblems = 1000;

bool is_finite(const Matrix4& matrix) {
  return std::all_of(matrix.begin(), matrix.end(), [](float v) { return std::isfinite(v); });
}

// The determinant by the first column's cofactors, in doubles, of which the products of two elements are exact.
double determinant(const Matrix4& matrix) {
  const auto at = [&](std::size_t column, std::size_t row) { return double{matrix[4 * column + row]}; };
  // Of the last two columns.
  const auto minor = [&](std::size_t i, std::size_t j) { return at(2, i) * at(3, j) - at(3, i) * at(2, j); };
  // Of the last three.
  const auto cofactor = [&](std::size_t i, std::size_t j, std::size_t k) {
    return at(1, i) * minor(j, k) - at(1, j) * minor(i, k) + at(1, k) * minor(i, j);
  };
  return at(0, 0) * cofactor(1, 2, 3) - at(0, 1) * cofactor(0, 2, 3) + at(0, 2) * cofactor(0, 1, 3) -
         at(0, 3) * cofactor(0, 1, 2);
}

bool is_singular(const Matrix4& matrix) {
  return determinant(matrix) == 0;
}

// Whether the frame shows the world as a mirror does, which makes back faces of front faces. A projection of a view
// that looks down -z, whether perspective or parallel, has a positive determinant where depth goes from 1 to 0 and y is
// up in clip space; depth or y the other way round changes its sign each.
bool is_mirrored(const Frame& frame) {
  const bool is_turned = (determinant(frame.view) < 0) != (determinant(frame.projection) < 0);
  return is_turned == ((frame.clip_depth == ClipDepth::one_to_zero) == frame.clip_y_up);
}

class Validation {
 public:
  explicit Validation(const Capture& capture) : capture_(capture), sizes_(sizes_of(capture.buffers)) {}

  std::vector<Problem> run() {
    check_resources();
    for (std::size_t f = 0; f < capture_.frames.size(); ++f) check_one_frame(f);
    if (capture_.frames.empty()) note("frames", "there is none");
    return std::move(problems_);
  }

 private:
  void add(Problem::Severity severity, const std::string& where, const std::string& why) {
    if (problems_.size() + 1 == kMaxProblems) problems_.push_back({severity, "", "further problems are not listed"});
    if (problems_.size() < kMaxProblems) problems_.push_back({severity, where, why});
  }
  void error(const std::string& where, const std::string& why) { add(Problem::Severity::error, where, why); }
  void note(const std::string& where, const std::string& why) { add(Problem::Severity::note, where, why); }

  Report errors_in(const std::string& part) {
    return [this, part](std::string_view field, const std::string& why) {
      error(part + ", field " + std::string(field), why);
    };
  }

  void check_resources() {
    check_metadata(capture_.metadata, errors_in("metadata"));
    check_count("buffers", capture_.buffers.size(), kMaxBuffers);
    check_count("textures", capture_.textures.size(), kMaxTextures);
    check_count("materials", capture_.materials.size(), kMaxMaterials);
    check_count("frames", capture_.frames.size(), kMaxFrames);
    for (std::size_t i = 0; i < capture_.buffers.size(); ++i) {
      check_buffer(capture_.buffers[i], errors_in("buffer " + std::to_string(i)));
    }
    for (std::size_t i = 0; i < capture_.textures.size(); ++i) {
      check_texture(capture_.textures[i], errors_in("texture " + std::to_string(i)));
    }
    for (std::size_t i = 0; i < capture_.materials.size(); ++i) {
      const std::string part = "material " + std::to_string(i);
      check_material(capture_.materials[i], capture_.textures.size(), errors_in(part));
      for (const TextureRead& read : texture_reads(capture_.materials[i])) {
        const std::array<float, 6>& m = read.uv->matrix;
        if (double{m[0]} * m[4] == double{m[1]} * m[3]) {
          note(part + ", field " + read.name + ".matrix", "singular: the texture is read along a line");
        }
      }
    }
  }

  void check_count(const std::string& what, std::size_t count, std::size_t most) {
    if (count > most) error(what, std::to_string(count) + " are more than " + std::to_string(most));
  }

  void check_one_frame(std::size_t number) {
    const Frame& frame = capture_.frames[number];
    const std::string part = "frame " + std::to_string(number);
    check_frame(frame, errors_in(part));
    check_draw_list(frame, errors_in(part));
    const bool has_view = is_finite(frame.view) && !is_singular(frame.view);
    const bool has_projection = is_finite(frame.projection) && !is_singular(frame.projection);
    if (is_finite(frame.view) && !has_view) error(part + ", field view", "singular");
    if (is_finite(frame.projection) && !has_projection) error(part + ", field projection", "singular");
    if (has_view && has_projection && is_mirrored(frame)) {
      note(part + ", field view",
           "mirrors, with the projection: front faces are seen as back faces, which are not drawn "
           "unless the material is two-sided");
    }
    if (frame.draws.empty()) note(part, "no draw calls");
    for (std::size_t d = 0; d < frame.draws.size(); ++d) {
      const Draw& draw = frame.draws[d];
      check_one_draw(draw, part + ", draw " + std::to_string(d) + " (" + draw.name + ")");
    }
  }

  void check_one_draw(const Draw& draw, const std::string& part) {
    bool is_sound = true;
    const Report report = [&](std::string_view field, const std::string& why) {
      is_sound = false;
      error(part + ", field " + std::string(field), why);
    };
    check_draw({sizes_, capture_.materials.size()}, draw, report);
    if (!is_sound) return;  // nothing below may look at ranges that are not there
    indices_.check(capture_, draw, report);
    if (!is_finite(draw.transform)) error(part + ", field transform", "not finite");
    if (triangle_count(draw) == 0) note(part, "no triangles");
    check_instances(draw, part);
    note_uv_sets(draw, part);
    note_stream(
        draw, draw.position, part + ", field position",
        [](const float* v) { return !(std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2])); },
        " of its vertices are not finite");
    note_stream(
        draw, draw.normal, part + ", field normal",
        [](const float* v) { return !(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > 0); },
        " of its normals have no direction");
    const auto is_odd_uv = [](const float* v) { return !(std::isfinite(v[0]) && std::isfinite(v[1])); };
    note_stream(draw, draw.uv, part + ", field uv", is_odd_uv, " of its uvs are not finite");
    note_stream(draw, draw.uv2, part + ", field uv2", is_odd_uv, " of its uvs are not finite");
    note_stream(
        draw, draw.colour, part + ", field colour",
        [](const float* v) { return std::any_of(v, v + 4, [](float c) { return !(std::isfinite(c) && c >= 0); }); },
        " of its colours are negative or not finite");
  }

  // Once for each material: frames repeat their draws, and a material is drawn many times.
  void note_uv_sets(const Draw& draw, const std::string& part) {
    const Material& material = capture_.materials[draw.material];
    for (const std::uint32_t set : {0u, 1u}) {
      const bool is_there = (set == 0 ? draw.uv : draw.uv2).buffer != kNone;
      const bool is_read = reads_uv_set(material, set);
      const std::string where = part + ", field " + (set == 0 ? "uv" : "uv2");
      if (is_read && !is_there && uv_sets_noted_.emplace(draw.material, set, is_there).second) {
        note(where, "absent: the textures of material " + std::to_string(draw.material) + " are read at (0, 0)");
      }
      // The first set is there for nothing in most scenes: generators and importers give it to every mesh.
      if (set == 1 && is_there && !is_read && uv_sets_noted_.emplace(draw.material, set, is_there).second) {
        note(where, "unused: no texture of material " + std::to_string(draw.material) + " is read at it");
      }
    }
  }

  void check_instances(const Draw& draw, const std::string& part) {
    if (draw.instance_buffer == kNone) return;
    Draw untransformed = draw;
    untransformed.transform = Draw{}.transform;
    std::size_t wrong = 0;
    for (const Matrix4& matrix : world_transforms(capture_, untransformed)) wrong += is_finite(matrix) ? 0 : 1;
    if (wrong > 0) error(part + ", field instance_buffer", std::to_string(wrong) + " of its matrices are not finite");
  }

  // Frames repeat their draws, so each stream is looked at once.
  template <typename Predicate>
  void note_stream(const Draw& draw, const VertexStream& stream, const std::string& where, Predicate is_odd,
                   const char* what) {
    if (stream.buffer == kNone) return;
    const auto [known, is_new] = odd_counts_.try_emplace(
        {stream.buffer, stream.format, stream.offset, stream.stride, draw.vertex_count, what}, 0u);
    if (is_new) {
      const std::vector<float> values = decode_stream(capture_, stream, draw.vertex_count, 4);
      for (std::size_t i = 0; i < values.size(); i += 4) known->second += is_odd(&values[i]) ? 1 : 0;
    }
    if (known->second > 0) note(where, std::to_string(known->second) + what);
  }

  using StreamKey = std::tuple<std::uint32_t, VertexFormat, std::uint64_t, std::uint32_t, std::uint32_t, std::string>;

  const Capture& capture_;
  const std::vector<std::uint64_t> sizes_;  // of the buffers
  IndexChecker indices_;
  std::map<StreamKey, std::size_t> odd_counts_;
  std::set<std::tuple<std::uint32_t, std::uint32_t, bool>> uv_sets_noted_;  // material, set, whether it was there
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> validate_capture(const Capture& capture) {
  return Validation(capture).run();
}

}  // namespace subpixel::capture
