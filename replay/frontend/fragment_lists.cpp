#include "replay/frontend/fragment_lists.hpp"

#include <algorithm>

#include "replay/frontend/list_passes.hpp"
#include "replay/frontend/visibility.hpp"

namespace subpixel::replay {
namespace {

// Where the counting passes write; sums are scanned over chunks of triangles and groups of pixels.
struct Counted {
  gpu::Buffer *ends, *bases, *chunk_sums, *pixel_sums;
  gpu::AddressTable* addresses;
};

Counted make_counted(gpu::PassRecorder& recorder, const FrontendFrame& frame) {
  const Frontend& frontend = frame.frontend;
  const std::uint64_t pixels = std::uint64_t{frame.width} * frame.height;
  return {&recorder.buffer("pixel list ends", pixels * 4),
          &recorder.buffer("fragment bases", frame.frontend.records().bytes() / sizeof(gpu_types::TriangleRecord) * 4),
          &recorder.buffer("fragment sums", (std::uint64_t{frontend.chunk_count()} + 1) * 16),
          &recorder.buffer("pixel list sums", (groups_of(pixels) + 1) * 16),
          &recorder.address_table("list addresses", sizeof(gpu_types::ListAddresses))};
}

// Both kinds of triangles, counted or stored.
void record_collection(gpu::PassRecorder& recorder, const FrontendFrame& frame, const FragmentLists& lists,
                       const std::string& name, ListedMasks masks, const std::string& variant) {
  Frontend& frontend = frame.frontend;
  gpu::ComputePass small;
  small.name = name;
  small.shader = "frontend/collect.comp:" + variant;
  small.constants = frontend.constants();
  small.constants.emplace_back(FRONTEND_CONSTANT_WITH_MASKS, static_cast<std::uint32_t>(masks));
  small.bindings = {gpu::reads(FRONTEND_SLOT_SMALL_RECORDS, frontend.small_records())};
  const gpu_types::CollectPush push{.lists = lists.writes(small),
                                    .records = small.reads(frontend.records()),
                                    .count = static_cast<std::uint32_t>(frontend.small_count(true)),
                                    .width = frame.width,
                                    .height = frame.height};
  small.push = gpu::PushConstants(push);
  small.groups = dealt_grid_of(frontend.small_count(true));
  recorder.compute(std::move(small));

  Frontend::GeometryPass rest;
  rest.without_small = true;
  rest.rasterise_frame = true;
  rest.fragment_opaque = rest.fragment_alpha = "frontend/collect.frag:" + variant;
  rest.pass.name = name;
  rest.pass.pipeline.constants = {{CONSTANT_ALPHA_MODE, static_cast<std::uint32_t>(frame.alpha)},
                                  {FRONTEND_CONSTANT_WITH_MASKS, static_cast<std::uint32_t>(masks)}};
  rest.pass.size = {frame.width, frame.height};
  rest.pass.bindings = {gpu::writes(FRONTEND_SLOT_LISTS, *lists.addresses)};
  frontend.record_geometry(recorder, std::move(rest));
}

// Turns counts of records and pixels into bases.
void record_all_bases(gpu::PassRecorder& recorder, const FrontendFrame& frame, const Counted& counted,
                      const std::string& name) {
  Frontend& frontend = frame.frontend;
  gpu::ComputePass bases;
  bases.name = name;
  bases.bindings = {gpu::reads(FRONTEND_SLOT_COUNTS, frontend.counts()),
                    gpu::writes(FRONTEND_SLOT_SUMS, *counted.chunk_sums),
                    gpu::reads(FRONTEND_SLOT_PIECE_BASES, frontend.piece_bases()),
                    gpu::writes(FRONTEND_SLOT_FRAGMENT_BASES, *counted.bases)};
  const gpu_types::FragmentBasesPush chunks{frontend.chunk_count(), frontend.triangle_slots()};
  bases.push = gpu::PushConstants(chunks);
  bases.groups = {groups_of(frontend.chunk_count()), 1, 1};

  bases.shader = "frontend/fragment_bases.comp:SUM";
  recorder.compute(bases);
  record_scan(recorder, name, *counted.chunk_sums, frontend.chunk_count());
  bases.shader = "frontend/fragment_bases.comp:BASE";
  recorder.compute(bases);
  record_bases(recorder, name, *counted.ends, *counted.pixel_sums, frame.width * frame.height);
}

// Counts the fragments of pixels and records and turns the counts into bases.
void record_counting(gpu::PassRecorder& recorder, const FrontendFrame& frame, const Counted& counted,
                     const FragmentLists& lists, const std::string& name, ListedMasks masks) {
  frame.frontend.record_small_list(recorder, name, true);
  recorder.fill(name, *counted.ends, 0);
  recorder.fill(name, *counted.bases, 0);
  record_collection(recorder, frame, lists, name, masks, "COUNT");
  record_all_bases(recorder, frame, counted, name);
}

// The visible fragments, counted (COUNT) or stored (STORE).
void record_visible_pass(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& visibility,
                         const FragmentLists& lists, const std::string& name, const std::string& variant) {
  gpu::ComputePass pass;
  pass.name = name;
  pass.shader = "frontend/visible_fragments.comp:" + variant;
  pass.constants = frame.frontend.constants();
  pass.bindings = {gpu::samples(FRAME_SLOT_VISIBILITY, visibility)};
  pass.push = gpu::PushConstants(
      gpu_types::VisibleFragmentsPush{.lists = lists.writes(pass), .width = frame.width, .height = frame.height});
  pass.groups = {(frame.width + 7) / 8, (frame.height + 7) / 8, 1};
  recorder.compute(std::move(pass));
}

void record_visible_counting(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& visibility,
                             const Counted& counted, const FragmentLists& lists, const std::string& name) {
  recorder.fill(name, *counted.bases, 0);
  record_visible_pass(recorder, frame, visibility, lists, name, "COUNT");
  record_all_bases(recorder, frame, counted, name);
}

// Sorts the lists of several parts.
void record_long_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame, const FragmentLists& lists,
                       const std::string& name) {
  gpu::Buffer& merged = recorder.buffer("merged fragment numbers", lists.count * 4);
  const auto record = [&](const std::string& shader, std::uint32_t part) {
    gpu::ComputePass pass;
    pass.name = name;
    pass.shader = shader;
    pass.push = gpu::PushConstants(gpu_types::ListPartPush{.lists = lists.writes(pass),
                                                           .merged = pass.writes(merged),
                                                           .width = frame.width,
                                                           .height = frame.height,
                                                           .part = part});
    pass.groups = {(frame.width + 7) / 8, (frame.height + 7) / 8, 1};
    recorder.compute(std::move(pass));
  };
  for (std::uint32_t part = 0; part < lists.parts; ++part) record("frontend/sort_part.comp", part);
  record("frontend/merge_parts.comp", 0);
}

std::vector<FragmentLists::Batch> batches_of(const Frontend& frontend, const Counted& counted) {
  const auto sums = counted.chunk_sums->as<glm::uvec4>();
  std::vector<FragmentLists::Batch> batches;
  for (const Frontend::Batch& batch : frontend.material_batches()) {
    const std::uint64_t first = sums[batch.first_chunk].x, last = sums[batch.last_chunk].x;
    if (first < last) batches.push_back({first, last, batch.material, batch.alpha_test});
  }
  return batches;
}

// Of `count` fragments, those in rows that count; after a run.
std::uint64_t kept_fragments(const FrontendFrame& frame, const Counted& counted, std::uint64_t count) {
  if (frame.kept_rows == 0) return count;
  const auto begins = counted.ends->as<std::uint32_t>().first(std::size_t{frame.width} * frame.height);
  const auto before = [&](std::size_t row) { return row < frame.height ? begins[row * frame.width] : count; };
  return before(std::size_t{frame.kept_first} + frame.kept_rows) - before(frame.kept_first);
}

FragmentLists lists_of(const Counted& counted) {
  FragmentLists lists;  // without the two that are sized by counting, which does not touch them
  lists.ends = counted.ends;
  lists.bases = counted.bases;
  lists.addresses = counted.addresses;
  lists.addresses->set(gpu_types::ListAddresses{.fragments = 0,
                                                .numbers = 0,
                                                .ends = counted.addresses->of(*lists.ends),
                                                .bases = counted.addresses->of(*lists.bases)});
  return lists;
}

// With room for the fragments.
FragmentLists lists_of(gpu::PassRecorder& recorder, const Counted& counted, const FragmentListSizes& sizes) {
  FragmentLists lists = lists_of(counted);
  lists.count = sizes.count;
  lists.batches = sizes.batches;
  lists.fragments = &recorder.buffer("fragments", lists.count * 16);
  lists.numbers = &recorder.buffer("fragment numbers", lists.count * 4);
  lists.addresses->set(gpu_types::ListAddresses{.fragments = lists.addresses->of(*lists.fragments),
                                                .numbers = lists.addresses->of(*lists.numbers),
                                                .ends = lists.addresses->of(*lists.ends),
                                                .bases = lists.addresses->of(*lists.bases)});
  return lists;
}

}  // namespace

gpu_types::ListAddresses FragmentLists::reads(gpu::AddressUses& pass) const {
  const auto address = [&](gpu::Buffer* buffer) { return buffer ? pass.reads(*buffer) : 0; };
  return {.fragments = address(fragments), .numbers = address(numbers), .ends = address(ends), .bases = address(bases)};
}

gpu_types::ListAddresses FragmentLists::writes(gpu::AddressUses& pass) const {
  const auto address = [&](gpu::Buffer* buffer) { return buffer ? pass.writes(*buffer) : 0; };
  return {.fragments = address(fragments), .numbers = address(numbers), .ends = address(ends), .bases = address(bases)};
}

bool lists_are_possible(const Frontend& frontend, std::uint64_t pixels) {
  // Sums over pixels and records are taken through bound ranges.
  return std::max(pixels, frontend.record_count()) * 4 <= frontend.device().info().max_storage_buffer_range;
}

CountedFragments count_fragment_lists(const FrontendFrame& frame, ListedMasks masks) {
  Frontend& frontend = frame.frontend;
  gpu::PassRecorder counting(frontend.device());
  frontend.record_setup(counting);
  const Counted counted = make_counted(counting, frame);
  record_counting(counting, frame, counted, lists_of(counted), "measure", masks);
  counting.run();
  const auto sums = counted.chunk_sums->as<glm::uvec4>();
  CountedFragments found;
  FragmentListSizes& sizes = found.sizes;
  sizes.masks = masks;
  sizes.count = sums[frontend.chunk_count()].x;
  sizes.triangles = sums[frontend.chunk_count()].y;
  sizes.kept = kept_fragments(frame, counted, sizes.count);
  const auto begins = counted.ends->as<std::uint32_t>().first(std::size_t{frame.width} * frame.height);
  // The device's sums are modulo 2^32; a single pixel's are right.
  for (std::size_t p = 0; p < begins.size(); ++p) {
    const auto next = p + 1 < begins.size() ? begins[p + 1] : static_cast<std::uint32_t>(sizes.count);
    found.total += next - begins[p];
    sizes.longest = std::max(sizes.longest, next - begins[p]);
  }
  sizes.batches = batches_of(frontend, counted);
  return found;
}

bool lists_pay(std::uint64_t total, std::uint32_t longest, std::uint64_t pixels, std::uint64_t triangles) {
  const std::uint64_t most = std::max(kMostFragmentsPerPixel * pixels, kMostFragmentsPerTriangle * triangles);
  return total <= std::clamp(most, kAnyFragments, kMostFragments) && longest <= kLongestList;
}

std::optional<FragmentListSizes> measure_fragment_lists(const FrontendFrame& frame, ListedMasks masks) {
  Frontend& frontend = frame.frontend;
  const std::uint64_t pixels = std::uint64_t{frame.width} * frame.height;
  if (!lists_are_possible(frontend, pixels)) return std::nullopt;
  CountedFragments found = count_fragment_lists(frame, masks);
  if (!lists_pay(found.total, found.sizes.longest, pixels, frontend.hull_count())) return std::nullopt;
  return std::move(found.sizes);
}

FragmentListSizes measure_visible_fragments(const FrontendFrame& frame) {
  gpu::PassRecorder counting(frame.frontend.device());
  frame.frontend.record_setup(counting);
  gpu::Image& visibility = record_visibility(counting, frame);
  const Counted counted = make_counted(counting, frame);
  record_visible_counting(counting, frame, visibility, counted, lists_of(counted), "measure");
  counting.run();
  FragmentListSizes sizes;
  sizes.masks = ListedMasks::visible;
  const glm::uvec4 total = counted.chunk_sums->as<glm::uvec4>()[frame.frontend.chunk_count()];
  sizes.count = total.x;
  sizes.kept = kept_fragments(frame, counted, sizes.count);
  sizes.triangles = total.y;
  sizes.batches = batches_of(frame.frontend, counted);
  return sizes;
}

FragmentLists record_visible_fragments(gpu::PassRecorder& recorder, const FrontendFrame& frame, gpu::Image& visibility,
                                       const FragmentListSizes& sizes, const std::string& name) {
  const Counted counted = make_counted(recorder, frame);
  record_visible_counting(recorder, frame, visibility, counted, lists_of(counted), name);
  FragmentLists lists = lists_of(recorder, counted, sizes);
  record_visible_pass(recorder, frame, visibility, lists, name, "STORE");
  return lists;
}

FragmentLists record_fragment_lists(gpu::PassRecorder& recorder, const FrontendFrame& frame,
                                    const FragmentListSizes& sizes, const std::string& name) {
  const Counted counted = make_counted(recorder, frame);
  record_counting(recorder, frame, counted, lists_of(counted), name, sizes.masks);
  FragmentLists lists = lists_of(recorder, counted, sizes);
  lists.parts = list_parts(sizes.longest);
  record_collection(recorder, frame, lists, name, sizes.masks, "STORE");
  if (lists.parts > 1) record_long_lists(recorder, frame, lists, name);
  return lists;
}

void record_listed_fragments(gpu::PassRecorder& recorder, const FrontendFrame& frame, const FragmentLists& lists,
                             const ListedPass& pass) {
  Frontend& frontend = frame.frontend;
  GpuScene& scene = frontend.scene();
  for (const FragmentLists::Batch& batch : lists.batches) {
    if (pass.alpha_only && !batch.alpha_test) continue;
    gpu::ComputePass compute;
    compute.addressed = pass.addressed;
    gpu_types::HullPush push = frontend.hull_push(compute, batch.material);
    push.first_fragment = static_cast<std::uint32_t>(batch.first);
    push.last_fragment = static_cast<std::uint32_t>(batch.last);
    compute.name = pass.name;
    compute.shader = pass.shader;
    compute.constants = frontend.constants();
    compute.constants.insert(compute.constants.end(), pass.constants.begin(), pass.constants.end());
    compute.bindings = pass.bindings;
    compute.bindings.push_back(gpu::uniform(scene.frame_constants));
    compute.bindings.push_back(gpu::writes(FRONTEND_SLOT_LISTS, *lists.addresses));
    compute.bindings.push_back(gpu::reads(FRAME_SLOT_UV_MAPPINGS, scene.uv_mappings));
    compute.bindings.push_back(gpu::reads(FRAME_SLOT_MATERIALS, scene.materials));
    compute.push = gpu::PushConstants(push);
    compute.material = scene.material_set(batch.material);
    compute.groups = grid_of(batch.last - batch.first);
    compute.fragments = batch.last - batch.first;
    recorder.compute(std::move(compute));
  }
}

}  // namespace subpixel::replay
