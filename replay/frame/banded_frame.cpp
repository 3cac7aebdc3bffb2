#include "replay/frame/banded_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "replay/frontend/count_image.hpp"
#include "replay/frontend/list_passes.hpp"
#include "replay/frontend/visibility.hpp"

namespace subpixel::replay {
namespace {

// While it lives nothing is refused, nor counted at the peak: the shadow map of another frame is the scene's, which the
// budget is not for.
class WithoutBudget {
 public:
  explicit WithoutBudget(gpu::MemoryLedger& ledger) : ledger_(ledger), budget_(ledger.budget()), peak_(ledger.peak()) {
    ledger_.set_budget(std::nullopt);
  }
  WithoutBudget(const WithoutBudget&) = delete;
  WithoutBudget& operator=(const WithoutBudget&) = delete;
  ~WithoutBudget() {
    ledger_.set_budget(budget_);
    ledger_.reset_peak(peak_);
  }

 private:
  gpu::MemoryLedger& ledger_;
  std::optional<std::uint64_t> budget_;
  std::uint64_t peak_;
};

// Rows of a band are multiples of this, which keeps blocks of pixels that shaders share together.
constexpr std::uint32_t kRows = 8;
// A frame has no more bands, since each goes through all triangles.
constexpr std::uint32_t kMostBands = 32;

std::uint32_t whole_rows(std::uint32_t rows) {
  return (rows + kRows - 1) / kRows * kRows;
}

// Room for RecordedFrame::count_fragments(), later on.
void require_counting(FrameScene& scene, std::uint32_t rows) {
  gpu::PassRecorder probe(scene.frontend.device());
  probe.image(count_image(scene.width(), rows));
}

// The drawing of one frame in bands.
class Bands {
 public:
  Bands(FrameScene& scene, const TechniqueSetting& setting, std::uint32_t current)
      : scene_(scene),
        setting_(setting),
        parameters_(*setting.parameters),
        temporal_(dynamic_cast<const TemporalParameters*>(setting.parameters.get())),
        ledger_(scene.frontend.device().ledger()),
        current_(current),
        height_(scene.height()),
        neighbours_(setting.technique->neighbour_rows(parameters_)),
        fewest_(std::min(height_, whole_rows((height_ + kMostBands - 1) / kMostBands))) {}

  void draw(std::uint32_t repeat, const std::function<void()>& after_cold);

  Runs runs;
  Memory memory;
  FrameImages images;
  std::map<std::string, std::uint64_t> counters, fragments;

 private:
  using History = std::unique_ptr<gpu::PassRecorder>;  // owns the images

  Band band(std::uint32_t first, std::uint32_t rows) const;
  // Goes through the frame in bands, as high as `work` can have them within the budget; returns how many they were.
  std::uint32_t each_band(const std::function<void(const Band&)>& work);
  [[noreturn]] void fail_of_budget(const gpu::OverBudget& over);
  [[noreturn]] void fail_of_bands(const std::string& why);
  // The peak of what `record` holds where there is no budget.
  std::uint64_t without_budget(const std::function<void()>& record);
  void choose();
  FrameSetup prepare(FrameOutputs& outputs);
  void move_to(std::uint32_t steps);
  void run_history();
  // The band's rows of what it leaves for the next frame go into images of the frame's size, which become the history.
  void make_history(const RecordedFrame& recorded);
  void keep_history(const RecordedFrame& recorded, const Band& drawn);
  void take_history();
  void draw_band(const Band& drawn, std::uint32_t repeat, const std::function<void()>& after_cold);
  void add_runs(const Runs& band);
  void add_images(const FrameImages& band, const Band& drawn);
  void add_counters(const FrameOutputs& band);
  void finish(std::uint32_t bands);
  FrameSetup whole_setup(FrameOutputs& outputs);

  FrameScene& scene_;
  const TechniqueSetting& setting_;
  const CommonParameters& parameters_;
  const TemporalParameters* temporal_;
  gpu::MemoryLedger& ledger_;
  const std::uint32_t current_, height_, neighbours_, fewest_;
  std::uint32_t rows_ = 0;          // that fit so far
  bool lists_ = false;              // of a technique that may go through them in order
  std::uint32_t longest_list_ = 0;  // of a pixel of the whole frame, when there are such lists
  std::optional<FrameMotion> motion_;
  History history_owner_, next_owner_;
  std::vector<gpu::Image*> history_, next_history_;
  std::uint64_t listed_ = 0, listed_triangles_ = 0;
  std::map<std::string, std::uint64_t> frame_counters_;
  std::map<std::string, std::vector<bool>> records_;
};

Band Bands::band(std::uint32_t first, std::uint32_t rows) const {
  const std::uint32_t above = std::min(first, whole_rows(neighbours_));
  const std::uint32_t end = std::min(height_, first + rows + neighbours_);
  return {first - above, end - (first - above), first, rows};
}

std::uint32_t Bands::each_band(const std::function<void(const Band&)>& work) {
  std::uint32_t count = 0;
  for (std::uint32_t first = 0; first < height_;) {
    const std::uint32_t rows = std::min(rows_, height_ - first);
    try {
      scene_.set_band(band(first, rows));
      work(scene_.band());
      first += rows;
      ++count;
    } catch (const gpu::OverBudget& over) {
      if (rows <= fewest_ || !ledger_.budget()) fail_of_budget(over);
      rows_ = std::max(fewest_, whole_rows(rows / 2));
    }
  }
  return count;
}

std::uint64_t Bands::without_budget(const std::function<void()>& record) {
  const std::uint64_t budget = ledger_.budget().value();
  ledger_.set_budget(std::nullopt);
  ledger_.reset_peak();
  try {
    record();
  } catch (...) {
    ledger_.set_budget(budget);
    throw;
  }
  ledger_.set_budget(budget);
  return ledger_.peak();
}

void Bands::fail_of_budget(const gpu::OverBudget& over) {
  const std::uint64_t least = without_budget([this] {
    rows_ = fewest_;
    choose();
    each_band([this](const Band& drawn) {
      const RecordedFrame recorded(scene_, setting_, [this](FrameOutputs& outputs) { return prepare(outputs); });
      make_history(recorded);
      if (temporal_ != nullptr && history_.empty()) {
        take_history();
        make_history(recorded);
      }
      require_counting(scene_, drawn.rows);
    });
  });
  throw UsageError("memory",
                   fmt::format("{} in bands of {} rows needs {} bytes, with {} the budget of {} is full",
                               setting_.technique->name, fewest_, least, over.name(), ledger_.budget().value()),
                   "--memory");
}

void Bands::fail_of_bands(const std::string& why) {
  scene_.set_band({0, height_, 0, height_});
  const std::uint64_t least = without_budget([this] {
    const RecordedFrame whole(scene_, setting_, [this](FrameOutputs& outputs) { return prepare(outputs); });
    require_counting(scene_, height_);
  });
  throw UsageError("memory",
                   fmt::format("{} can't be drawn in bands: {}; the whole frame needs {} bytes, the budget is {}",
                               setting_.technique->name, why, least, ledger_.budget().value()),
                   "--memory");
}

// What counters say of the front-end is of the whole frame, and so is what is chosen by numbers; it takes no memory by
// pixel.
void Bands::choose() {
  Frontend& frontend = scene_.frontend;
  const std::uint64_t pixels = std::uint64_t{scene_.width()} * height_;
  scene_.set_band({0, height_, 0, height_});
  frontend.prepare(parameters_.samples);
  frame_counters_["triangles"] = scene_.scene.triangle_count();
  frame_counters_["screen_triangles"] = frontend.hull_count();
  frame_counters_["clipped_triangles"] = frontend.clipped_count();
  frame_counters_["frontend_bytes"] = frontend.allocated_bytes();
  const std::uint64_t triangles = frontend.hull_count();
  const auto* const ordered = dynamic_cast<const OrderedParameters*>(&parameters_);
  lists_ = setting_.technique->lists && ordered != nullptr && ordered->order == FragmentOrder::lists &&
           lists_are_possible(frontend, pixels);
  bool small_lists = small_lists_pay(frontend, pixels);

  // By the same numbers as of a whole frame: choose_small_triangles(), measure_fragment_lists().
  scene_.set_small_triangles(SmallTriangles::as_hulls);
  if (small_lists && !runs_long_loops(frontend.device()))
    each_band([&](const Band&) {
      scene_.prepare(parameters_.samples);
      if (small_lists_too_long(scene_.frontend_frame(parameters_.alpha))) small_lists = false;
    });
  scene_.set_small_triangles(small_lists ? SmallTriangles::in_lists : SmallTriangles::as_hulls);
  if (!lists_) return;
  std::uint64_t total = 0;
  longest_list_ = 0;
  each_band([&](const Band&) {
    scene_.prepare(parameters_.samples);
    const CountedFragments found =
        count_fragment_lists(scene_.frontend_frame(parameters_.alpha), *setting_.technique->lists);
    total += found.total;
    longest_list_ = std::max(longest_list_, found.sizes.longest);
  });
  lists_ = lists_pay(total, longest_list_, pixels, triangles);
}

FrameSetup Bands::prepare(FrameOutputs& outputs) {
  scene_.prepare(parameters_.samples);
  FrameSetup setup(scene_.frontend_frame(parameters_.alpha), parameters_, outputs);
  if (lists_) {
    setup.lists = count_fragment_lists(setup, *setting_.technique->lists).sizes;
    // Passes are chosen by it: each band has those of the whole frame.
    setup.lists->longest = longest_list_;
  }
  if (setting_.technique->lists == ListedMasks::visible) setup.lists = scene_.visible_fragments(parameters_.alpha);
  setup.motion = motion_;
  setup.history = history_;
  return setup;
}

void Bands::make_history(const RecordedFrame& recorded) {
  const std::vector<gpu::Image*>& left = recorded.outputs().history;
  if (!next_history_.empty() || left.empty()) return;
  next_owner_ = std::make_unique<gpu::PassRecorder>(scene_.frontend.device());
  for (const gpu::Image* image : left) {
    gpu::ImageDescription description = image->description();
    description.height = height_;
    next_history_.push_back(&next_owner_->image(description));
  }
}

void Bands::take_history() {
  history_owner_ = std::move(next_owner_);
  history_ = std::exchange(next_history_, {});
}

void Bands::keep_history(const RecordedFrame& recorded, const Band& drawn) {
  make_history(recorded);
  const std::vector<gpu::Image*>& left = recorded.outputs().history;
  for (std::size_t i = 0; i < left.size(); ++i)
    gpu::copy_rows(scene_.frontend.device(), *left[i], drawn.kept_first - drawn.first, *next_history_[i],
                   drawn.kept_first, drawn.kept_rows);
}

void Bands::move_to(std::uint32_t steps) {
  const WithoutBudget moving(ledger_);
  motion_ = move_to_step(scene_, *temporal_, current_, steps, !history_.empty());
}

void Bands::run_history() {
  for (std::uint32_t steps = temporal_->history; steps > 0; --steps) {
    move_to(steps);
    each_band([&](const Band& drawn) {
      RecordedFrame recorded(scene_, setting_, [this](FrameOutputs& outputs) { return prepare(outputs); });
      recorded.run();
      keep_history(recorded, drawn);
    });
    take_history();
  }
  move_to(0);
}

void Bands::add_runs(const Runs& band) {
  runs.cold_ms += band.cold_ms;
  const auto add = [](auto& sums, const auto& values) {
    sums.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) sums[i] += values[i];
  };
  for (const Runs::Pass& pass : band.passes) {
    auto found = std::ranges::find(runs.passes, pass.name, &Runs::Pass::name);
    if (found == runs.passes.end()) found = runs.passes.insert(found, {pass.name, {}});
    add(found->ms, pass.ms);
  }
  add(runs.processor_ms, band.processor_ms);
  add(runs.instructions, band.instructions);
}

void Bands::add_images(const FrameImages& band, const Band& drawn) {
  const std::size_t width = scene_.width(), skipped = (drawn.kept_first - drawn.first) * width;
  const std::size_t to = drawn.kept_first * width, pixels = drawn.kept_rows * width, all = height_ * width;
  const auto put = [&](auto& whole, const auto& rows, std::size_t channels) {
    whole.resize(all * channels);
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(skipped * channels), pixels * channels,
                whole.begin() + static_cast<std::ptrdiff_t>(to * channels));
  };
  const auto put_image = [&](Image& whole, const Image& rows) {
    if (whole.width == 0) whole = Image(scene_.width(), height_, 3, rows.encoding);
    put(whole.pixels, rows.pixels, 3);
  };
  put_image(images.radiance, band.radiance);
  put_image(images.display, band.display);
  put(images.executions, band.executions, 1);
  for (const auto& [name, rows] : band.maps) put(images.maps[name], rows, 1);
}

void Bands::add_counters(const FrameOutputs& band) {
  for (const auto& [name, value] : band.counters) counters[name] += value;
  for (const auto& [name, value] : band.frame_counters) frame_counters_[name] = value;
  for (const auto& [name, numbers] : band.records) {
    std::vector<bool>& all = records_[name];
    all.resize(std::max(all.size(), numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i]) all[i] = true;
  }
}

void Bands::draw_band(const Band& drawn, std::uint32_t repeat, const std::function<void()>& after_cold) {
  RecordedFrame recorded(scene_, setting_, [this](FrameOutputs& outputs) { return prepare(outputs); });
  require_counting(scene_, drawn.rows);
  add_runs(recorded.runs(repeat, after_cold));
  add_images(recorded.images(), drawn);
  add_counters(recorded.outputs());
  if (recorded.setup().lists) {
    listed_ += recorded.setup().lists->kept;
    listed_triangles_ += recorded.setup().lists->triangles;
  }
  const Memory held = recorded.memory();
  memory.fitted_bytes = std::max(memory.fitted_bytes, held.fitted_bytes);
  memory.allocated_bytes = std::max(memory.allocated_bytes, held.allocated_bytes);
  for (const auto& [pass, count] : recorded.count_fragments()) fragments[pass] += count;
}

// What the technique's functions of a whole frame take, from what is known of the bands.
FrameSetup Bands::whole_setup(FrameOutputs& outputs) {
  FrameSetup setup({scene_.frontend, scene_.width(), height_, parameters_.alpha}, parameters_, outputs);
  if (lists_ || setting_.technique->lists == ListedMasks::visible) {
    setup.lists.emplace();
    setup.lists->masks = *setting_.technique->lists;
    setup.lists->count = setup.lists->kept = listed_;
    const auto seen = records_.find("visible_triangles");
    setup.lists->triangles =
        seen == records_.end() ? listed_triangles_ : static_cast<std::uint64_t>(std::ranges::count(seen->second, true));
  }
  return setup;
}

void Bands::finish(std::uint32_t bands) {
  for (const auto& [name, numbers] : records_)
    counters[name] = static_cast<std::uint64_t>(std::ranges::count(numbers, true));
  for (const auto& [name, value] : frame_counters_) counters[name] = value;
  FrameOutputs outputs;
  outputs.counters = counters;
  const FrameSetup whole = whole_setup(outputs);
  const std::string why = setting_.technique->whole_only(whole);
  if (!why.empty()) fail_of_bands(why);
  const double pixels = static_cast<double>(scene_.width()) * height_;
  for (const auto& entry : setting_.technique->layout(whole)) memory.paper_bytes_per_pixel += entry.bits_per_pixel / 8;
  memory.paper_bytes = static_cast<std::uint64_t>(memory.paper_bytes_per_pixel * pixels);
  memory.fitted_bytes_per_pixel = static_cast<double>(memory.fitted_bytes) / pixels;
  memory.bands = bands;
  memory.peak_bytes = ledger_.peak();
}

void Bands::draw(std::uint32_t repeat, const std::function<void()>& after_cold) {
  rows_ = std::max(fewest_, whole_rows(height_ / 2));
  if (temporal_ != nullptr) run_history();
  choose();
  FrameOutputs none;
  const std::string why = setting_.technique->whole_only(whole_setup(none));
  if (!why.empty()) fail_of_bands(why);
  ledger_.reset_peak();
  const std::uint32_t bands = each_band([&](const Band& drawn) { draw_band(drawn, repeat, after_cold); });
  finish(bands);
}

}  // namespace

BandedFrame::BandedFrame(FrameScene& scene, const TechniqueSetting& setting)
    : scene_(scene), setting_(setting), ledger_(scene.frontend.device().ledger()), current_(scene.frame()) {}

BandedFrame::~BandedFrame() {
  whole_.reset();
  scene_.set_jitter({0, 0});
}

Timing BandedFrame::time(std::uint32_t repeat, const std::function<void()>& after_cold) {
  draw(repeat, after_cold);
  return timing_of(runs_);
}

void BandedFrame::run() {
  draw(0, {});
}

void BandedFrame::draw(std::uint32_t repeat, const std::function<void()>& after_cold) {
  const bool in_bands = whole_ == nullptr && memory_.bands > 1;  // known from before
  if (in_bands || !draw_whole(repeat, after_cold)) draw_bands(repeat, after_cold);
}

bool BandedFrame::draw_whole(std::uint32_t repeat, const std::function<void()>& after_cold) {
  try {
    if (whole_ == nullptr) {
      whole_ = std::make_unique<RecordedFrame>(scene_, setting_);
      require_counting(scene_, scene_.height());
    }
  } catch (const gpu::OverBudget&) {
    whole_.reset();
    const WithoutBudget moving(ledger_);
    if (scene_.frame() != current_) scene_.set_frame({current_, scene_.width(), scene_.height()});
    scene_.set_jitter({0, 0});
    return false;
  }
  ledger_.reset_peak();
  runs_ = whole_->runs(repeat, after_cold);
  memory_ = whole_->memory();
  memory_.bands = 1;
  memory_.peak_bytes = ledger_.peak();
  counters_ = whole_->counters();
  return true;
}

void BandedFrame::draw_bands(std::uint32_t repeat, const std::function<void()>& after_cold) {
  Bands bands(scene_, setting_, current_);
  const auto restore = [this] {
    const WithoutBudget moving(ledger_);
    if (scene_.frame() != current_) scene_.set_frame({current_, scene_.width(), scene_.height()});
    scene_.set_jitter({0, 0});
    scene_.set_band({0, scene_.height(), 0, scene_.height()});
    scene_.set_small_triangles(std::nullopt);
  };
  try {
    bands.draw(repeat, after_cold);
  } catch (...) {
    restore();
    throw;
  }
  restore();
  runs_ = std::move(bands.runs);
  memory_ = bands.memory;
  images_ = std::move(bands.images);
  counters_ = std::move(bands.counters);
  fragments_ = std::move(bands.fragments);
}

Memory BandedFrame::memory() const {
  return memory_;
}

std::map<std::string, std::uint64_t> BandedFrame::counters() const {
  return counters_;
}

std::map<std::string, std::uint64_t> BandedFrame::fragments() {
  return whole_ != nullptr ? whole_->count_fragments() : fragments_;
}

FrameImages BandedFrame::images() {
  return whole_ != nullptr ? whole_->images() : std::move(images_);
}

}  // namespace subpixel::replay
