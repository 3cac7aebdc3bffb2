// Deferred shading of one sample, then SMAA 1x over the finished image: edges, the areas that their patterns stand for,
// blending of neighbours.
// Jimenez, Echevarria, Sousa and Gutierrez 2012, "SMAA: Enhanced Subpixel Morphological Antialiasing". Where the text
// leaves a choice, it is that of the authors' public code (github.com/iryoku/smaa). The searches go over edges one by
// one, where the published ones read four at once through a bilinear filter and find the same ends.
#include <algorithm>
#include <array>

#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/smaa_areas.hpp"
#include "replay/techniques/smaa_story.hpp"
#include "shaders/techniques/smaa/smaa_interface.h"

namespace subpixel::replay {
namespace {

enum class SmaaQuality : std::uint32_t { low, medium, high, ultra };
enum class SmaaEdges : std::uint32_t { luma = SMAA_EDGES_OF_LUMA, colour = SMAA_EDGES_OF_COLOUR };
enum class SmaaBlend : std::uint32_t { displayed = SMAA_BLENDS_DISPLAYED, radiance = SMAA_BLENDS_RADIANCE };

constexpr int kOfQuality = -1;

struct SmaaParameters : CommonParameters {
  SmaaQuality quality = SmaaQuality::high;
  SmaaEdges edges = SmaaEdges::luma;
  double threshold = kOfQuality;
  double adaptation = 2;
  std::int32_t search_steps = kOfQuality, diagonal_steps = kOfQuality;
  double corner_rounding = kOfQuality;
  SmaaBlend blend = SmaaBlend::displayed;

  SmaaParameters() { samples = 1; }
};
using Setup = SetupFor<SmaaParameters>;

// The published presets. Those without corners round them all the way.
struct SmaaPreset {
  double threshold;
  std::int32_t search_steps, diagonal_steps;
  double corner_rounding;
};
constexpr std::array<SmaaPreset, 4> kPresets{
    {{0.15, 4, 0, 100}, {0.1, 8, 0, 100}, {0.1, 16, 8, 25}, {0.05, 32, 16, 25}}};

// That of the quality, but for what is given.
SmaaPreset preset_of(const SmaaParameters& parameters) {
  SmaaPreset preset = kPresets.at(static_cast<std::size_t>(parameters.quality));
  if (parameters.threshold >= 0) preset.threshold = parameters.threshold;
  if (parameters.search_steps >= 0) preset.search_steps = parameters.search_steps;
  if (parameters.diagonal_steps >= 0) preset.diagonal_steps = parameters.diagonal_steps;
  if (parameters.corner_rounding >= 0) preset.corner_rounding = parameters.corner_rounding;
  return preset;
}

MemoryLayout layout(const Setup& setup) {
  MemoryLayout memory = full_sample_layout(setup);
  memory.insert(memory.end(), {{"edges", 16}, {"blending weights", 32}});
  return memory;
}

// Logs of a story: of the pixel and the neighbours whose edges are its own, what passes make of them.
struct StoryLogs {
  gpu::Buffer *edges = nullptr, *weights = nullptr, *blend = nullptr;
};

StoryLogs make_story_logs(gpu::PassRecorder& recorder, const Setup& setup, const gpu_types::SmaaEdgesPush& push) {
  PixelStory& story = *setup.story;
  const StoryLogs logs{&story.record_log<gpu_types::SmaaEdgesStory>(recorder, "smaa edges", SMAA_STORY_PIXELS),
                       &story.record_log<gpu_types::SmaaWeightsStory>(recorder, "smaa weights", SMAA_STORY_PIXELS),
                       &story.record_log<gpu_types::SmaaBlendStory>(recorder, "smaa blend", 1)};
  story.tell("filter", [logs, push] {
    return smaa_filter(PixelStory::log_of<gpu_types::SmaaEdgesStory>(*logs.edges),
                       PixelStory::log_of<gpu_types::SmaaWeightsStory>(*logs.weights),
                       PixelStory::log_of<gpu_types::SmaaBlendStory>(*logs.blend).front(), push);
  });
  return logs;
}

// Tells of `extent` pixels in `log`, where there is one.
void record_told(gpu::PassRecorder& recorder, const Setup& setup, const gpu::RasterPass& pass, gpu::Buffer* log,
                 std::uint32_t extent) {
  if (log != nullptr)
    setup.story->record_again(recorder, pass, pass.pipeline.fragment + ":STORY", gpu::writes(SMAA_SLOT_STORY, *log),
                              {extent, extent});
}

gpu_types::SmaaEdgesPush edges_push(const Setup& setup, double threshold) {
  return {.threshold = static_cast<float>(threshold),
          .adaptation = static_cast<float>(setup.parameters.adaptation),
          .edges = static_cast<std::uint32_t>(setup.parameters.edges)};
}

gpu::Image& record_edges(gpu::PassRecorder& recorder, const Setup& setup, double threshold, const StoryLogs& logs) {
  gpu::Image& edges = target_image(recorder, setup, "edges", VK_FORMAT_R8_UINT);
  gpu::RasterPass pass = fullscreen_pass(setup, "edges", "techniques/smaa/edges.frag");
  pass.colours = {{edges}};
  pass.bindings = {gpu::samples(SMAA_SLOT_DISPLAYED, *setup.outputs.display)};
  pass.push = gpu::PushConstants(edges_push(setup, threshold));
  record_told(recorder, setup, pass, logs.edges, 2);
  recorder.raster(std::move(pass));
  return edges;
}

gpu::Image& record_weights(gpu::PassRecorder& recorder, const Setup& setup, const SmaaPreset& preset, gpu::Image& edges,
                           const StoryLogs& logs) {
  const std::vector<glm::vec2> table = smaa_area_table();
  gpu::Buffer& areas = recorder.buffer("smaa areas", table.size() * sizeof(glm::vec2));
  std::ranges::copy(table, areas.as<glm::vec2>().begin());
  gpu::Image& weights = target_image(recorder, setup, "blending weights", VK_FORMAT_R32_UINT);
  gpu::RasterPass pass = fullscreen_pass(setup, "weights", "techniques/smaa/weights.frag");
  pass.colours = {{weights}};
  pass.bindings = {gpu::samples(SMAA_SLOT_EDGES, edges), gpu::reads(SMAA_SLOT_AREAS, areas)};
  pass.push =
      gpu::PushConstants(gpu_types::SmaaWeightsPush{.search_steps = static_cast<std::uint32_t>(preset.search_steps),
                                                    .diagonal_steps = static_cast<std::uint32_t>(preset.diagonal_steps),
                                                    .rounding = static_cast<float>(preset.corner_rounding / 100)});
  record_told(recorder, setup, pass, logs.weights, 2);
  recorder.raster(std::move(pass));
  return weights;
}

void record_blend(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& values, gpu::Image& edges,
                  gpu::Image& weights, const StoryLogs& logs) {
  gpu::RasterPass pass = fullscreen_pass(setup, "blend", "techniques/smaa/blend.frag");
  pass.colours = make_outputs(recorder, setup);
  for (const gpu::Attachment& map : make_maps(recorder, setup, {"edges", "blended"})) pass.colours.push_back(map);
  for (const gpu::Binding& binding : {gpu::samples(SMAA_SLOT_VALUES, values), gpu::samples(SMAA_SLOT_EDGES, edges),
                                      gpu::samples(SMAA_SLOT_WEIGHTS, weights)})
    pass.bindings.push_back(binding);
  pass.push = gpu::PushConstants(gpu_types::SmaaBlendPush{.blend = static_cast<std::uint32_t>(setup.parameters.blend)});
  record_told(recorder, setup, pass, logs.blend, 1);
  recorder.raster(std::move(pass));
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const SmaaPreset preset = preset_of(setup.parameters);
  gpu::Image& sum = record_shaded_samples(recorder, setup);
  record_resolve(recorder, setup, sum);
  const StoryLogs logs =
      setup.story != nullptr ? make_story_logs(recorder, setup, edges_push(setup, preset.threshold)) : StoryLogs{};
  gpu::Image& edges = record_edges(recorder, setup, preset.threshold, logs);
  gpu::Image& weights = record_weights(recorder, setup, preset, edges, logs);
  record_blend(recorder, setup, sum, edges, weights, logs);
}

}  // namespace

extern const Technique kSmaa;

const Technique kSmaa = TechniqueOf<SmaaParameters>{
    .name = "smaa",
    .title = "No anti-aliasing, outlines of the image revectorised (SMAA 1x)",
    .paper =
        "Jimenez, Echevarria, Sousa, Gutierrez: SMAA: Enhanced Subpixel Morphological Antialiasing. "
        "Eurographics 2012",
    .fields = {field::samples({1}),
               field::choice("quality", &SmaaParameters::quality,
                             "published preset of threshold, search_steps, diagonal_steps and corner_rounding: "
                             "0.15 4 0 100, 0.1 8 0 100, 0.1 16 8 25, 0.05 32 16 25",
                             {{"low", SmaaQuality::low},
                              {"medium", SmaaQuality::medium},
                              {"high", SmaaQuality::high},
                              {"ultra", SmaaQuality::ultra}}),
               field::choice("edges", &SmaaParameters::edges, "what an edge is a step of",
                             {{"luma", SmaaEdges::luma}, {"colour", SmaaEdges::colour}}),
               field::number("threshold", &SmaaParameters::threshold, {kOfQuality, 1},
                             "least step of an edge in display values; below 0: the quality's"),
               field::number("adaptation", &SmaaParameters::adaptation, {1, 1000},
                             "an edge is lost beside one of more than so many times its contrast"),
               field::integer("search_steps", &SmaaParameters::search_steps, {kOfQuality, 112},
                              "how far level and upright edges are followed, two pixels a step; -1: the quality's"),
               field::integer("diagonal_steps", &SmaaParameters::diagonal_steps, {kOfQuality, 20},
                              "how far diagonals are followed; 0: they are not looked for; -1: the quality's",
                              "pixels"),
               field::number("corner_rounding", &SmaaParameters::corner_rounding, {kOfQuality, 100},
                             "how much of the blending sharp corners keep; below 0: the quality's", "%"),
               field::choice("blend", &SmaaParameters::blend,
                             "what is blended: values after the tone curve, as the authors do, or radiance",
                             {{"displayed", SmaaBlend::displayed}, {"radiance", SmaaBlend::radiance}}),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {{"edges", "Edges found", "edges", 2}, {"blended", "Share taken from neighbours", "1/255", 128}},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
    .neighbour_rows = [](const SmaaParameters& parameters) -> std::uint32_t {
      const SmaaPreset preset = preset_of(parameters);
      // Blending looks at a neighbour's weights, which follow edges, their crossings and corners, of values beyond.
      constexpr std::int32_t kBeside = 8;
      return static_cast<std::uint32_t>(2 * preset.search_steps + preset.diagonal_steps + kBeside);
    },
};

}  // namespace subpixel::replay
