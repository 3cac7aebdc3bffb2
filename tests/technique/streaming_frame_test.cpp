// The state that `streaming` leaves of whole frames against the transcription from the paper, fed with the frames' own
// fragments. Each of those is made by itself, by the functions that the technique calls; that their masks and depth
// planes are right is tested with the front-end.
#include <array>
#include <cmath>
#include <optional>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/streaming.hpp"
#include "shaders/include/shared_types.h"
#include "tests/technique/streaming_comparison.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::streaming_test {
namespace {

using gpu_types::StreamTestFragment;
using replay::FrameSetup;
using replay::ParameterValues;

Options options_of(const FrameSetup& setup) {
  Options o;
  o.surfaces = static_cast<std::uint32_t>(setup.number("surfaces"));
  o.samples = setup.samples;
  o.cos_normal_angle = static_cast<float>(std::cos(setup.number("normal_angle")));
  o.merge_normals = setup.parameters.at("merge_normals").get<bool>();
  o.merge_depth = setup.parameters.at("merge_depth").get<bool>();
  o.merge_coverage = setup.parameters.at("merge_coverage").get<bool>();
  o.weight_by_coverage = setup.choice("merge_weight") == "coverage";
  o.depth_tested = setup.choice("occlusion") == "depth_test";
  o.discard_by_resolved = o.depth_tested || setup.choice("discard") == "resolved";
  return o;
}

WordLayout layout_of(const FrameSetup& setup) {
  const auto features = setup.scene.features();
  return {setup.samples, static_cast<std::uint32_t>(setup.number("surfaces")), features.has(FEATURE_VARYING_ROUGHNESS),
          features.has(FEATURE_EMISSIVE)};
}

// All pixels that triangles' edges reach, so that no fragment is missing whose mask the technique takes from elsewhere.
PixelStreams streams_of(const FrameSetup& setup, const WordLayout& layout) {
  gpu::PassRecorder recorder(setup.frontend.device());
  setup.frontend.record_setup(recorder);
  const auto lists = record_fragment_lists(recorder, setup, "collect", replay::ListedMasks::later);
  if (!lists) throw std::logic_error("the frame is too deep for lists");
  gpu::Buffer& stream = recorder.buffer("stream", lists->count * sizeof(StreamTestFragment));
  replay::ListedPass pass;
  pass.name = "stream";
  pass.shader = "tests/streaming_fragments.comp";
  pass.constants = common_constants(setup);
  pass.constants.emplace_back(12, setup.choice("depth_space") == "clip" ? STREAM_CLIP_SPACE : 0u);
  pass.bindings = {gpu::writes(1, stream)};
  record_listed_fragments(recorder, setup, *lists, pass);
  recorder.run();

  // They stand in submission order; a pixel's keep theirs.
  const auto fragments = stream.as<StreamTestFragment>().first(lists->count);
  std::vector<std::vector<StreamFragment>> pixels(std::size_t{setup.width} * setup.height);
  for (const StreamTestFragment& f : fragments)
    pixels.at((f.more.z >> 16) * std::size_t{setup.width} + (f.more.z & 0xffffu))
        .push_back(stream_fragment(f, f.more.y, layout));
  PixelStreams streams;
  for (const auto& pixel : pixels) {
    streams.fragments.insert(streams.fragments.end(), pixel.begin(), pixel.end());
    streams.ends.push_back(streams.fragments.size());
  }
  return streams;
}

// The technique's own passes; pixels' words together.
std::vector<std::uint32_t> state_of(const FrameSetup& setup, const WordLayout& layout) {
  gpu::Device& device = setup.frontend.device();
  gpu::PassRecorder recorder(device);
  const replay::StreamingState state = record_streaming(recorder, setup);
  recorder.run();
  const std::size_t pixels = std::size_t{setup.width} * setup.height, quads = layout.quads();
  std::vector<std::uint32_t> words(pixels * quads * 4);
  if (state.words) {
    std::ranges::copy(state.words->as<std::uint32_t>().first(words.size()), words.begin());
    return words;
  }
  for (std::uint32_t q = 0; q < quads; ++q) {
    const auto bytes = gpu::download(device, *state.image, q);
    for (std::size_t i = 0; i < pixels; ++i) std::memcpy(&words[(i * quads + q) * 4], &bytes[i * 16], 16);
  }
  return words;
}

class FrameScene {
 public:
  explicit FrameScene(capture::Capture made)
      : capture_(std::move(made)), scene_(device_, capture_, {}), frontend_(device_, scene_) {
    scene_.set_frame(0, width(), height());
  }

  // Totals of one order of those that are compared.
  Totals expect_surfaces_of_paper(ParameterValues given, std::initializer_list<const char*> orders) {
    Totals totals;
    std::optional<PixelStreams> streams;
    for (const char* order : orders) {
      given["order"] = order;
      SCOPED_TRACE(nlohmann::json(given).dump());
      const ParameterValues parameters =
          check_parameters("streaming", replay::find_technique("streaming").parameters, given);
      const auto samples = parameters.at("samples").get<std::uint32_t>();
      if (frontend_.samples() != samples) frontend_.prepare(samples);
      replay::FrameOutputs outputs;
      const FrameSetup setup{scene_, frontend_, width(), height(), samples, parameters, outputs};
      const WordLayout layout = layout_of(setup);
      if (!streams) streams = streams_of(setup, layout);
      const std::vector<std::uint32_t> words = state_of(setup, layout);
      EXPECT_EQ(outputs.counters.contains("listed_fragments"), setup.choice("order") == "lists");
      totals = expect_same_surfaces(options_of(setup), layout, *streams, words);
    }
    return totals;
  }

 private:
  std::uint32_t width() const { return capture_.frames[0].width; }
  std::uint32_t height() const { return capture_.frames[0].height; }

  gpu::Device& device_ = replay::test_device();
  const capture::Capture capture_;
  replay::GpuScene scene_;
  replay::Frontend frontend_;
};

void record(const Totals& totals) {
  testing::Test::RecordProperty("pixels", std::to_string(totals.pixels));
  testing::Test::RecordProperty("fragments", std::to_string(totals.fragments));
}

TEST(StreamingFrames, LeaveTheSurfacesOfThePaperInEveryHardCase) {
  Totals totals;
  for (const capture::SceneInfo& info : capture::list_scenes()) {
    if (info.group != capture::SceneGroup::hard) continue;
    SCOPED_TRACE(info.name);
    FrameScene scene(capture::generate(info.name, {1, info.width, info.height}));
    totals += scene.expect_surfaces_of_paper({}, {"lists", "one_pass"});
  }
  record(totals);
  EXPECT_GT(totals.pixels, 80000u);
  EXPECT_GT(totals.fragments, 120000u);
  EXPECT_GT(totals.several, 25000u);
  EXPECT_GT(totals.merges, 30000u);
  EXPECT_GT(totals.full, 5000u);
  EXPECT_GT(totals.dropped, 7000u);
  EXPECT_GT(totals.flags, 2000u);
}

TEST(StreamingFrames, LeaveThemInEveryScene) {
  Totals totals;
  for (const capture::SceneInfo& info : capture::list_scenes()) {
    if (info.group != capture::SceneGroup::scene) continue;
    SCOPED_TRACE(info.name);
    FrameScene scene(capture::generate(info.name, {1, 160, 90, 1, 0.1}));
    totals += scene.expect_surfaces_of_paper({}, {"lists", "one_pass"});
  }
  record(totals);
  EXPECT_GT(totals.fragments, 200000u);
  EXPECT_GT(totals.merges, 40000u);
  EXPECT_GT(totals.dropped, 15000u);
}

TEST(StreamingFrames, AgreeForEveryNumberOfSamplesAndSurfaces) {
  // Two cases for each pair of numbers.
  constexpr std::array kSurfaces{1, 2, 4};
  std::size_t at = 0;
  Totals totals;
  for (const char* name :
       {"hard_subpixel", "hard_overflow", "hard_hairs", "hard_emissive_only", "hard_roughness", "hard_alpha_foliage"}) {
    SCOPED_TRACE(name);
    FrameScene scene(capture::generate(name, {1, 32, 24}));
    for (const int samples : {4, 16, 32})
      totals += scene.expect_surfaces_of_paper({{"samples", samples}, {"surfaces", kSurfaces.at(at++ % 3)}}, {"lists"});
    ++at;
  }
  record(totals);
  EXPECT_GT(totals.fragments, 50000u);
  EXPECT_GT(totals.merges, 10000u);
  EXPECT_GT(totals.dropped, 20000u);
}

TEST(StreamingFrames, AgreeWithOtherOptions) {
  Totals totals;
  const auto compare = [&](const char* name, const std::vector<ParameterValues>& settings) {
    SCOPED_TRACE(name);
    FrameScene scene(capture::generate(name, {1, 32, 24}));
    for (const ParameterValues& given : settings) totals += scene.expect_surfaces_of_paper(given, {"lists"});
  };
  compare("hard_subpixel", {{{"occlusion", "depth_test"}}, {{"depth_space", "clip"}}, {{"merge_weight", "coverage"}}});
  compare("streaming_normals", {{{"merge_normals", false}}, {{"normal_angle", 0.3}}});
  compare("streaming_depth", {{{"merge_depth", false}}, {{"occlusion", "depth_test"}, {"surfaces", 1}}});
  compare("streaming_coverage", {{{"merge_coverage", false}}});
  compare("hard_alpha_foliage", {{{"alpha", "test"}}, {{"alpha", "per_sample"}}});
  record(totals);
  EXPECT_GT(totals.fragments, 20000u);
  EXPECT_GT(totals.merges, 4000u);
  EXPECT_GT(totals.dropped, 1000u);
}

}  // namespace
}  // namespace subpixel::streaming_test
