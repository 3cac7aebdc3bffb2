// Aggregate G-buffer anti-aliasing: n visibility samples a pixel are grouped into at most c aggregates, a second
// geometry pass sums up the attributes of each, and each is shaded once, with lighting filtered over its normals and
// positions. Crassin, McGuire, Fatahalian, Lefohn, "Aggregate G-Buffer Anti-Aliasing", extended version, IEEE
// Transactions on Visualization and Computer Graphics 2016.
//
// What the paper's first pass stores for a sample is found through the visibility buffer: its depth, and by its
// triangle the face normal, which a compute pass works out and rounds once for each triangle.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "replay/techniques/agaa_story.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/agaa/agaa_interface.h"

namespace subpixel::replay {
namespace {

enum class Ndf { toksvig, sggx, lean };
enum class Roughness { mean, in_normal };
enum class Storage { fixed_point, floats };
enum class Shadow { footprint, samples };

struct AgaaParameters : CommonParameters {
  std::uint32_t aggregates = 2;
  double length = 0.1;  // world units
  double separation = 0.01;
  Ndf ndf = Ndf::toksvig;
  Roughness roughness = Roughness::mean;
  Storage storage = Storage::fixed_point;
  Shadow shadow = Shadow::footprint;
  std::uint32_t shadow_taps = 4;
  bool light_variance = false;
};
using Setup = SetupFor<AgaaParameters>;

bool sggx(const Setup& setup) {
  return setup.parameters.ndf == Ndf::sggx;
}
bool lean(const Setup& setup) {
  return setup.parameters.ndf == Ndf::lean;
}
bool lit_colours(const Setup& setup) {
  return setup.parameters.shadow == Shadow::samples && setup.scene.features().has(FEATURE_SHADOWS);
}
bool float_storage(const Setup& setup) {
  return setup.parameters.storage == Storage::floats;
}
bool roughness_in_normal(const Setup& setup) {
  return setup.parameters.roughness == Roughness::in_normal;
}

std::uint32_t agaa_options(const Setup& setup) {
  return (float_storage(setup) ? AGAA_FLOAT : 0u) | (sggx(setup) ? AGAA_SGGX : 0u) |
         (roughness_in_normal(setup) ? AGAA_ROUGHNESS_IN_NORMAL : 0u) | (lean(setup) ? AGAA_LEAN : 0u) |
         (lit_colours(setup) ? AGAA_LIT : 0u) | (setup.parameters.light_variance ? AGAA_LIGHT_VARIANCE : 0u);
}

std::uint32_t aggregate_words(const Setup& setup) {
  return AGAA_WORDS(setup.samples, setup.scene.features().bits, agaa_options(setup));
}

MemoryLayout layout(const Setup& setup) {
  const double n = setup.samples, c = setup.parameters.aggregates;
  const double membership =
      setup.parameters.aggregates > 2 ? 2 : setup.parameters.aggregates - 1.0;  // bits that name an aggregate
  const double mask = std::max(n, 8.0);
  // Section 4.3 and figure 7: 16 bytes an aggregate with a mask of 8 bits, 6 bytes a sample; section 3.3 for the rest.
  MemoryLayout memory{
      {"depth", 32 * n}, {"face normals", 16 * n}, {"membership", membership * n}, {"aggregates", (120 + mask) * c}};
  // What the options add, in whole words: six moments of 16 bits; two of 16 and three of 22 bits; two colours as above.
  if (sggx(setup)) memory.push_back({"normals' second moments", 96 * c});
  if (lean(setup)) memory.push_back({"slopes' moments", 128 * c});
  if (setup.parameters.shadow == Shadow::samples) memory.push_back({"sunlit colours", 64 * c});
  return memory;
}

gpu::Constants agaa_constants(const Setup& setup) {
  return {{AGAA_CONSTANT_AGGREGATES, setup.parameters.aggregates},
          {AGAA_CONSTANT_OPTIONS, agaa_options(setup)},
          {AGAA_CONSTANT_SHADOW_TAPS, setup.parameters.shadow_taps}};
}

// Of the frame's camera: positions relative to it keep their digits wherever it is.
struct ViewSpace {
  glm::mat4 from_clip{1};
  bool looks_along_z = false;  // +z, else -z
  float largest_polar = 0;     // radians from the axis towards the eye that a visible face normal can have
};

ViewSpace view_space(const Setup& setup) {
  const gpu_types::FrameConstants& frame = setup.scene.constants();
  const glm::dmat4 from_clip = glm::dmat4(frame.view) * glm::inverse(glm::dmat4(frame.view_projection));
  const auto at = [&](double x, double y, double depth) {
    const glm::dvec4 p = from_clip * glm::dvec4(x, y, depth, 1);
    return glm::dvec3(p) / p.w;
  };
  ViewSpace space;
  space.from_clip = glm::mat4(from_clip);
  space.looks_along_z = at(0, 0, 0.5).z > at(0, 0, 1).z;
  double field = 0;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      const glm::dvec3 along = glm::normalize(at(x, y, 0.5) - at(x, y, 1));
      field = std::max(field, std::acos(std::clamp(std::abs(along.z), 0.0, 1.0)));
    }
  space.largest_polar = static_cast<float>(std::min(std::numbers::pi, std::numbers::pi / 2 + field));
  return space;
}

// Logs of a story: how samples were told apart, what was added up.
struct StoryLogs {
  gpu::Buffer *definition = nullptr, *parts = nullptr;
};

StoryLogs make_story_logs(gpu::PassRecorder& recorder, const Setup& setup) {
  PixelStory& story = *setup.story;
  const StoryLogs logs{
      &story.record_log<gpu_types::AgaaDefinition>(recorder, "agaa definition", 1),
      &story.record_log<gpu_types::AgaaPart>(recorder, "agaa parts", setup.samples + setup.parameters.aggregates)};
  const AgaaForm form{setup.samples, setup.parameters.aggregates, aggregate_words(setup),
                      static_cast<float>(setup.parameters.separation)};
  const auto definition = [logs] { return PixelStory::log_of<gpu_types::AgaaDefinition>(*logs.definition); };
  const auto parts = [logs] { return PixelStory::log_of<gpu_types::AgaaPart>(*logs.parts); };
  story.tell("definition", [form, definition] { return agaa_definition(form, definition()); });
  story.tell("steps", [&story, form, definition, parts] { return agaa_steps(story, form, definition(), parts()); });
  story.tell("surfaces", [&story, form, parts] { return agaa_surfaces(story, form, parts()); });
  return logs;
}

// A rounded face normal for each triangle record, 4 bytes.
gpu::Buffer& record_faces(gpu::PassRecorder& recorder, const Setup& setup, const ViewSpace& space) {
  Frontend& frontend = setup.frontend;
  GpuScene& scene = setup.scene;
  gpu::Buffer& faces =
      recorder.buffer("face normals", frontend.records().bytes() / sizeof(gpu_types::TriangleRecord) * 4);
  constexpr std::uint32_t kRow = 1024;  // workgroups of 64 in x
  const auto groups = static_cast<std::uint32_t>((frontend.hull_triangles() + 63) / 64);
  gpu::ComputePass pass;
  pass.name = "face normals";
  pass.shader = "techniques/agaa/faces.comp";
  pass.constants = frontend.constants();
  pass.constants.emplace_back(AGAA_CONSTANT_OPTIONS, space.looks_along_z ? AGAA_DISTANCE_ALONG_VIEW : 0u);
  pass.bindings = {gpu::uniform(scene.frame_constants)};
  const gpu_types::AgaaFacesPush push{.hulls = pass.reads(frontend.hull_indices()),
                                      .records = pass.reads(frontend.records()),
                                      .positions = pass.reads(scene.positions),
                                      .indices = pass.reads(scene.indices),
                                      .instances = pass.reads(scene.instances),
                                      .faces = pass.writes(faces),
                                      .hull_triangles = static_cast<std::uint32_t>(frontend.hull_triangles()),
                                      .row = 64 * kRow,
                                      .largest_polar = space.largest_polar};
  pass.push = gpu::PushConstants(push);
  pass.groups = {std::min(groups, kRow), (groups + kRow - 1) / kRow, 1};
  recorder.compute(std::move(pass));
  return faces;
}

// Bits 0 and 1 of every sample's aggregate, one word of samples for each.
gpu::Image& record_definition(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& visibility,
                              const ViewSpace& space, const StoryLogs& logs) {
  gpu::Buffer& faces = record_faces(recorder, setup, space);
  const VkFormat format = setup.parameters.aggregates > 2 ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32_UINT;
  gpu::Image& membership = target_image(recorder, setup, "membership", format);
  gpu::RasterPass pass = fullscreen_pass(setup, "define", "techniques/agaa/define.frag");
  gpu::append(pass.pipeline.constants, agaa_constants(setup));
  pass.colours = {{membership}};
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  const gpu_types::AgaaDefinePush push{.view_from_clip = space.from_clip,
                                       .faces = pass.reads(faces),
                                       .inverse_length = static_cast<float>(1 / setup.parameters.length),
                                       .separation = static_cast<float>(setup.parameters.separation)};
  pass.push = gpu::PushConstants(push);
  if (logs.definition != nullptr)
    setup.story->record_again(recorder, pass, "techniques/agaa/define.frag:STORY",
                              gpu::writes(AGAA_SLOT_STORY, *logs.definition));
  recorder.raster(std::move(pass));
  return membership;
}

struct State {
  gpu::Buffer* sums = nullptr;
  gpu::AddressTable* table = nullptr;  // AgaaState
};

State make_state(gpu::PassRecorder& recorder, const Setup& setup) {
  State state;
  // Full-screen passes read for whole blocks of 4x4 pixels, beyond the image's borders too.
  constexpr std::uint64_t kBorderRows = 5;
  state.sums = &recorder.buffer("aggregates", (setup.height + kBorderRows) * setup.width * setup.parameters.aggregates *
                                                  aggregate_words(setup) * 4);
  gpu::Buffer& parts = recorder.buffer("fragments' parts", setup.lists.value().count * aggregate_words(setup) * 4);
  state.table = &recorder.address_table("aggregate state", sizeof(gpu_types::AgaaState));
  float largest = 0;
  for (const auto& material :
       setup.scene.materials.as<gpu_types::MaterialRecord>().first(setup.scene.constants().counts.y))
    for (int c = 0; c < 3; ++c) largest = std::max(largest, material.emissive_cutoff[c]);
  // Unlit surfaces emit colours.
  if (setup.scene.features().has(FEATURE_UNLIT)) largest = std::max(largest, 1.0f);
  state.table->set(gpu_types::AgaaState{
      .sums = state.table->of(*state.sums),
      .parts = state.table->of(parts),
      .largest_emission = largest > 0 && std::isfinite(largest) ? largest : 1.0f,
  });
  return state;
}

void record_generation(gpu::PassRecorder& recorder, const Setup& setup, const VisibleFragments& visible,
                       gpu::Image* membership, const State& state, const StoryLogs& logs) {
  ListedPass parts;
  parts.name = "generate";
  parts.shader = lit_colours(setup) ? "techniques/agaa/contribute.comp:LIT" : "techniques/agaa/contribute.comp:PLAIN";
  parts.constants = common_constants(setup);
  gpu::append(parts.constants, agaa_constants(setup));
  // With one aggregate the shader reads no membership, but declares it: the slot may not be empty.
  if (!membership)
    membership =
        &recorder.image({.name = "no membership", .format = VK_FORMAT_R32_UINT, .usage = VK_IMAGE_USAGE_SAMPLED_BIT});
  parts.bindings = {gpu::samples(FRAME_SLOT_VISIBILITY, *visible.visibility),
                    gpu::samples(AGAA_SLOT_MEMBERSHIP, *membership), gpu::writes(AGAA_SLOT_STATE, *state.table)};
  if (lit_colours(setup))
    for (const gpu::Binding& light : light_bindings(setup)) parts.bindings.push_back(light);
  record_listed_fragments(recorder, setup, visible.lists, parts);

  gpu::ComputePass add;
  add.name = "generate";
  add.shader = "techniques/agaa/add.comp";
  add.constants = setup.frontend.constants();
  gpu::append(add.constants, common_constants(setup));
  gpu::append(add.constants, agaa_constants(setup));
  add.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::writes(AGAA_SLOT_STATE, *state.table)};
  add.push = gpu::PushConstants(gpu_types::VisibleFragmentsPush{
      .lists = visible.lists.writes(add), .width = setup.width, .height = setup.height});
  add.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};
  recorder.compute(add);
  if (logs.parts == nullptr) return;
  add.name = "story";
  add.shader = "techniques/agaa/add.comp:STORY";
  add.bindings.push_back(gpu::writes(AGAA_SLOT_STORY, *logs.parts));
  recorder.compute(std::move(add));
}

void record_shading(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& visibility, const ViewSpace& space,
                    const State& state) {
  gpu::RasterPass pass = lighting_pass(setup, "shade", "techniques/agaa/shade.frag");
  gpu::append(pass.pipeline.constants, agaa_constants(setup));
  pass.colours = make_outputs(recorder, setup);
  pass.bindings.insert(pass.bindings.end(),
                       {gpu::samples(FRAME_SLOT_VISIBILITY, visibility), gpu::reads(AGAA_SLOT_STATE, *state.table)});
  pass.push = gpu::PushConstants(gpu_types::AgaaShadePush{space.from_clip});
  if (setup.story != nullptr) setup.story->record_lighting(recorder, pass, "techniques/agaa/shade.frag:STORY");
  recorder.raster(std::move(pass));
}

void record_maps(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& visibility, const ViewSpace& space,
                 const State& state) {
  gpu::RasterPass pass = lighting_pass(setup, "maps", "techniques/agaa/maps.frag");
  gpu::append(pass.pipeline.constants, agaa_constants(setup));
  pass.colours = make_maps(recorder, setup, {"aggregates", "normal_variance", "footprint"});
  pass.bindings.insert(pass.bindings.end(),
                       {gpu::samples(FRAME_SLOT_VISIBILITY, visibility), gpu::reads(AGAA_SLOT_STATE, *state.table)});
  pass.push = gpu::PushConstants(gpu_types::AgaaShadePush{space.from_clip});
  recorder.host(once(run_pass(recorder.device(), std::move(pass))));
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  gpu::Image& visibility = *visible.visibility;
  const ViewSpace space = view_space(setup);
  const StoryLogs logs = setup.story != nullptr ? make_story_logs(recorder, setup) : StoryLogs{};
  gpu::Image* const membership =
      setup.parameters.aggregates > 1 ? &record_definition(recorder, setup, visibility, space, logs) : nullptr;
  const State state = make_state(recorder, setup);
  record_generation(recorder, setup, visible, membership, state, logs);
  record_shading(recorder, setup, visibility, space, state);
  record_maps(recorder, setup, visibility, space, state);
}

}  // namespace

extern const Technique kAgaa;

const Technique kAgaa = TechniqueOf<AgaaParameters>{
    .name = "agaa",
    .title = "Aggregate G-buffer anti-aliasing",
    .paper = "Crassin, McGuire, Fatahalian, Lefohn: Aggregate G-Buffer Anti-Aliasing, extended version. IEEE TVCG 2016",
    .fields = {field::integer("aggregates", &AgaaParameters::aggregates, {1, AGAA_MAX_AGGREGATES},
                              "aggregates a pixel may have"),
               field::samples({4, 8, 16, 32}),
               field::number("length", &AgaaParameters::length, {1e-6, 1e6},
                             "largest scale of local detail: a distance as large parts samples as opposite normals do",
                             "world units"),
               field::number("separation", &AgaaParameters::separation, {0, 1e6},
                             "an aggregate is only made farther than this from the others, in the paper's distance"),
               field::choice(
                   "ndf", &AgaaParameters::ndf,
                   "distribution of normals: isotropic, by the mean's length, or anisotropic, by second moments of "
                   "normals or of their slopes",
                   {{"toksvig", Ndf::toksvig}, {"sggx", Ndf::sggx}, {"lean", Ndf::lean}}),
               field::choice("roughness", &AgaaParameters::roughness, "kept as a mean, or by shortening the normals",
                             {{"mean", Roughness::mean}, {"in_normal", Roughness::in_normal}}),
               field::choice("storage", &AgaaParameters::storage, "sums in the paper's fixed point, or in floats",
                             {{"fixed", Storage::fixed_point}, {"float", Storage::floats}}),
               field::choice("shadow", &AgaaParameters::shadow,
                             "of the sun: looked up over an aggregate's footprint, or for each sample before its "
                             "colours are added up",
                             {{"footprint", Shadow::footprint}, {"samples", Shadow::samples}}),
               field::integer("shadow_taps", &AgaaParameters::shadow_taps, field::one_of({1, 2, 4, 8}),
                              "points of an aggregate's footprint at which its shadow is looked up"),
               field::condition(
                   "light_variance", &AgaaParameters::light_variance,
                   "the spread of a light's directions over an aggregate widens its distribution of normals"),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {{"aggregates", "Aggregates", "aggregates", AGAA_MAX_AGGREGATES},
             {"normal_variance", "Variance of normals within aggregates", "thousandths", 1000},
             {"footprint", "Deviation of positions within an aggregate", "thousandths of a world unit", 1000}},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
