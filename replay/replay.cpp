#include "replay/replay.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <map>
#include <memory>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "replay/frame/banded_frame.hpp"
#include "replay/gpu/litmus.hpp"
#include "replay/host_clock.hpp"
#include "replay/inspection.hpp"
#include "replay/measure/flip.hpp"
#include "replay/measure/maps.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference.hpp"
#include "replay/reference/reference_cache.hpp"
#include "replay/results/limits.hpp"
#include "replay/scene/lights.hpp"
#include "replay/single_frame.hpp"
#include "replay/techniques/complete_technique.hpp"

namespace subpixel::replay {
namespace {

// Every door checks before it gets here; this one is for callers of the library.
void check_limits(const ReplayOptions& options) {
  kSamplesLimit.require(options.samples);
  kRepeatLimit.require(options.repeat);
  kReferenceSamplesLimit.require(options.reference_samples);
  if (options.width != 0) kWidthLimit.require(options.width);
  if (options.height != 0) kHeightLimit.require(options.height);
  if (options.point_lights) kPointLightsLimit.require(*options.point_lights);
  kMemoryLimit.require(options.memory_mib);
  kTechniquesLimit.require(options.techniques.size());
}

std::vector<TechniqueSetting> plan(const ReplayOptions& options) {
  check_limits(options);
  std::vector<TechniqueSetting> planned;
  for (const TechniqueRequest& request : options.techniques)
    planned.push_back(complete_technique(request, options.samples));
  return planned;
}

std::pair<std::uint32_t, std::uint32_t> require_frames(const ReplayOptions& options, std::size_t frames) {
  if (frames == 0) throw InputError("capture", "it has no frames", "frames");
  const auto wanted = frames_of(options, frames);
  if (!wanted)
    throw UsageError("frames",
                     fmt::format("{}-{} is not within 0-{}", options.frames->first, options.frames->second, frames - 1),
                     "--frames");
  return *wanted;
}

// Shading model and whether samples are tone-mapped: techniques that differ in them have different references.
using ReferenceKind = std::pair<ShadingModel, Resolve>;
struct Reference {
  ReferenceImage image;
  std::string file, linear_file;
  std::uint64_t invalid_pixels = 0;
};

ReferenceKind reference_kind(const TechniqueSetting& setting) {
  return {setting.parameters->shading, setting.parameters->resolve};
}

// What is to be replayed of the capture and what that takes its history from; the other frames are empty, so that
// numbers stay.
capture::Capture read_frames(const ReplayJob& job, const std::vector<TechniqueSetting>& planned) {
  const capture::CaptureFile file(job.capture);
  const auto [first, last] = require_frames(job.options, file.frame_count());
  std::uint32_t history = 0;
  for (const TechniqueSetting& setting : planned)
    if (const auto* temporal = dynamic_cast<const TemporalParameters*>(setting.parameters.get()))
      history = std::max(history, temporal->history);
  return load_frames(file, first - std::min(history, first), last, job.options.point_lights);
}

class Replay {
 public:
  Replay(const ReplayJob& job, const ReplayEvents& events, const ReplayInspection& inspection)
      : job_(job),
        options_(job.options),
        events_(events),
        inspection_(inspection),
        skip_(job.options.skip.begin(), job.options.skip.end()),
        planned_(plan(job.options)),
        capture_(read_frames(job, planned_)),
        device_(device_options(inspection)) {}

  Results run();

 private:
  void make_head();
  // Sets the device's budget.
  void require_room_for_references();
  void replay_frames(std::uint32_t first, std::uint32_t last);
  // The current frame's reference for a technique's shading model and resolve; null without references.
  std::shared_ptr<const Reference> reference_for(std::uint32_t frame, const TechniqueSetting& planned);
  // Options' `rounds` of times; their results have neither images nor errors.
  void time_rounds(std::uint32_t frame, const std::vector<std::size_t>& wanted);
  FrameResult unmeasured(std::uint32_t frame, std::size_t which) const;
  // Of a reference among the job's kinds, in the order of the techniques: files have the same names whatever is
  // skipped.
  std::size_t place_of(const ReferenceKind& kind) const;
  void run_technique(std::uint32_t frame, std::size_t which);
  // Draws a result that is there already once more, for the next frame's flicker is told from its image.
  void draw_again(std::uint32_t frame, std::size_t which);
  // `stem` is what the names of the result's files begin with.
  void inspect(BandedFrame& recorded, const FrameResult& result, const std::string& stem);
  // Errors, maps and files of a result, which lack nothing of the device: on another thread, while this one prepares
  // the next technique and lets it compile. One at a time, and never beside a timed run.
  struct Truths {
    std::shared_ptr<const Reference> now, before;  // `before`: of the frame before this one
  };
  void start_measuring(FrameResult result, FrameImages images, std::size_t which, std::string stem);
  void finish_measuring();
  void measure(FrameResult& result, FrameImages images, const Truths& truths, std::size_t which,
               const std::string& stem);
  bool skipped(std::uint32_t frame, std::size_t which) const;
  void progress(const std::string& stage, std::uint32_t done, std::uint32_t total, const std::string& detail) const {
    if (events_.progress) events_.progress(stage, done, total, detail);
  }
  // The part of the time outside of passes that runs from here on; returns the one that ends here.
  std::string now(std::string part) { return clock_.enter(std::move(part), device_.total_ms()); }
  std::string write_png(const std::string& name, const Image& image) const {
    write_file_atomically(job_.out_dir / name, encode_png(image));
    return name;
  }

  std::string write_exr(const std::string& name, const std::vector<std::uint8_t>& file) const {
    write_file_atomically(job_.out_dir / name, file);
    return name;
  }

  HostClock clock_{"load"};  // the first member: reading the capture and finding the device count
  const ReplayJob& job_;
  const ReplayOptions& options_;
  const ReplayEvents& events_;
  const ReplayInspection& inspection_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> skip_;  // a part of a divided replay skips nearly everything
  std::vector<TechniqueSetting> planned_;
  capture::Capture capture_;
  gpu::Device device_;
  std::optional<gpu::RenderDoc> render_doc_;
  std::unique_ptr<FrameScene> scene_;
  std::uint32_t width_ = 0, height_ = 0;
  ResultsHead head_;
  using References = std::map<ReferenceKind, std::shared_ptr<const Reference>>;
  References references_, references_before_;  // this frame's, the last's
  std::vector<Image> before_;                  // each technique's image of the frame before; the measuring thread's
  std::optional<std::uint32_t> frame_before_;
  Results results_;
  struct Measured {
    std::size_t which;
    std::future<FrameResult> result;
  };
  std::optional<Measured> measuring_;  // the last member: it ends before what it works on
};

void Replay::make_head() {
  const auto& first = capture_.frames.front();
  width_ = options_.width == 0 ? first.width : options_.width;
  height_ = options_.height == 0 ? first.height : options_.height;
  const auto limit = device_.info().max_image_dimension;
  if (width_ == 0 || height_ == 0 || width_ > limit || height_ > limit)
    throw DeviceError(
        "size", fmt::format("{}x{} is not within 1x1 and the device's {}x{}", width_, height_, limit, limit), "--size");
  head_.capture_hash = content_hash_hex(job_.capture);
  head_.capture_title = capture_.metadata.title;
  const auto& info = device_.info();
  head_.device = info.device;
  head_.driver = info.driver;
  head_.driver_version = info.driver_version;
  head_.cpu_model = info.cpu_model;
  head_.build = SUBPIXEL_VERSION;
  if (!device_.shaders().embedded()) head_.build += " with shaders of a folder";
  head_.date_utc = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  head_.width = width_;
  head_.height = height_;
  head_.repeat = options_.repeat;
  head_.reference_samples = options_.reference_samples;
  head_.every_light = options_.every_light;
  head_.memory_mib = options_.memory_mib;
}

bool Replay::skipped(std::uint32_t frame, std::size_t which) const {
  return skip_.contains({frame, static_cast<std::uint32_t>(which)});
}

Results Replay::run() {
  const auto [first, last] = require_frames(options_, capture_.frames.size());
  kResultsLimit.require((std::uint64_t{last} - first + 1) * planned_.size());
  std::vector<std::string_view> names;
  for (const TechniqueSetting& planned : planned_) names.push_back(planned.technique->name);
  render_doc_ = require_render_doc(inspection_, first, last, names);
  make_head();
  // Before the work that would be lost.
  if (!options_.point_lights)
    for (std::uint32_t frame = first; frame <= last; ++frame) require_few_lights(capture_.frames[frame], frame);
  std::error_code error;
  std::filesystem::create_directories(job_.out_dir, error);
  if (error) throw InputError("output folder", "can't be made: " + error.message(), job_.out_dir.string());
  progress("device", 0, 1, fmt::format("{}, {}, {}", head_.device, head_.driver_version, head_.cpu_model));
  progress("load", 0, 1, capture_.metadata.title);
  gpu::require_ordered_access(device_);
  require_room_for_references();
  scene_ = std::make_unique<FrameScene>(
      device_, std::move(capture_),
      SceneOptions{.point_lights = options_.point_lights, .every_light = options_.every_light},
      FrameChoice{first, width_, height_});
  head_.features = scene_->scene.features().names();
  head_.triangles_first_frame = scene_->scene.triangle_count();
  head_.point_lights = scene_->scene.constants().counts.x;
  if (events_.head) events_.head(head_);
  before_.resize(planned_.size());

  try {
    replay_frames(first, last);
  } catch (...) {
    finish_measuring();  // what was replayed before is not lost by what came after
    throw;
  }
  finish_measuring();
  now("");
  for (const FrameResult& result : results_.results) {
    head_.bands = std::max(head_.bands, result.memory.bands);
    head_.peak_bytes = std::max(head_.peak_bytes, result.memory.peak_bytes);
  }
  head_.wall_s = clock_.wall_s();
  head_.outside_gpu_s = head_.wall_s - device_.total_ms() * 1e-3;
  head_.outside_parts_s = clock_.seconds();
  if (events_.head) events_.head(head_);
  results_.head = head_;
  return std::move(results_);
}

void Replay::require_room_for_references() {
  if (options_.memory_mib == 0) return;
  const std::uint64_t budget = std::uint64_t{options_.memory_mib} << 20;
  device_.ledger().set_budget(budget);
  if (options_.reference_samples == 0) return;
  std::uint64_t needed = 0;
  for (const TechniqueSetting& planned : planned_)
    needed = std::max(needed, reference_bytes(options_.reference_samples, width_, height_,
                                              planned.parameters->resolve == Resolve::tone_mapped));
  if (needed > budget)
    throw UsageError("memory",
                     fmt::format("the reference can't be drawn in bands: at {}x{} it needs {} bytes, the budget is {}",
                                 width_, height_, needed, budget),
                     "--memory, --reference-samples");
}

void Replay::replay_frames(std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t frame = first; frame <= last; ++frame) {
    std::vector<std::size_t> wanted, again;
    for (std::size_t which = 0; which < planned_.size(); ++which) {
      if (!skipped(frame, which)) {
        wanted.push_back(which);
      } else if (options_.reference_samples > 0 && frame < last && !skipped(frame + 1, which)) {
        again.push_back(which);
      }
    }
    if (wanted.empty() && again.empty()) continue;
    now("scene");
    scene_->set_frame({frame, width_, height_});
    references_.clear();
    if (options_.rounds > 0) {
      time_rounds(frame, wanted);
      continue;
    }
    if (options_.references_only) {
      for (const std::size_t which : wanted) reference_for(frame, planned_[which]);
      continue;
    }
    for (const std::size_t which : again) draw_again(frame, which);
    for (const std::size_t which : wanted) {
      const auto total = static_cast<std::uint32_t>((last - first + 1) * planned_.size());
      const auto done = static_cast<std::uint32_t>((frame - first) * planned_.size() + which);
      progress("replay", done, total, fmt::format("frame {} {}", frame, planned_[which].technique->name));
      run_technique(frame, which);
    }
    references_before_ = std::move(references_);
    frame_before_ = frame;
  }
}

void Replay::time_rounds(std::uint32_t frame, const std::vector<std::size_t>& wanted) {
  for (std::uint32_t round = 0; round < options_.rounds; ++round) {
    progress("times", round, options_.rounds, fmt::format("frame {}", frame));
    for (const std::size_t which : wanted) {
      now("prepare");
      FrameResult result = unmeasured(frame, which);
      BandedFrame recorded(*scene_, planned_[which]);
      now("submit");
      result.ms = recorded.time(options_.repeat);
      result.memory = recorded.memory();
      result.counters = recorded.counters();
      now("report");
      if (events_.result) events_.result(static_cast<std::uint32_t>(which), result);
      results_.results.push_back(std::move(result));
    }
  }
}

FrameResult Replay::unmeasured(std::uint32_t frame, std::size_t which) const {
  const TechniqueSetting& planned = planned_[which];
  FrameResult result;
  result.frame = frame;
  result.technique = planned.technique->name;
  result.parameters = planned.values;
  result.samples = planned.parameters->samples;
  result.width = width_;
  result.height = height_;
  return result;
}

std::size_t Replay::place_of(const ReferenceKind& kind) const {
  std::vector<ReferenceKind> kinds;
  for (const TechniqueSetting& planned : planned_) {
    const ReferenceKind each = reference_kind(planned);
    if (each == kind) break;
    if (std::find(kinds.begin(), kinds.end(), each) == kinds.end()) kinds.push_back(each);
  }
  return kinds.size();
}

std::shared_ptr<const Reference> Replay::reference_for(std::uint32_t frame, const TechniqueSetting& planned) {
  if (options_.reference_samples == 0) return nullptr;
  const ReferenceKind kind = reference_kind(planned);
  const auto found = references_.find(kind);
  if (found != references_.end()) return found->second;
  ReferenceOptions wanted;
  wanted.samples = options_.reference_samples;
  wanted.shading_model = static_cast<std::uint32_t>(kind.first);
  wanted.tone_map_samples = kind.second == Resolve::tone_mapped;
  const auto report = [&](std::uint32_t done, std::uint32_t total) {
    progress("reference", done, total, fmt::format("frame {}", frame));
  };
  const std::string before = now("reference");
  CachedReference cached = cached_reference(device_, scene_->scene, head_.capture_hash, frame, wanted,
                                            ReferenceCache(job_.cache_dir), report);
  now("write");
  if (!cached.store_error.empty()) progress("reference", 1, 1, "not cached: " + cached.store_error);
  const std::string stem = fmt::format("frame{:04}_reference{}", frame, place_of(kind));
  Reference reference{std::move(cached.image), stem + ".png", stem + ".exr"};
  write_png(reference.file, reference.image.display);
  write_exr(reference.linear_file, encode_exr(reference.image.linear));
  now(before);
  reference.invalid_pixels = invalid_pixels(reference.image.linear);
  mark_not_finite(reference.image.linear, reference.image.display);
  return references_.emplace(kind, std::make_shared<const Reference>(std::move(reference))).first->second;
}

void Replay::run_technique(std::uint32_t frame, std::size_t which) {
  const TechniqueSetting& planned = planned_[which];
  now("prepare");
  FrameResult result = unmeasured(frame, which);
  const std::string stem = fmt::format("frame{:04}_{:02}_{}", frame, which, result.technique);
  FrameImages images;
  {  // before the reference, which shows the scene without jitter
    BandedFrame recorded(*scene_, planned);
    now("submit");
    result.ms = recorded.time(options_.repeat, [&] { finish_measuring(); });
    result.memory = recorded.memory();
    result.shading.fragments = recorded.fragments();
    result.counters = recorded.counters();
    now("measure");
    images = recorded.images();
    inspect(recorded, result, stem);
  }
  start_measuring(std::move(result), std::move(images), which, stem);
}

void Replay::start_measuring(FrameResult result, FrameImages images, std::size_t which, std::string stem) {
  Truths truths{reference_for(result.frame, planned_[which]), nullptr};
  const auto before = references_before_.find(reference_kind(planned_[which]));
  if (frame_before_ && *frame_before_ + 1 == result.frame && before != references_before_.end())
    truths.before = before->second;
  const auto work = [this, which](FrameResult measured, FrameImages of, const Truths& by, const std::string& names) {
    measure(measured, std::move(of), by, which, names);
    return measured;
  };
  measuring_ = {which, std::async(std::launch::async, work, std::move(result), std::move(images), std::move(truths),
                                  std::move(stem))};
}

void Replay::finish_measuring() {
  if (!measuring_) return;
  const std::string before = now("measure");
  Measured measured = *std::exchange(measuring_, std::nullopt);
  FrameResult result = measured.result.get();
  now("report");
  if (events_.result) events_.result(static_cast<std::uint32_t>(measured.which), result);
  results_.results.push_back(std::move(result));
  now(before);
}

void Replay::draw_again(std::uint32_t frame, std::size_t which) {
  finish_measuring();  // which may be of the same technique's last frame
  now("prepare");
  FrameImages images;
  {
    BandedFrame recorded(*scene_, planned_[which]);
    now("submit");
    recorded.run();
    now("measure");
    images = recorded.images();
  }
  mark_not_finite(images.radiance, images.display);
  reference_for(frame, planned_[which]);
  before_[which] = std::move(images.display);
}

void Replay::inspect(BandedFrame& recorded, const FrameResult& result, const std::string& stem) {
  if (!inspection_.capture || inspection_.capture->frame != result.frame ||
      inspection_.capture->technique != result.technique)
    return;
  const auto file = render_doc_->capture(job_.out_dir / stem, [&] { recorded.run(); });
  progress("capture", 1, 1, file.string());
}

void Replay::measure(FrameResult& result, FrameImages images, const Truths& truths, std::size_t which,
                     const std::string& stem) {
  const std::size_t pixels = images.executions.size();
  std::vector<std::uint32_t> counts(pixels);
  std::transform(images.executions.begin(), images.executions.end(), counts.begin(),
                 [](float count) { return static_cast<std::uint32_t>(std::max(count, 0.0f)); });
  const std::uint32_t most = *std::max_element(counts.begin(), counts.end());
  result.shading.histogram.assign(most + 1, 0);
  for (const std::uint32_t count : counts) {
    ++result.shading.histogram[count];
    result.shading.executions += count;
  }
  result.shading.group_executions = group_executions(counts, width_, height_);
  result.shading.per_pixel_mean = static_cast<double>(result.shading.executions) / static_cast<double>(pixels);
  result.counters["invalid_pixels"] = invalid_pixels(images.radiance) + invalid_pixels(images.display);

  result.images["image"] = write_png(stem + ".png", images.display);
  mark_not_finite(images.radiance, images.display);  // a tone curve may have made a colour of what is none
  result.images["hdr"] = write_exr(stem + ".exr", encode_exr(images.radiance));
  // A map comes twice: in colours for whoever looks at the file, in numbers for who reads it.
  const auto write_counts = [&](const std::string& name, std::string_view unit,
                                const std::vector<std::uint32_t>& values, std::uint32_t maximum) {
    const std::string map_stem = stem + "_" + name;
    result.images[name] = write_png(map_stem + ".png", colour_counts(width_, height_, values, maximum));
    result.images[name + "_values"] = write_exr(map_stem + ".exr", encode_counts_exr(width_, height_, values, unit));
  };
  const auto write_values = [&](const std::string& name, const Image& values) {
    result.images[name + "_values"] = write_exr(stem + "_" + name + ".exr", encode_values_exr(values, ""));
  };
  write_counts("shading", "executions", counts, result.samples);
  for (const auto& [name, values] : images.maps) {
    for (const MapDescription& map : planned_[which].technique->maps) {
      if (map.name != name) continue;
      const auto maximum = map.maximum > 0 ? static_cast<std::uint32_t>(map.maximum) : result.samples;
      write_counts(name, map.unit, values, maximum);
      std::uint64_t total = 0;
      for (const std::uint32_t value : values) total += value;
      result.counters[name] = total;
    }
  }
  if (!truths.now) return;
  const ReferenceImage& truth = truths.now->image;
  result.images["reference"] = truths.now->file;
  result.images["reference_hdr"] = truths.now->linear_file;
  if (truths.now->invalid_pixels > 0) result.counters["invalid_reference_pixels"] = truths.now->invalid_pixels;
  result.error.mse = mse(truth.display, images.display);
  result.error.psnr_db = psnr_db(result.error.mse);
  result.error.hdr_rel_mse = hdr_relative_mse(truth.linear, images.radiance);
  const FlipResult perceived = flip(truth.display, images.display);
  result.error.flip_mean = perceived.mean;
  result.error.flip_p99 = perceived.p99;
  result.error.flip_max = perceived.maximum;
  if (truths.before && before_[which].width != 0)
    result.error.flicker = flicker(truths.before->image.display, truth.display, before_[which], images.display);
  const Image error = error_map(truth.display, images.display);
  result.images["error"] = write_png(stem + "_error.png", colour_error(error));
  write_values("error", error);
  write_values("flip", perceived.map);
  before_[which] = std::move(images.display);
}

}  // namespace

Results run_replay(const ReplayJob& job, const ReplayEvents& events, const ReplayInspection& inspection) {
  return Replay(job, events, inspection).run();
}

}  // namespace subpixel::replay
