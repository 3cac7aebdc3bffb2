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
using replay::ParameterValues;
using replay::StreamingSetup;

Options options_of(const StreamingSetup& setup) {
  Options o;
  o.surfaces = setup.parameters.surfaces;
  o.samples = setup.samples;
  o.cos_normal_angle = static_cast<float>(std::cos(setup.parameters.normal_angle));
  o.merge_normals = setup.parameters.merge_normals;
  o.merge_depth = setup.parameters.merge_depth;
  o.merge_coverage = setup.parameters.merge_coverage;
  o.weight_by_coverage = setup.parameters.merge_weight == replay::StreamingWeight::coverage;
  o.depth_tested = setup.parameters.occlusion == replay::StreamingOcclusion::depth_test;
  o.discard_by_resolved = o.depth_tested || setup.parameters.discard == replay::StreamingDiscard::resolved;
  return o;
}

WordLayout layout_of(const StreamingSetup& setup) {
  const auto features = setup.scene.features();
  return {setup.samples, setup.parameters.surfaces, features.has(FEATURE_VARYING_ROUGHNESS),
          features.has(FEATURE_EMISSIVE)};
}

// All pixels that triangles' edges reach, so that no fragment is missing whose mask the technique takes from elsewhere.
PixelStreams streams_of(const StreamingSetup& setup, const WordLayout& layout) {
  const auto sizes = measure_fragment_lists(setup, replay::ListedMasks::later);
  if (!sizes) throw std::logic_error("the frame is too deep for lists");
  gpu::PassRecorder recorder(setup.frontend.device());
  setup.frontend.record_setup(recorder);
  const replay::FragmentLists lists = record_fragment_lists(recorder, setup, *sizes, "collect");
  gpu::Buffer& stream = recorder.buffer("stream", lists.count * sizeof(StreamTestFragment));
  replay::ListedPass pass;
  pass.name = "stream";
  pass.shader = "tests/streaming_fragments.comp";
  pass.constants = common_constants(setup);
  pass.constants.emplace_back(STREAM_CONSTANT_SURFACES, setup.parameters.surfaces);
  pass.constants.emplace_back(STREAM_CONSTANT_COS_NORMAL_ANGLE, 0);  // nothing merges in this pass
  pass.constants.emplace_back(STREAM_CONSTANT_OPTIONS,
                              setup.parameters.depth_space == replay::StreamingDepth::clip ? STREAM_CLIP_SPACE : 0u);
  pass.bindings = {gpu::writes(STREAM_TEST_SLOT_OF_FRAME, stream)};
  record_listed_fragments(recorder, setup, lists, pass);
  recorder.run();

  // They stand in submission order; a pixel's keep theirs.
  const auto fragments = stream.as<StreamTestFragment>().first(lists.count);
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
std::vector<std::uint32_t> state_of(const StreamingSetup& setup, const WordLayout& layout) {
  gpu::Device& device = setup.frontend.device();
  gpu::PassRecorder recorder(device);
  const replay::OrderedState state = record_streaming(recorder, setup);
  // Entries are what was in memory before: nobody clears them.
  if (state.entries) std::ranges::fill(state.entries->as<std::uint32_t>(), 0xffffffffu);
  recorder.run();
  const std::size_t pixels = std::size_t{setup.width} * setup.height, quads = layout.quads();
  std::vector<std::uint32_t> words(pixels * quads * 4);
  if (!state.entries) {
    std::ranges::copy(state.words->as<std::uint32_t>().first(words.size()), words.begin());
    return words;
  }
  // Depths and count word, then the surfaces out of tiles of 8x8 pixels.
  const std::size_t head_quads = layout.samples / 4 + 1;
  for (std::uint32_t q = 0; q < head_quads; ++q) {
    std::vector<std::byte> bytes;
    if (state.image) bytes = gpu::download(device, *state.image, q);
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t kept = q + 1 < head_quads ? 16 : 4;
      const void* from = state.image ? static_cast<const void*>(&bytes[i * 16])
                                     : &state.words->as<std::uint32_t>()[(i * head_quads + q) * 4];
      std::memcpy(&words[i * quads * 4 + q * 4], from, kept);
    }
  }
  const auto entries = state.entries->as<std::uint32_t>();
  const std::size_t list_words = layout.surfaces * layout.surface_words(), tiles_x = (setup.width + 7) / 8;
  for (std::size_t y = 0; y < setup.height; ++y)
    for (std::size_t x = 0; x < setup.width; ++x)
      for (std::size_t w = 0; w < list_words; ++w)
        words[(y * setup.width + x) * quads * 4 + layout.samples + 1 + w] =
            entries[((y / 8 * tiles_x + x / 8) * list_words + w) * 64 + y % 8 * 8 + x % 8];
  return words;
}

class ComparedScene {
 public:
  explicit ComparedScene(capture::Capture made) : scene_(replay::test_device(), std::move(made)) {}

  // Totals of one order of those that are compared.
  Totals expect_surfaces_of_paper(ParameterValues given, std::initializer_list<const char*> orders) {
    Totals totals;
    std::optional<PixelStreams> streams;
    for (const char* order : orders) {
      given["order"] = order;
      SCOPED_TRACE(nlohmann::json(given).dump());
      const replay::TechniqueSetting setting = replay::find_technique("streaming").with(given);
      replay::FrameOutputs outputs;
      const StreamingSetup setup(prepare_frame(scene_, setting, outputs));
      const WordLayout layout = layout_of(setup);
      if (!streams) streams = streams_of(setup, layout);
      const std::vector<std::uint32_t> words = state_of(setup, layout);
      EXPECT_EQ(outputs.counters.contains("listed_fragments"), setup.parameters.order == replay::FragmentOrder::lists);
      totals = expect_same_surfaces(options_of(setup), layout, *streams, words);
    }
    return totals;
  }

 private:
  replay::FrameScene scene_;
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
    ComparedScene scene(capture::generate(info.name, {1, info.width, info.height}));
    totals += scene.expect_surfaces_of_paper({}, {"lists", "one_pass"});
  }
  record(totals);
  EXPECT_GT(totals.pixels, 80000u);
  EXPECT_GT(totals.fragments, 120000u);
  EXPECT_GT(totals.several, 25000u);
  EXPECT_GT(totals.merges, 30000u);
  EXPECT_GT(totals.full, 5000u);
  EXPECT_GT(totals.dropped, 3000u);
  EXPECT_GT(totals.flags, 1400u);
}

TEST(StreamingFrames, LeaveThemInEveryScene) {
  Totals totals;
  for (const capture::SceneInfo& info : capture::list_scenes()) {
    if (info.group != capture::SceneGroup::scene) continue;
    SCOPED_TRACE(info.name);
    ComparedScene scene(capture::generate(info.name, {1, 160, 90, 1, 0.1}));
    totals += scene.expect_surfaces_of_paper({}, {"lists", "one_pass"});
  }
  record(totals);
  EXPECT_GT(totals.fragments, 200000u);
  EXPECT_GT(totals.merges, 40000u);
  EXPECT_GT(totals.dropped, 9000u);
}

TEST(StreamingFrames, AgreeForEveryNumberOfSamplesAndSurfaces) {
  // Two cases for each pair of numbers.
  constexpr std::array kSurfaces{1, 2, 4};
  std::size_t at = 0;
  Totals totals;
  for (const char* name :
       {"hard_subpixel", "hard_overflow", "hard_hairs", "hard_emissive_only", "hard_roughness", "hard_alpha_foliage"}) {
    SCOPED_TRACE(name);
    ComparedScene scene(capture::generate(name, {1, 32, 24}));
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
    ComparedScene scene(capture::generate(name, {1, 32, 24}));
    for (const ParameterValues& given : settings) totals += scene.expect_surfaces_of_paper(given, {"lists"});
  };
  compare("hard_subpixel", {{{"occlusion", "depth_test"}},
                            {{"depth_space", "clip"}},
                            {{"merge_weight", "coverage"}},
                            {{"discard", "resolved"}}});
  compare("hard_overflow", {{{"discard", "resolved"}}, {{"discard", "resolved"}, {"surfaces", 2}}});
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
