#include "replay/frontend/host_setup.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <mutex>
#include <thread>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "shaders/frontend/sample_patterns.h"

namespace subpixel::replay {
namespace {

using glm::dvec2;
using glm::ivec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using gpu_types::ChunkRecord;
using gpu_types::TriangleRecord;

// One lane for each corner of a triangle, the last of them twice.
using Lanes = float __attribute__((vector_size(16)));
using LaneBits = std::int32_t __attribute__((vector_size(16)));

Lanes all(float value) {
  return Lanes{value, value, value, value};
}

// Rounded down; of magnitudes below 2^31.
LaneBits floored(Lanes value) {
  const LaneBits whole = __builtin_convertvector(value, LaneBits);
  return whole + (value < __builtin_convertvector(whole, Lanes));
}

// The highest bit of each lane, of which there are four.
unsigned signs(LaneBits lanes) {
#if defined(__x86_64__)
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(lanes)));
#else
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= lanes[i] < 0 ? 1U << i : 0U;
  return bits;
#endif
}

uvec4 bits(const vec2& a, const vec2& b) {
  return std::bit_cast<uvec4>(vec4(a, b));
}

struct ClipTriangle {
  Lanes x, y, z, w;
  ClipTriangle(Lanes cx, Lanes cy, Lanes cz, Lanes cw) : x(cx), y(cy), z(cz), w(cw) {}
  ClipTriangle(const vec4& a, const vec4& b, const vec4& c)
      : x{a.x, b.x, c.x, c.x}, y{a.y, b.y, c.y, c.y}, z{a.z, b.z, c.z, c.z}, w{a.w, b.w, c.w, c.w} {}
  vec4 corner(int i) const { return {x[i], y[i], z[i], w[i]}; }
};

std::uint32_t first_index_of(const ChunkRecord& chunk, std::uint32_t slot) {
  return chunk.range.x + 3 * (slot % SUBPIXEL_CHUNK_TRIANGLES);
}

// Which triangle of which draw a record is of.
void name_source(TriangleRecord& record, const ChunkRecord& chunk, std::uint32_t slot, bool mirrored) {
  record.hull2_id.z = first_index_of(chunk, slot);
  record.hull2_id.w = chunk.range.z;
  record.v2_ref.w |= (mirrored ? RECORD_MIRRORED : 0U) | chunk.range.w << RECORD_MATERIAL_SHIFT;
  record.depth2.w = slot;
}

// The rest of this file follows setup.glsl, setup.comp and clip.comp line by line, branches aside: operations and their
// order are the same, since the bits have to be.
class TriangleSetup {
 public:
  explicit TriangleSetup(const HostSetupInput& input)
      : in_(input),
        size_(input.frame.viewport.x, input.frame.viewport.y),
        half_size_(vec2(input.frame.viewport.x, input.frame.viewport.y) * 0.5F),
        guard_(1.0F + static_cast<float>(SUBPIXEL_GUARD_BAND_PX) * 2.0F *
                          vec2(input.frame.viewport.z, input.frame.viewport.w)),
        first_row_(static_cast<int>(input.frame.band.x)),
        rows_(static_cast<int>(input.frame.band.y)),
        reach_(input.samples == 1   ? 0.015625F
               : input.samples <= 8 ? 0.453125F
                                    : 0.515625F) {
    // The last group of lanes is filled up with samples that are there.
    for (std::uint32_t i = 0; i < offset_x_.size() * 4; ++i) {
      const gpu_types::SampleOffset offset = gpu_types::sample_offset(input.samples, i % input.samples);
      offset_x_[i / 4][i % 4] = static_cast<float>(offset.x);
      offset_y_[i / 4][i % 4] = static_cast<float>(offset.y);
    }
  }

  ClipTriangle source(std::uint32_t first_index, std::uint32_t instance) const {
    const glm::mat4& m = in_.clip_matrices[instance];
    const vec3 &a = in_.positions[in_.indices[first_index]], &b = in_.positions[in_.indices[first_index + 1]],
               &c = in_.positions[in_.indices[first_index + 2]];
    const Lanes x{a.x, b.x, c.x, c.x}, y{a.y, b.y, c.y, c.y}, z{a.z, b.z, c.z, c.z};
    const auto row = [&](int i) { return m[0][i] * x + (m[1][i] * y + (m[2][i] * z + m[3][i])); };
    return {row(0), row(1), row(2), row(3)};
  }

  bool mirrored(std::uint32_t instance) const { return in_.instances[instance].normal_row[0].w < 0.0F; }

  // Signed distances from a clip plane of setup.glsl, inside when not negative; of one point or of lanes.
  template <typename Number>
  Number plane_distance(std::uint32_t plane, const Number& x, const Number& y, const Number& z, const Number& w) const {
    switch (plane) {
      case 0:
        return w - z;
      case 1:
        return z;
      case 2:
        return guard_.x * w + x;
      case 3:
        return guard_.x * w - x;
      case 4:
        return guard_.y * w + y;
      default:
        return guard_.y * w - y;
    }
  }
  float plane_distance(std::uint32_t plane, const vec4& c) const { return plane_distance(plane, c.x, c.y, c.z, c.w); }

  // COUNT_ bits of a whole triangle, whose record is written when they are not 0.
  std::uint32_t set_up_whole(const ClipTriangle& t, const ChunkRecord& chunk, std::uint32_t slot,
                             TriangleRecord& record) const;
  // Triangles of the hull, 0: nothing is drawn and the record is not written.
  std::uint32_t set_up(const ClipTriangle& t, bool cull_back, bool mirrored, TriangleRecord& record) const;

 private:
  struct Cells {
    ivec2 first, last;
  };
  Cells cells_in_reach(ivec2 low, ivec2 high, ivec2 size, ivec2 cell) const {
    return {{std::max((low.x - 1) >> 8, 0) >> cell.x, std::max((low.y - 1) >> 8, 0) >> cell.y},
            {std::min((high.x + 1) >> 8, size.x - 1) >> cell.x, std::min((high.y + 1) >> 8, size.y - 1) >> cell.y}};
  }
  bool touches_a_sample(const std::array<ivec2, 3>& v, const Cells& cells) const;
  std::uint32_t conservative_hull(const std::array<vec2, 3>& p, double w, std::array<vec2, 4>& hull) const;
  bool in_band(const TriangleRecord& record) const;
  float pixels_reached(const TriangleRecord& record) const;
  std::uint32_t blocks_reached(const TriangleRecord& record) const;

  const HostSetupInput& in_;
  ivec2 size_;
  vec2 half_size_, guard_;
  int first_row_, rows_;
  float reach_;
  std::array<Lanes, 16> offset_x_{}, offset_y_{};  // of samples, four at a time
};

bool TriangleSetup::touches_a_sample(const std::array<ivec2, 3>& v, const Cells& cells) const {
  std::array<float, 3> a{}, b{};
  std::array<ivec2, 3> along{};
  for (int i = 0; i < 3; ++i) {
    along[i] = v[(i + 1) % 3] - v[i];
    a[i] = static_cast<float>(-along[i].y);
    b[i] = static_cast<float>(along[i].x);
  }
  for (int y = cells.first.y; y <= cells.last.y; ++y) {
    for (int x = cells.first.x; x <= cells.last.x; ++x) {
      const ivec2 point = ivec2(x, y) * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2;
      std::array<float, 3> base{};
      for (int i = 0; i < 3; ++i) {
        const bool inclusive = along[i].y < 0 || (along[i].y == 0 && along[i].x > 0);
        const int value = along[i].x * (point.y - v[i].y) - along[i].y * (point.x - v[i].x) - (inclusive ? 0 : 1);
        base[i] = static_cast<float>(std::clamp(value >> 1, -8388608, 8388608));
      }
      for (std::uint32_t i = 0; i < in_.samples; i += 4) {
        const auto edge = [&](int k) {
          return (LaneBits)(base[k] + a[k] * offset_x_[i / 4] + b[k] * offset_y_[i / 4]);
        };
        if (signs(edge(0) | edge(1) | edge(2)) != 0xf) return true;
      }
    }
  }
  return false;
}

bool near_enough(const vec2& a, const vec2& b, const vec2& c, const vec2& d) {
  constexpr float kFarthestCorner_px = 16384.0F;
  const vec2 farthest = glm::max(glm::max(glm::abs(a), glm::abs(b)), glm::max(glm::abs(c), glm::abs(d)));
  return std::max(farthest.x, farthest.y) < kFarthestCorner_px;
}

std::uint32_t TriangleSetup::conservative_hull(const std::array<vec2, 3>& p, double w,
                                               std::array<vec2, 4>& hull) const {
  constexpr float kSecondTriangle_px = 6.0F;
  const vec2 low = glm::max(glm::min(glm::min(p[0], p[1]), p[2]) - reach_, vec2(-1.0F));
  const vec2 high =
      glm::min(glm::max(glm::max(p[0], p[1]), p[2]) + reach_, vec2(in_.frame.viewport.x, in_.frame.viewport.y) + 1.0F);
  const vec2 size = high - low;
  hull = {low, vec2(low.x + 2.0F * size.x, low.y), vec2(low.x, low.y + 2.0F * size.y), low};
  std::uint32_t triangles = 1;
  float best = 2.0F * size.x * size.y;
  if (0.5F * best + kSecondTriangle_px < best) {
    hull = {low, vec2(high.x, low.y), high, vec2(low.x, high.y)};
    triangles = 2;
    best = 0.5F * best + kSecondTriangle_px;
  }

  std::array<dvec2, 3> n{}, q{};
  std::array<double, 3> c{};
  std::array<vec2, 3> out_by{};
  for (int k = 0; k < 3; ++k) {
    const dvec2 along = dvec2(p[(k + 1) % 3]) - dvec2(p[k]);
    n[k] = {along.y, -along.x};
    c[k] = static_cast<double>(reach_) * (std::abs(n[k].x) + std::abs(n[k].y));
  }
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 2) % 3;
    const dvec2 away((c[a] * n[k].y - c[k] * n[a].y) / w, (c[k] * n[a].x - c[a] * n[k].x) / w);
    q[k] = dvec2(p[k]) + away;
    out_by[k] = vec2(away);
  }
  const vec2 e1(q[1] - q[0]), e2(q[2] - q[0]);
  const float area = 0.5F * std::abs(e1.x * e2.y - e2.x * e1.y);
  if (area < best && near_enough(vec2(q[0]), vec2(q[1]), vec2(q[2]), vec2(0.0F))) {
    hull = {vec2(q[0]), vec2(q[1]), vec2(q[2]), vec2(q[0])};
    triangles = 1;
    best = area;
  }

  const auto length = [&](int k) { return out_by[k].x * out_by[k].x + out_by[k].y * out_by[k].y; };
  const float l0 = length(0), l1 = length(1), l2 = length(2);
  const int tip = l0 >= l1 && l0 >= l2 ? 0 : l1 >= l2 ? 1 : 2;
  const int left = (tip + 1) % 3, right = (tip + 2) % 3;
  const float tip_length = std::sqrt(length(tip));
  const vec2 direction = out_by[tip] / std::max(tip_length, 1e-20F);
  const auto along = [&](const vec2& v) { return direction.x * v.x + direction.y * v.y; };
  const float reached = std::max(std::max(along(p[left] - p[tip]), along(p[right] - p[tip])), 0.0F) +
                        reach_ * (std::abs(direction.x) + std::abs(direction.y));
  const float cut = tip_length - reached;
  const vec2 to_left(q[left] - q[tip]), to_right(q[right] - q[tip]);
  const float height_left = -along(to_left), height_right = -along(to_right);
  const float quad_area = area * (1.0F - cut * cut / (height_left * height_right)) + kSecondTriangle_px;
  if (cut > 0.0F && cut < height_left && cut < height_right && quad_area < best) {
    const vec2 cut_left(q[tip] + (q[left] - q[tip]) * static_cast<double>(cut / height_left));
    const vec2 cut_right(q[tip] + (q[right] - q[tip]) * static_cast<double>(cut / height_right));
    if (near_enough(vec2(q[left]), vec2(q[right]), cut_left, cut_right)) {
      hull = {vec2(q[left]), vec2(q[right]), cut_right, cut_left};
      triangles = 2;
    }
  }
  return triangles;
}

std::uint32_t TriangleSetup::set_up(const ClipTriangle& t, bool cull_back, bool mirrored,
                                    TriangleRecord& record) const {
  constexpr auto kSnap = static_cast<float>(SUBPIXEL_SNAP);
  const LaneBits x = floored((t.x / t.w * half_size_.x + half_size_.x) * kSnap + 0.5F);
  const LaneBits y = floored((t.y / t.w * half_size_.y + half_size_.y) * kSnap + 0.5F);
  const ivec2 v0(x[0], y[0]);
  ivec2 v1(x[1], y[1]), v2(x[2], y[2]);
  // Below 2^47, so whole numbers and doubles hold it.
  std::int64_t area = std::int64_t{v1.x - v0.x} * (v2.y - v0.y) - std::int64_t{v2.x - v0.x} * (v1.y - v0.y);
  const bool back = (area > 0) != mirrored;
  if (area == 0 || (cull_back && back)) return 0;
  const bool turned = area < 0;
  if (turned) {
    std::swap(v1, v2);
    area = -area;
  }
  const ivec2 low = glm::min(glm::min(v0, v1), v2), high = glm::max(glm::max(v0, v1), v2);
  const Cells cells = cells_in_reach(low, high, size_, ivec2(0));
  const ivec2 extent = cells.last - cells.first + 1;
  if (extent.x <= 0 || extent.y <= 0) return 0;
  const bool large = std::max(high.x - low.x, high.y - low.y) > SUBPIXEL_SMALL_PX * SUBPIXEL_SNAP;
  if (!large && extent.x * extent.y <= (in_.samples > 16 ? 1 : 6) && !touches_a_sample({v0, v1, v2}, cells)) return 0;

  const Lanes n = t.z / t.w;
  const float n0 = n[0], n1 = turned ? n[2] : n[1], n2 = turned ? n[1] : n[2];
  ivec2 reference = glm::clamp(ivec2((low.x + high.x) >> 9, (low.y + high.y) >> 9), ivec2(0), size_ - 1);
  const auto twice_area = static_cast<double>(area);
  const double z0 = n0, z1 = static_cast<double>(n1) - z0, z2 = static_cast<double>(n2) - z0;
  const double inverse_area = 1.0 / twice_area;
  const double dx = (z1 * (v2.y - v0.y) - z2 * (v1.y - v0.y)) * inverse_area;
  const double dy = (z2 * (v1.x - v0.x) - z1 * (v2.x - v0.x)) * inverse_area;
  const ivec2 from_v0 = reference * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2 - v0;
  const double z = z0 + dx * from_v0.x + dy * from_v0.y;

  const std::array<vec2, 3> p{vec2(v0) / 256.0F, vec2(v1) / 256.0F, vec2(v2) / 256.0F};
  std::array<vec2, 4> hull{};
  const std::uint32_t triangles = conservative_hull(p, twice_area * (1.0 / 65536.0), hull);
  record.hull01 = bits(hull[0], hull[1]);
  record.hull2_id = bits(hull[2], vec2(0.0F));
  const ivec2 corner(0, first_row_);
  const ivec2 band_v0 = v0 - corner * SUBPIXEL_SNAP, band_v1 = v1 - corner * SUBPIXEL_SNAP;
  const glm::uvec2 band_v2(v2 - corner * SUBPIXEL_SNAP);
  record.v01 = uvec4(glm::uvec2(band_v0), glm::uvec2(band_v1));
  reference -= corner;
  record.v2_ref =
      uvec4(band_v2, static_cast<std::uint32_t>(reference.x) | static_cast<std::uint32_t>(reference.y) << 16,
            (back ? RECORD_BACK_FACE : 0U) | (large ? RECORD_LARGE : 0U));
  const auto bounded = [](double value) {
    return std::bit_cast<std::uint32_t>(std::clamp(static_cast<float>(value), -1e30F, 1e30F));
  };
  record.depth = uvec4(bounded(z), bounded(dx * 256.0), bounded(dy * 256.0),
                       std::bit_cast<std::uint32_t>(std::min(std::min(n0, n1), n2)));
  record.depth2 = uvec4(std::bit_cast<std::uint32_t>(std::max(std::max(n0, n1), n2)),
                        std::bit_cast<std::uint32_t>(hull[3].x), std::bit_cast<std::uint32_t>(hull[3].y), 0U);
  return triangles;
}

bool TriangleSetup::in_band(const TriangleRecord& record) const {
  const vec4 rows = std::bit_cast<vec4>(uvec4(record.hull01.y, record.hull01.w, record.hull2_id.y, record.depth2.z));
  const float low = std::min(std::min(rows.x, rows.y), std::min(rows.z, rows.w));
  const float high = std::max(std::max(rows.x, rows.y), std::max(rows.z, rows.w));
  const auto first = static_cast<float>(first_row_);
  return high > first - 1.0F && low < first + static_cast<float>(rows_) + 1.0F;
}

float TriangleSetup::pixels_reached(const TriangleRecord& record) const {
  const vec2 v0 = vec2(ivec2(record.v01.x, record.v01.y)) / 256.0F,
             v1 = vec2(ivec2(record.v01.z, record.v01.w)) / 256.0F;
  const vec2 v2 = vec2(ivec2(record.v2_ref.x, record.v2_ref.y)) / 256.0F;
  const vec2 size = glm::max(glm::max(v0, v1), v2) - glm::min(glm::min(v0, v1), v2);
  const float area = 0.5F * std::abs((v1.x - v0.x) * (v2.y - v0.y) - (v2.x - v0.x) * (v1.y - v0.y));
  const float across = 2.0F * reach_;
  return area + across * (size.x + size.y) + across * across;
}

std::uint32_t TriangleSetup::blocks_reached(const TriangleRecord& record) const {
  const ivec2 v0(record.v01.x, record.v01.y), v1(record.v01.z, record.v01.w), v2(record.v2_ref.x, record.v2_ref.y);
  const Cells blocks = cells_in_reach(glm::min(glm::min(v0, v1), v2), glm::max(glm::max(v0, v1), v2),
                                      ivec2(size_.x, rows_), ivec2(2, 1));
  const ivec2 extent = glm::max(blocks.last - blocks.first + 1, ivec2(0));
  return static_cast<std::uint32_t>(extent.x * extent.y);
}

std::uint32_t TriangleSetup::set_up_whole(const ClipTriangle& t, const ChunkRecord& chunk, std::uint32_t slot,
                                          TriangleRecord& record) const {
  const bool is_mirrored = mirrored(chunk.range.z);
  const std::uint32_t hull = set_up(t, (chunk.flags.x & CHUNK_CULL_BACK) != 0, is_mirrored, record);
  if (hull == 0 || !in_band(record)) return 0;
  name_source(record, chunk, slot, is_mirrored);
  if ((record.v2_ref.w & RECORD_LARGE) != 0 || !(pixels_reached(record) <= SUBPIXEL_SMALL_TRIANGLE_PX)) return hull;
  const std::uint32_t kind = (chunk.flags.x & CHUNK_ALPHA_TEST) == 0 ? COUNT_SMALL : COUNT_SMALL_TESTED;
  return hull | kind | blocks_reached(record) << COUNT_BLOCKS_SHIFT;
}

// Where a triangle lies to the clip planes.
enum class Place { outside, whole, crossing };

Place place_of(const TriangleSetup& setup, const ClipTriangle& t) {
  // Zero, or no number where one of them is none or infinite.
  const Lanes none = (t.x - t.x) + (t.y - t.y) + (t.z - t.z) + (t.w - t.w);
  if (signs(none != none) != 0) return Place::outside;
  LaneBits outside_any = ~(t.w > all(0.0F));
  for (std::uint32_t plane = 0; plane < 6; ++plane) {
    const LaneBits outside = ~(setup.plane_distance(plane, t.x, t.y, t.z, t.w) >= all(0.0F));
    if (signs(outside) == 0xf) return Place::outside;
    outside_any |= outside;
  }
  return signs(outside_any) == 0 ? Place::whole : Place::crossing;
}

// Calls `piece(number, record)` for the pieces of a clipped triangle that are drawn; returns how many they are.
template <typename Piece>
std::uint32_t clip(const TriangleSetup& setup, const HostSetupInput& input, std::uint32_t slot, const Piece& piece) {
  const ChunkRecord& chunk = input.chunks[slot / SUBPIXEL_CHUNK_TRIANGLES];
  const ClipTriangle t = setup.source(first_index_of(chunk, slot), chunk.range.z);
  constexpr std::uint32_t kMaxCorners = 9;
  std::array<vec4, kMaxCorners> corners{t.corner(0), t.corner(1), t.corner(2)}, next{};
  std::uint32_t count = 3;
  for (std::uint32_t plane = 0; plane < 6; ++plane) {
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      const vec4 &a = corners[k], &b = corners[k + 1 < count ? k + 1 : 0];
      const float da = setup.plane_distance(plane, a), db = setup.plane_distance(plane, b);
      if (da >= 0.0F && kept < kMaxCorners) next[kept++] = a;
      if ((da >= 0.0F) == (db >= 0.0F) || kept >= kMaxCorners) continue;
      const vec4 &inside = da >= 0.0F ? a : b, &outside = da >= 0.0F ? b : a;
      const float di = std::max(da, db), beyond = std::min(da, db), share = di / (di - beyond);
      next[kept++] = inside * (1.0F - share) + outside * share;
    }
    count = kept;
    std::copy_n(next.begin(), kept, corners.begin());
  }
  const bool is_mirrored = setup.mirrored(chunk.range.z);
  std::uint32_t pieces = 0;
  for (std::uint32_t k = 2; k < count; ++k) {
    if (!(corners[0].w > 0.0F && corners[k - 1].w > 0.0F && corners[k].w > 0.0F)) continue;
    TriangleRecord record;
    const std::uint32_t hull = setup.set_up({corners[0], corners[k - 1], corners[k]},
                                            (chunk.flags.x & CHUNK_CULL_BACK) != 0, is_mirrored, record);
    if (hull == 0) continue;
    if (hull == 1) {
      record.depth2.y = record.hull01.x;
      record.depth2.z = record.hull01.y;
    }
    name_source(record, chunk, slot, is_mirrored);
    piece(pieces++, record);
  }
  return pieces;
}

// Calls `work(first, end)` for parts of 0 to `count`, on all threads of the machine. What the parts write must not
// meet.
template <typename Work>
void in_parts(std::size_t count, std::size_t part, const Work& work) {
  std::atomic<std::size_t> next = 0;
  const auto take = [&] {
    for (std::size_t first = next.fetch_add(part); first < count; first = next.fetch_add(part))
      work(first, std::min(first + part, count));
  };
  const std::size_t parts = (count + part - 1) / part;
  std::vector<std::jthread> threads;
  for (std::size_t i = 1; i < std::min<std::size_t>(parts, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back(take);
  take();
}

constexpr std::size_t kPart = 64;  // chunks that a thread takes at a time

}  // namespace

std::vector<std::uint32_t> set_up_on_host(const HostSetupInput& input, std::span<TriangleRecord> records,
                                          std::span<std::uint32_t> counts) {
  const TriangleSetup setup(input);
  std::vector<std::uint32_t> clipped;
  std::mutex clipped_mutex;
  in_parts(input.chunks.size(), kPart, [&](std::size_t first, std::size_t end) {
    std::vector<std::uint32_t> crossing;
    for (std::size_t c = first; c < end; ++c) {
      const ChunkRecord& chunk = input.chunks[c];
      for (std::uint32_t lane = 0; lane < SUBPIXEL_CHUNK_TRIANGLES; ++lane) {
        const auto slot = static_cast<std::uint32_t>(c * SUBPIXEL_CHUNK_TRIANGLES + lane);
        counts[slot] = 0;
        if (lane >= chunk.range.y) continue;
        const ClipTriangle t = setup.source(first_index_of(chunk, slot), chunk.range.z);
        switch (place_of(setup, t)) {
          case Place::whole:
            counts[slot] = setup.set_up_whole(t, chunk, slot, records[slot]);
            break;
          case Place::crossing:
            counts[slot] = clip(setup, input, slot, [](std::uint32_t, const TriangleRecord&) {}) | COUNT_CLIPPED;
            crossing.push_back(slot);
            break;
          case Place::outside:
            break;
        }
      }
    }
    const std::scoped_lock lock(clipped_mutex);
    clipped.insert(clipped.end(), crossing.begin(), crossing.end());
  });
  std::ranges::sort(clipped);
  return clipped;
}

void emit_pieces_on_host(const HostSetupInput& input, std::span<const std::uint32_t> clipped,
                         std::span<const std::uint32_t> piece_bases, std::span<TriangleRecord> pieces) {
  const TriangleSetup setup(input);
  in_parts(clipped.size(), kPart, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
      clip(setup, input, clipped[i], [&](std::uint32_t number, const TriangleRecord& record) {
        const std::size_t at = std::size_t{piece_bases[clipped[i]]} + number;
        if (at < pieces.size()) pieces[at] = record;
      });
  });
}

}  // namespace subpixel::replay
