#include "replay/frame/run_frame.hpp"

#include <algorithm>
#include <cstring>

#include "base/work_counter.hpp"
#include "replay/frame/pixel_story.hpp"
#include "replay/measure/percentiles.hpp"

namespace subpixel::replay {
namespace {

template <typename T>
std::vector<T> texels_of(gpu::Device& device, gpu::Image& image) {
  const auto bytes = gpu::download(device, image);
  std::vector<T> texels(bytes.size() / sizeof(T));
  std::memcpy(texels.data(), bytes.data(), bytes.size());
  return texels;
}

// rgb of an RGBA32F image, and its alpha.
Image colour_of(gpu::Device& device, gpu::Image& image, Encoding encoding, std::vector<float>* alpha) {
  const std::vector<float> texels = texels_of<float>(device, image);
  Image colour(image.description().width, image.description().height, 3, encoding);
  if (alpha) alpha->resize(texels.size() / 4);
  for (std::size_t i = 0; i < texels.size() / 4; ++i) {
    std::copy_n(&texels[4 * i], 3, &colour.pixels[3 * i]);
    if (alpha) (*alpha)[i] = texels[4 * i + 3];
  }
  return colour;
}

}  // namespace

FrameSetup prepare_frame(FrameScene& scene, const TechniqueSetting& setting, FrameOutputs& outputs) {
  const CommonParameters& parameters = *setting.parameters;
  scene.prepare(parameters.samples);
  FrameSetup setup(scene.frontend_frame(parameters.alpha), parameters, outputs);
  const auto* const ordered = dynamic_cast<const OrderedParameters*>(&parameters);
  if (setting.technique->lists && ordered && ordered->order == FragmentOrder::lists)
    setup.lists = measure_fragment_lists(setup, *setting.technique->lists);
  if (setting.technique->lists == ListedMasks::visible) setup.lists = scene.visible_fragments(parameters.alpha);
  return setup;
}

FrameImages download_images(gpu::Device& device, const FrameOutputs& outputs) {
  FrameImages images;
  images.radiance = colour_of(device, *outputs.radiance, Encoding::linear, &images.executions);
  images.display = colour_of(device, *outputs.display, Encoding::display, nullptr);
  for (const auto& [name, image] : outputs.maps) images.maps[name] = texels_of<std::uint32_t>(device, *image);
  return images;
}

FrameMotion move_to_step(FrameScene& scene, const TemporalParameters& parameters, std::uint32_t current,
                         std::uint32_t steps, bool before) {
  const std::uint32_t frame = current - std::min(steps, current);
  const glm::dvec2 jitter = jitter_of(std::int64_t{current} - steps, parameters.jitter);
  if (scene.frame() != frame) scene.set_frame({frame, scene.width(), scene.height()});
  scene.set_jitter(jitter);
  const std::uint32_t frame_before = before ? current - std::min(steps + 1, current) : frame;
  return frame_motion(scene.capture, frame, frame_before, jitter, {scene.width(), scene.height()});
}

namespace {

FrameSetup prepare_step(FrameScene& scene, const TechniqueSetting& setting, std::uint32_t current, std::uint32_t steps,
                        const FrameOutputs* before, FrameOutputs& outputs) {
  const auto& parameters = dynamic_cast<const TemporalParameters&>(*setting.parameters);
  FrameMotion motion = move_to_step(scene, parameters, current, steps, before != nullptr);
  FrameSetup setup = prepare_frame(scene, setting, outputs);
  setup.motion = std::move(motion);
  if (before != nullptr) setup.history = before->history;
  return setup;
}

}  // namespace

std::unique_ptr<RecordedFrame::Past> RecordedFrame::run_history() {
  const auto* const temporal = dynamic_cast<const TemporalParameters*>(setting_.parameters.get());
  std::unique_ptr<Past> past;
  const std::uint32_t current = scene_.frame();
  for (std::uint32_t steps = temporal ? temporal->history : 0; steps > 0; --steps) {
    auto next = std::make_unique<Past>(scene_.frontend.device());
    const FrameSetup setup =
        prepare_step(scene_, setting_, current, steps, past ? &past->outputs : nullptr, next->outputs);
    setting_.technique->record(next->recorder, setup);
    next->recorder.run();
    past = std::move(next);
  }
  if (scene_.frame() != current) scene_.set_frame({current, scene_.width(), scene_.height()});
  return past;
}

FrameSetup RecordedFrame::prepare() {
  const auto* const temporal = dynamic_cast<const TemporalParameters*>(setting_.parameters.get());
  if (!temporal) return prepare_frame(scene_, setting_, outputs_);
  return prepare_step(scene_, setting_, scene_.frame(), 0, past_ ? &past_->outputs : nullptr, outputs_);
}

RecordedFrame::RecordedFrame(FrameScene& scene, const TechniqueSetting& setting, PixelStory* story)
    : scene_(scene), setting_(setting), past_(run_history()), setup_(prepare()), recorder_(scene.frontend.device()) {
  if (story != nullptr) story->find_fragments(setup_);
  setup_.story = story;
  setting_.technique->record(recorder_, setup_);
}

RecordedFrame::RecordedFrame(FrameScene& scene, const TechniqueSetting& setting,
                             const std::function<FrameSetup(FrameOutputs&)>& prepare)
    : scene_(scene),
      setting_(setting),
      owns_jitter_(false),
      setup_(prepare(outputs_)),
      recorder_(scene.frontend.device()) {
  setting_.technique->record(recorder_, setup_);
}

RecordedFrame::~RecordedFrame() {
  if (owns_jitter_) scene_.set_jitter({0, 0});
}

double RecordedFrame::run() {
  recorder_.run();
  double ms = 0;
  for (const auto& timing : recorder_.timings()) ms += timing.ms.back();
  return ms;
}

Runs RecordedFrame::runs(std::uint32_t repeat, const std::function<void()>& after_cold) {
  Runs result;
  result.cold_ms = run();
  if (after_cold) after_cold();
  if (repeat > 0) recorder_.clear_timings();
  for (std::uint32_t i = 0; i < repeat; ++i) {
    const WorkDone before = work_done();
    recorder_.run();
    const WorkDone after = work_done();
    result.processor_ms.push_back(after.processor_ms - before.processor_ms);
    result.instructions.push_back(after.instructions - before.instructions);
  }
  for (const auto& timing : recorder_.timings()) result.passes.push_back({timing.name, timing.ms});
  return result;
}

Timing timing_of(const Runs& runs) {
  Timing result;
  result.cold_ms = runs.cold_ms;
  if (!runs.processor_ms.empty()) {
    result.processor_ms = *std::ranges::min_element(runs.processor_ms);
    result.instructions = *std::ranges::min_element(runs.instructions);
  }
  std::vector<double> totals(std::max<std::size_t>(runs.processor_ms.size(), 1), 0.0);
  for (const Runs::Pass& pass : runs.passes) {
    result.passes.push_back({pass.name, median(pass.ms)});
    result.total_ms += result.passes.back().median_ms;
    for (std::size_t i = 0; i < totals.size(); ++i) totals[i] += pass.ms[i];
  }
  const auto [least, most] = std::minmax_element(totals.begin(), totals.end());
  result.spread_ms = *most - *least;
  result.least_ms = *least;
  return result;
}

Memory RecordedFrame::memory() const {
  Memory memory;
  const double pixels = static_cast<double>(scene_.width()) * scene_.height();
  for (const auto& entry : setting_.technique->layout(setup_)) memory.paper_bytes_per_pixel += entry.bits_per_pixel / 8;
  memory.paper_bytes = static_cast<std::uint64_t>(memory.paper_bytes_per_pixel * pixels);
  memory.allocated_bytes = recorder_.allocated_bytes();
  for (const gpu::Image* image : setup_.history) memory.allocated_bytes += image->bytes();
  memory.fitted_bytes = memory.allocated_bytes - outputs_.radiance->bytes() - outputs_.display->bytes();
  for (const auto& [name, map] : outputs_.maps) memory.fitted_bytes -= map->bytes();
  memory.fitted_bytes_per_pixel = static_cast<double>(memory.fitted_bytes) / pixels;
  return memory;
}

std::map<std::string, std::uint64_t> RecordedFrame::counters() const {
  std::map<std::string, std::uint64_t> counters = outputs_.counters;
  for (const auto& [name, value] : outputs_.frame_counters) counters[name] = value;
  counters["triangles"] = scene_.scene.triangle_count();
  counters["screen_triangles"] = scene_.frontend.hull_count();
  counters["clipped_triangles"] = scene_.frontend.clipped_count();
  counters["frontend_bytes"] = scene_.frontend.allocated_bytes();
  return counters;
}

std::map<std::string, std::uint64_t> RecordedFrame::count_fragments() {
  const Band& band = scene_.band();
  // Passes over lists go through all of their fragments, or, where all rows count, through some.
  const auto kept_of_lists = [&](std::uint64_t fragments) {
    if (!setup_.lists || setup_.lists->kept == setup_.lists->count) return fragments;
    return fragments / setup_.lists->count * setup_.lists->kept;
  };
  std::map<std::string, std::uint64_t> fragments;
  for (const auto& timing : recorder_.timings()) {
    std::uint64_t count = timing.screen_pixels / band.rows * band.kept_rows + kept_of_lists(timing.listed_fragments);
    if (timing.times_all > 0) count += timing.times_all * scene_.count_fragments();
    if (count > 0) fragments[timing.name] = count;
  }
  return fragments;
}

nlohmann::json RecordedFrame::story() {
  return setup_.story->document(recorder_.device(), setup_);
}

FrameRun run_frame(FrameScene& scene, const TechniqueSetting& setting, std::uint32_t repeat) {
  RecordedFrame recorded(scene, setting);
  FrameRun run;
  run.samples = setting.parameters->samples;
  run.ms = recorded.time(repeat);
  run.memory = recorded.memory();
  run.counters = recorded.counters();
  static_cast<FrameImages&>(run) = recorded.images();
  return run;
}

}  // namespace subpixel::replay
