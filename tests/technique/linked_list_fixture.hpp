// A run of `linked_list` with its pool between guards, the pool read back block by block, and what the visibility image
// says about the fragments. The words of a block are written down here again from figures 3 and 4 of the publication.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include "replay/techniques/deferred.hpp"
#include "replay/techniques/linked_list.hpp"
#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {

struct ListLink {
  std::uint32_t block = 0, count = 0, sample = 0;
  explicit ListLink(std::uint32_t word) : block(word & 0x3ffffffu), count((word >> 26 & 7u) + 1), sample(word >> 29) {}
};

// Attributes in the order of the G-buffer sample that other techniques store.
struct BlockAttributes {
  std::uint32_t albedo_metallic = 0, normal = 0, roughness_occlusion = 0, emission = 0;
  bool operator==(const BlockAttributes&) const = default;
};

struct PoolWords {
  std::vector<std::uint32_t> words;
  bool metal = false, shared = true, emission = false;  // what the scene needs
  std::uint32_t roughness = 0;                          // 8 bits, of a scene that has one
  std::uint32_t pointers = 5, pair_words = 7;
  bool in_range(std::uint32_t block) const { return (block / 2 + 1) * std::size_t{pair_words} <= words.size(); }
  std::uint32_t field(std::uint32_t block, std::uint32_t at) const {
    return words.at(std::size_t{block / 2} * pair_words + at);
  }
  std::uint32_t pointer(std::uint32_t block) const { return field(block, pointers + block % 2); }
  BlockAttributes attributes(std::uint32_t block) const {
    const std::uint32_t i = block % 2, emitted = emission ? field(block, pointers + 2 + i) : 0;
    if (shared) {
      const std::uint32_t bytes = field(block, 4);
      return {field(block, i), field(block, 2 + i), (bytes >> (8 * i) & 255u) | (bytes >> (16 + 8 * i) & 255u) << 8,
              emitted};
    }
    constexpr std::uint32_t kFullOcclusion = 255u << 8;
    const std::uint32_t albedo = field(block, i);
    if (metal) return {albedo, field(block, 2 + i), roughness | kFullOcclusion, emitted};
    return {albedo & 0xffffffu, field(block, 2 + i), albedo >> 24 | kFullOcclusion, emitted};
  }
};

constexpr std::uint32_t kPoison = 0xdeadbeef;
constexpr std::size_t kGuardWords = 4096;

struct ListRun {
  TechniqueRun run;
  std::map<std::string, std::uint64_t> counters;
  PoolWords pool;
  std::uint64_t dynamic_blocks = 0;
  std::uint64_t damaged_guard_words = 0;
};

// One capture's scene, for any number of runs.
class ListScene {
 public:
  ListScene(capture::Capture recorded, std::uint32_t image_width, std::uint32_t image_height,
            gpu::Device& device = test_device())
      : width(image_width),
        height(image_height),
        device_(device),
        scene_(device, std::move(recorded), {}, {0, image_width, image_height}) {}

  // `given` without the pool: `dynamic_blocks` decides.
  ListRun run(const ParameterValues& given, std::uint64_t dynamic_blocks) {
    const TechniqueSetting setting = find_technique("linked_list").with(given);
    FrameOutputs outputs;
    const LinkedListSetup setup(prepare_frame(scene_, setting, outputs));
    const std::uint64_t bytes = linked_list_pool_bytes(setup, dynamic_blocks);
    gpu::Buffer memory(device_, "guarded blocks", bytes + 8 * kGuardWords);
    const auto words = memory.as<std::uint32_t>();
    std::fill(words.begin(), words.end(), kPoison);

    gpu::PassRecorder recorder(device_);
    record_linked_list(recorder, setup, {&memory, 4 * kGuardWords, dynamic_blocks});
    recorder.run();
    ListRun result;
    result.run = technique_run(download_images(device_, outputs));
    result.counters = outputs.counters;
    result.dynamic_blocks = dynamic_blocks;
    const std::size_t pool = bytes / 4;
    for (std::size_t i = 0; i < words.size(); ++i)
      if ((i < kGuardWords || i >= kGuardWords + pool) && words[i] != kPoison) ++result.damaged_guard_words;
    result.pool.words.assign(words.begin() + kGuardWords,
                             words.begin() + kGuardWords + static_cast<std::ptrdiff_t>(pool));
    PoolWords& pool_words = result.pool;
    pool_words.metal = scene_.scene.features().has(FEATURE_METAL);
    pool_words.shared = pool_words.metal && scene_.scene.features().has(FEATURE_VARYING_ROUGHNESS);
    pool_words.emission = scene_.scene.features().has(FEATURE_EMISSIVE);
    pool_words.roughness = static_cast<std::uint32_t>(std::nearbyint(scene_.scene.constants().tone.y * 255));
    pool_words.pointers = pool_words.shared ? 5 : 4;
    pool_words.pair_words = pool_words.pointers + 2 + (pool_words.emission ? 2 : 0);
    return result;
  }

  const std::uint32_t width, height;
  const capture::Capture& capture() const { return scene_.capture; }

 private:
  gpu::Device& device_;
  FrameScene scene_;
};

// A visible fragment of a pixel: the samples it shows in and its G-buffer sample.
struct VisibleFragment {
  std::uint32_t mask = 0;
  BlockAttributes attributes;
  std::uint32_t count() const { return static_cast<std::uint32_t>(std::popcount(mask)); }
};

// All pixels' fragments, by the passes of other techniques: visibility, and the G-buffer of full samples (not for 2).
class FragmentOracle {
 public:
  FragmentOracle(const ListScene& scene, std::uint32_t samples) : samples_(samples) {
    gpu::Device& device = test_device();
    FrontendRun run(device, scene.capture(), scene.width, scene.height, samples);
    gpu::Image* gbuffer = nullptr;
    if (samples > 2) {
      gbuffer = &gbuffer_image(run.recorder, run.setup());
      record_gbuffer(run.recorder, run.setup(), run.visible(), *gbuffer, 0);
    }
    run.run();
    std::vector<std::vector<BlockAttributes>> layers(samples);
    const bool narrow = narrow_samples(run.setup());
    if (narrow && run.scene.features().has(FEATURE_METAL)) throw std::logic_error("scene without stored roughness");
    for (std::uint32_t s = 0; s < samples && gbuffer; ++s) {
      const auto bytes = gpu::download(device, *gbuffer, s);
      std::vector<std::uint32_t> words(bytes.size() / sizeof(std::uint32_t));
      std::memcpy(words.data(), bytes.data(), bytes.size());
      for (std::size_t i = 0; i < words.size(); i += narrow ? 2 : 4)
        layers[s].push_back(narrow ? BlockAttributes{words[i] & 0xffffffu, words[i + 1], words[i] >> 24 | 0xff00u, 0}
                                   : BlockAttributes{words[i], words[i + 1], words[i + 2] & 0xffffu, words[i + 3]});
    }
    pixels_.resize(std::size_t{scene.width} * scene.height);
    for (std::size_t pixel = 0; pixel < pixels_.size(); ++pixel) {
      std::map<std::uint32_t, VisibleFragment> found;
      for (std::uint32_t s = 0; s < samples; ++s) {
        const std::uint32_t triangle = run.seen()[pixel * samples + s].triangle;
        if (triangle == SUBPIXEL_NO_TRIANGLE) continue;
        VisibleFragment& fragment = found[triangle];
        fragment.mask |= 1u << s;
        if (!gbuffer) continue;
        fragment.attributes = layers[s][pixel];
      }
      for (const auto& [triangle, fragment] : found) pixels_[pixel].push_back(fragment);
      std::ranges::sort(pixels_[pixel], {}, [](const auto& f) { return std::countr_zero(f.mask); });
    }
  }

  std::size_t pixels() const { return pixels_.size(); }
  std::uint32_t samples() const { return samples_; }
  // In the order of their lowest samples.
  const std::vector<VisibleFragment>& fragments(std::size_t pixel) const { return pixels_[pixel]; }
  std::uint32_t covered(std::size_t pixel) const {
    std::uint32_t mask = 0;
    for (const auto& fragment : pixels_[pixel]) mask |= fragment.mask;
    return mask;
  }
  // The fragment with the pixel's own block, or none.
  const VisibleFragment* own(std::size_t pixel, bool first_covered) const {
    if (pixels_[pixel].empty()) return nullptr;
    const VisibleFragment& first = pixels_[pixel].front();
    return first_covered || (first.mask & 1u) != 0 ? &first : nullptr;
  }
  std::uint64_t wanted_blocks(bool first_covered) const {
    std::uint64_t wanted = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) wanted += pixels_[i].size() - (own(i, first_covered) ? 1 : 0);
    return wanted;
  }

 private:
  std::uint32_t samples_;
  std::vector<std::vector<VisibleFragment>> pixels_;
};

// The fragments that got a block: (pixel, lowest sample). Blocks, their attributes unless lit values have replaced
// those, and links are checked on the way.
using StoredFragments = std::set<std::pair<std::size_t, std::uint32_t>>;

inline StoredFragments expect_consistent(const ListRun& run, const FragmentOracle& oracle, bool first_covered,
                                         bool in_order, bool attributes) {
  StoredFragments stored;
  std::set<std::uint32_t> blocks;
  const auto pixels = static_cast<std::uint32_t>(oracle.pixels());
  std::uint64_t overflowed = 0;
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
    const VisibleFragment* const own = oracle.own(pixel, first_covered);
    std::uint32_t listed = 0;
    int before = -1;
    std::uint32_t word = run.pool.pointer(pixel);
    for (; word != 0; word = run.pool.pointer(ListLink(word).block)) {
      const ListLink link(word);
      EXPECT_GE(link.block, pixels) << "pixel " << pixel;
      EXPECT_LT(link.block, pixels + run.dynamic_blocks) << "pixel " << pixel;
      if (link.block < pixels || link.block >= pixels + run.dynamic_blocks) return stored;
      EXPECT_TRUE(blocks.insert(link.block).second) << "block " << link.block << " is in two places";
      if (testing::Test::HasFailure()) return stored;
      const auto& fragments = oracle.fragments(pixel);
      const auto fragment =
          std::ranges::find_if(fragments, [&](const auto& f) { return (f.mask >> link.sample & 1u) != 0; });
      EXPECT_TRUE(fragment != fragments.end() && &*fragment != own) << "pixel " << pixel << " sample " << link.sample;
      if (fragment == fragments.end()) return stored;
      EXPECT_EQ(link.count, fragment->count()) << "pixel " << pixel << " sample " << link.sample;
      if (attributes && oracle.samples() > 2) {
        EXPECT_EQ(run.pool.attributes(link.block), fragment->attributes) << "pixel " << pixel;
      }
      const auto lowest = static_cast<std::uint32_t>(std::countr_zero(fragment->mask));
      EXPECT_TRUE(stored.emplace(pixel, lowest).second) << "pixel " << pixel << " has a fragment twice";
      if (in_order) {
        EXPECT_EQ(link.sample, lowest);
        EXPECT_GT(static_cast<int>(lowest), before);
      }
      before = static_cast<int>(lowest);
      listed += link.count;
    }
    if (own && oracle.samples() > 2) {
      EXPECT_EQ(run.pool.attributes(pixel), own->attributes) << "pixel " << pixel;
    }
    const std::uint32_t missing =
        static_cast<std::uint32_t>(std::popcount(oracle.covered(pixel))) - listed - (own ? own->count() : 0);
    overflowed += missing != 0 ? 1 : 0;
    EXPECT_EQ(run.run.maps.at("overflow")[pixel], missing) << "pixel " << pixel;
    EXPECT_EQ(run.run.maps.at("leaks")[pixel], own ? 0 : missing) << "pixel " << pixel;
    std::uint32_t held = own ? 1 : 0;
    for (const auto& fragment : oracle.fragments(pixel))
      held += stored.contains({pixel, static_cast<std::uint32_t>(std::countr_zero(fragment.mask))}) ? 1 : 0;
    EXPECT_EQ(run.run.maps.at("blocks")[pixel], held) << "pixel " << pixel;
    EXPECT_EQ(run.run.radiance[pixel].w, static_cast<float>(held)) << "pixel " << pixel;
    if (testing::Test::HasFailure()) return stored;
  }
  const std::uint64_t wanted = oracle.wanted_blocks(first_covered), used = std::min(wanted, run.dynamic_blocks);
  EXPECT_EQ(run.counters.at("blocks_wanted"), wanted);
  EXPECT_EQ(run.counters.at("blocks_used"), used);
  EXPECT_EQ(run.counters.at("overflowed_fragments"), wanted - used);
  EXPECT_EQ(stored.size(), used);
  EXPECT_EQ(overflowed != 0, wanted > used);
  EXPECT_EQ(run.damaged_guard_words, 0u);
  // The used blocks are the pool's first; no word of the pairs behind them was written.
  for (std::size_t i = (pixels + used + 1) / 2 * run.pool.pair_words; i < run.pool.words.size(); ++i)
    EXPECT_EQ(run.pool.words[i], kPoison) << "word " << i;
  return stored;
}

}  // namespace subpixel::replay
