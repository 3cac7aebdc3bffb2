// Deferred attribute interpolation: a visibility buffer, and a triangle buffer of the triangles that show. A triangle
// is stored as a sample point and the screen-space change of each attribute / w and of 1 / w, from which shading
// interpolates without its vertices.
// Schied and Dachsbacher 2015, "Deferred Attribute Interpolation for Memory-Efficient Deferred Shading", HPG 2015.
// The publication fills its buffer while it draws; here the triangles are numbered once visibility is known, by a scan,
// so that which of them a full buffer leaves out does not depend on threads.
#include <algorithm>

#include "replay/frame/frame_images.hpp"
#include "replay/frontend/list_passes.hpp"
#include "replay/techniques/visible_shading.hpp"
#include "shaders/techniques/dais/dais_interface.h"

namespace subpixel::replay {
namespace {

constexpr const char* kTriangles = "triangles";

struct DaisParameters : CommonParameters {
  ShadingPoint point = ShadingPoint::visible;
  double pool = 4;
};

using Setup = SetupFor<DaisParameters>;

// What host and shaders know of the buffer.
struct TriangleBuffer {
  gpu::Buffer *numbers = nullptr, *words = nullptr;
  gpu::AddressTable* table = nullptr;
  std::uint32_t stored = 0;
  std::uint64_t triangle_words = 0;
};

std::uint64_t triangle_words(const Setup& setup) {
  return DAIS_WORDS(setup.scene.features().bits);
}

double pixels(const Setup& setup) {
  return static_cast<double>(setup.width) * setup.frame_height();
}

bool is_band(const Setup& setup) {
  return setup.height != setup.frame_height();
}

bool numbers_fit(const Setup& setup, std::uint64_t fragments) {
  return (fragments + 1) * 4 <= setup.frontend.device().info().max_storage_buffer_range;
}

// None where the fragments' numbers are more than can be scanned: then all attributes come from vertices.
std::uint32_t stored_triangles(const Setup& setup) {
  const FragmentListSizes& lists = setup.lists.value();
  if (!numbers_fit(setup, lists.count)) return 0;
  return static_cast<std::uint32_t>(
      std::min(static_cast<double>(lists.triangles), setup.parameters.pool * pixels(setup)));
}

MemoryLayout layout(const Setup& setup) {
  const double n = setup.samples;
  // With normals and one pair of coordinates, whether the scene needs those or more.
  const double words = static_cast<double>(stored_triangles(setup)) * DAIS_WORDS(FEATURE_BASE_TEXTURE);
  return {{"depth", 32 * n}, {"triangle numbers", 32 * n}, {"triangle buffer", 32 * words / pixels(setup)}};
}

TriangleBuffer make_buffer(gpu::PassRecorder& recorder, const Setup& setup) {
  TriangleBuffer made;
  made.stored = stored_triangles(setup);
  made.triangle_words = triangle_words(setup);
  const std::uint64_t fragments = made.stored > 0 ? setup.lists->count : 0;
  made.numbers = &recorder.buffer("triangle numbers", (fragments + 1) * 4);
  made.words = &recorder.buffer("triangle buffer", std::max<std::uint64_t>(made.stored * made.triangle_words, 1) * 4);
  made.table = &recorder.address_table("triangle addresses", sizeof(gpu_types::TriangleBuffer));
  made.table->set(gpu_types::TriangleBuffer{
      .numbers = made.table->of(*made.numbers), .words = made.table->of(*made.words), .capacity = made.stored});
  return made;
}

void record_numbers(gpu::PassRecorder& recorder, const Setup& setup, const FragmentLists& lists,
                    const TriangleBuffer& triangles) {
  const std::uint64_t items = lists.count + 1;
  gpu::Buffer& sums = recorder.buffer("triangle sums", (std::uint64_t{groups_of(items)} + 1) * 16);
  gpu::ComputePass pass;
  pass.name = kTriangles;
  pass.constants = setup.frontend.constants();
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(FRONTEND_SLOT_LISTS, *lists.addresses),
                   gpu::writes(DAIS_SLOT_TRIANGLES, *triangles.table)};
  pass.push = gpu::PushConstants(gpu_types::DaisNumberPush{static_cast<std::uint32_t>(lists.count)});
  pass.groups = grid_of(items);
  pass.shader = "techniques/dais/number.comp:FIRST";
  recorder.compute(pass);
  record_bases(recorder, kTriangles, *triangles.numbers, sums, static_cast<std::uint32_t>(items));
  pass.shader = "techniques/dais/number.comp:RECORD";
  recorder.compute(std::move(pass));
}

void record_planes(gpu::PassRecorder& recorder, const Setup& setup, const TriangleBuffer& triangles) {
  gpu::ComputePass pass;
  pass.name = kTriangles;
  pass.shader = "techniques/dais/planes.comp";
  pass.constants = setup.frontend.constants();
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::writes(DAIS_SLOT_TRIANGLES, *triangles.table)};
  gpu_types::HullPush push = setup.frontend.hull_push(pass, 0);
  push.last_fragment = triangles.stored;  // of the triangles, here
  pass.push = gpu::PushConstants(push);
  pass.groups = grid_of(triangles.stored);
  recorder.compute(std::move(pass));
}

// Of a band: which records its fragments have, since a triangle may show in several bands.
void record_triangles_of_band(gpu::PassRecorder& recorder, const Setup& setup, const FragmentLists& lists,
                              const TriangleBuffer& triangles) {
  recorder.host(once([&records = setup.outputs.records, triangles, fragments = lists.fragments, count = lists.count,
                      numbers = setup.frontend.record_count()] {
    std::vector<bool>&visible = records["visible_triangles"], &stored = records["stored_triangles"],
    &without = records["triangles_without_planes"];
    for (std::vector<bool>* all : {&visible, &stored, &without}) all->assign(numbers, false);
    const auto fragment = fragments->as<glm::uvec4>();
    const auto words = triangles.words->as<std::uint32_t>();
    std::uint64_t triangle = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i > 0 && fragment[i].x == fragment[i - 1].x) continue;
      const std::uint32_t record = fragment[i].x;
      visible[record] = true;
      stored[record] = triangle < triangles.stored;
      without[record] = stored[record] && words[triangle * triangles.triangle_words] == DAIS_NO_PLANES;
      ++triangle;
    }
  }));
}

void record_counters(gpu::PassRecorder& recorder, const Setup& setup, const FragmentLists& lists,
                     const TriangleBuffer& triangles) {
  if (is_band(setup)) {
    record_triangles_of_band(recorder, setup, lists, triangles);
    return;
  }
  recorder.host(once([&counters = setup.outputs.counters, triangles, seen = setup.lists->triangles] {
    const auto words = triangles.words->as<std::uint32_t>();
    std::uint64_t without = 0;
    for (std::uint32_t t = 0; t < triangles.stored; ++t)
      without += words[t * triangles.triangle_words] == DAIS_NO_PLANES ? 1 : 0;
    counters["visible_triangles"] = seen;
    counters["stored_triangles"] = triangles.stored;
    counters["triangles_without_planes"] = without;
  }));
}

void record_map(gpu::PassRecorder& recorder, const Setup& setup, const FragmentLists& lists,
                const TriangleBuffer& triangles) {
  gpu::RasterPass pass = fullscreen_pass(setup, "maps", "techniques/dais/maps.frag");
  pass.colours = make_maps(recorder, setup, {"from_vertices"});
  pass.bindings.push_back(gpu::reads(FRONTEND_SLOT_LISTS, *lists.addresses));
  pass.bindings.push_back(gpu::reads(DAIS_SLOT_TRIANGLES, *triangles.table));
  recorder.host(once(run_pass(recorder.device(), std::move(pass))));
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  const TriangleBuffer triangles = make_buffer(recorder, setup);
  if (triangles.stored > 0) {
    record_numbers(recorder, setup, visible.lists, triangles);
    record_planes(recorder, setup, triangles);
  }
  record_counters(recorder, setup, visible.lists, triangles);
  record_map(recorder, setup, visible.lists, triangles);
  ListedPass shade = visible_shading(setup, setup.parameters.point, "techniques/dais/shade.comp");
  shade.bindings.push_back(gpu::reads(DAIS_SLOT_TRIANGLES, *triangles.table));
  record_listed_fragments(recorder, setup, visible.lists, shade);
  record_visible_resolve(recorder, setup, visible.lists);
}

}  // namespace

extern const Technique kDais;

const Technique kDais = TechniqueOf<DaisParameters>{
    .name = "dais",
    .title = "Deferred attribute interpolation",
    .paper =
        "Schied, Dachsbacher: Deferred Attribute Interpolation for Memory-Efficient Deferred Shading. "
        "High-Performance Graphics 2015",
    .fields = {field::samples({1, 2, 4, 8, 16, 32, 64}), field::shading_point(&DaisParameters::point),
               field::number("pool", &DaisParameters::pool, {0, 1e6},
                             "triangles that the triangle buffer has room for, a pixel; of those behind them, in "
                             "submission order, attributes come from the vertices"),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {{"from_vertices", "Fragments interpolated from vertices", "fragments", 8}},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
    .whole_only = [](const Setup& whole) -> std::string {
      const FragmentListSizes& lists = whole.lists.value();
      if (static_cast<double>(lists.triangles) <= whole.parameters.pool * pixels(whole) &&
          numbers_fit(whole, lists.count))
        return "";
      return "its triangle buffer has no room for all triangles that show, which are counted over all of the frame";
    },
};

}  // namespace subpixel::replay
