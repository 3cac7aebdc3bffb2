// Temporal anti-aliasing: one jittered sample a pixel, and what earlier frames showed of the same surfaces.
// Karis 2014, "High-quality temporal supersampling" (jitter, front-most motion, clipping, weights by luma); Salvi 2016
// (bounds of variance); Yang, Liu and Salvi 2020, "A survey of temporal antialiasing techniques" (what there is to
// choose from). A frame's history is made for it alone (TemporalParameters).
#include <algorithm>

#include "base/error.hpp"
#include "replay/frame/pixel_story.hpp"
#include "replay/frontend/visibility.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/taa_story.hpp"
#include "shaders/techniques/taa/taa_interface.h"

namespace subpixel::replay {
namespace {

enum class TaaBounds : std::uint32_t {
  none = TAA_BOUNDS_NONE,
  clamp = TAA_BOUNDS_CLAMP,
  clip = TAA_BOUNDS_CLIP,
  variance = TAA_BOUNDS_VARIANCE
};
enum class TaaFilter : std::uint32_t { bilinear = TAA_BILINEAR, catmull_rom = TAA_CATMULL_ROM };

struct TaaParameters : TemporalParameters {
  double alpha_new = 0.1;
  bool progressive = true;
  TaaBounds bounds = TaaBounds::variance;
  double deviations = 1;
  TaaFilter filter = TaaFilter::catmull_rom;
  bool luma_weights = true;
  bool depth_test = true;
  double depth_tolerance = 0.1;

  TaaParameters() { samples = 1; }
};
using Setup = SetupFor<TaaParameters>;

MemoryLayout layout(const Setup& setup) {
  MemoryLayout memory = full_sample_layout(setup);
  memory.insert(memory.end(), {{"history colour", 64}, {"depth before", 32}});
  return memory;
}

void record_accumulate(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& visibility, gpu::Image& values) {
  const TaaParameters& parameters = setup.parameters;
  const FrameMotion& motion = setup.motion.value();
  gpu::Buffer& matrices = recorder.buffer("motion", motion.differences.size() * sizeof(glm::mat4));
  std::ranges::copy(motion.differences, matrices.as<glm::mat4>().begin());
  gpu::Image& history = target_image(recorder, setup, "history", VK_FORMAT_R32G32B32A32_SFLOAT);
  gpu::Image& depth = target_image(recorder, setup, "depth", VK_FORMAT_R32_SFLOAT);
  const bool first = setup.history.empty();

  gpu::RasterPass pass = fullscreen_pass(setup, "accumulate", "techniques/taa/accumulate.frag");
  pass.colours = make_outputs(recorder, setup);
  pass.colours.emplace_back(history);
  pass.colours.emplace_back(depth);
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  pass.bindings.push_back(gpu::samples(TAA_SLOT_VALUES, values));
  // The first frame reads none: its own values stand in the slots.
  pass.bindings.push_back(gpu::samples(TAA_SLOT_HISTORY, first ? values : *setup.history.at(0)));
  pass.bindings.push_back(gpu::samples(TAA_SLOT_DEPTH_BEFORE, first ? values : *setup.history.at(1)));
  pass.bindings.push_back(gpu::reads(TAA_SLOT_MOTION, matrices));
  const gpu_types::TaaPush push{.records = pass.reads(setup.frontend.records()),
                                .unjitter = motion.unjitter,
                                .distance_before = motion.distance_before,
                                .still = static_cast<std::uint32_t>(motion.differences.size() - 1),
                                .has_history = first ? 0u : 1u,
                                .bounds = static_cast<std::uint32_t>(parameters.bounds),
                                .reading = static_cast<std::uint32_t>(parameters.filter),
                                .compress = parameters.luma_weights ? 1u : 0u,
                                .progressive = parameters.progressive ? 1u : 0u,
                                .alpha = static_cast<float>(parameters.alpha_new),
                                .deviations = static_cast<float>(parameters.deviations),
                                .depth_test = parameters.depth_test ? 1u : 0u,
                                .depth_tolerance = static_cast<float>(parameters.depth_tolerance)};
  pass.push = gpu::PushConstants(push);
  if (setup.story != nullptr) {
    PixelStory& story = *setup.story;
    gpu::Buffer& log = story.record_log<gpu_types::TaaStory>(recorder, "taa pixel", 1);
    story.record_again(recorder, pass, "techniques/taa/accumulate.frag:STORY", gpu::writes(TAA_SLOT_STORY, log));
    story.tell("filter", [&story, &log, push] {
      return taa_filter(PixelStory::log_of<gpu_types::TaaStory>(log).front(), push, story.pixel());
    });
  }
  gpu::RasterPass maps = pass;
  maps.name = "maps";
  maps.pipeline.fragment = "techniques/taa/accumulate.frag:MAPS";
  maps.colours = make_maps(recorder, setup, {"rejected", "clipped"});
  recorder.host(once(run_pass(recorder.device(), std::move(maps))));
  recorder.raster(std::move(pass));
  setup.outputs.history = {&history, &depth};
  setup.outputs.frame_counters["unmatched_instances"] = motion.unmatched;
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  record_accumulate(recorder, setup, *visible.visibility, record_shaded_samples(recorder, setup, visible));
}

}  // namespace

extern const Technique kTaa;

const Technique kTaa = TechniqueOf<TaaParameters>{
    .name = "taa",
    .title = "One jittered sample, accumulated over frames (TAA)",
    .paper =
        "Karis: High-Quality Temporal Supersampling. SIGGRAPH 2014 courses; Yang, Liu, Salvi: A Survey of Temporal "
        "Antialiasing Techniques. Eurographics 2020",
    .fields = {field::samples({1}), field::history(), field::jitter(),
               field::number("alpha_new", &TaaParameters::alpha_new, {0, 1}, "share of the new frame in the image"),
               field::condition("progressive", &TaaParameters::progressive,
                                "the n-th frame since a pixel's history began has at least the share 1/n"),
               field::choice(
                   "bounds", &TaaParameters::bounds,
                   "what history is brought into: nothing; the box of the neighbourhood's colours, channel by "
                   "channel or towards its middle; mean and deviation of the neighbourhood",
                   {{"none", TaaBounds::none},
                    {"clamp", TaaBounds::clamp},
                    {"clip", TaaBounds::clip},
                    {"variance", TaaBounds::variance}}),
               field::number("deviations", &TaaParameters::deviations, {0, 10},
                             "half the width of the bounds of variance, standard deviations"),
               field::choice("filter", &TaaParameters::filter, "how history is read between its pixels",
                             {{"bilinear", TaaFilter::bilinear}, {"catmull_rom", TaaFilter::catmull_rom}}),
               field::condition("luma_weights", &TaaParameters::luma_weights,
                                "values are weighted by 1 / (1 + luma), so that bright samples don't flicker"),
               field::condition("depth_test", &TaaParameters::depth_test,
                                "history is rejected where something nearer hid what is seen now"),
               field::number("depth_tolerance", &TaaParameters::depth_tolerance, {0, 1},
                             "how much nearer that has to be, as a share of the distance"),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {{"rejected", "History rejected", "", 1}, {"clipped", "How far history was clipped", "1/255", 64}},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
    .neighbour_rows = [](const TaaParameters&) { return 1u; },  // of its history all rows are there
};

}  // namespace subpixel::replay
