// Stories of techniques that keep surfaces, aggregates or blocks, replayed by the transcriptions of their papers: the
// same decisions from what is told of samples and fragments, and the bits of the frame.
#include <algorithm>
#include <bit>
#include <map>
#include <numbers>
#include <set>

#include "replay/techniques/sbaa_story.hpp"
#include "tests/technique/agaa_transcription.hpp"
#include "tests/technique/pixel_story_fixture.hpp"
#include "tests/technique/sbaa_transcription.hpp"

namespace subpixel::replay {
namespace {

using Kinds = std::map<std::string, std::size_t>;

// The sum over what is lit, by weights, with the sky in `sky` samples.
glm::vec3 lit_sum(const json& told, int sky) {
  glm::vec3 sum(0);
  for (const json& execution : told["executions"])
    sum += static_cast<float>(execution["weight"].get<int>()) * vector(execution["value"]);
  return sum + vector(told["sky"]) * static_cast<float>(sky);
}

int covered_samples(const std::vector<int>& owner) {
  return static_cast<int>(std::ranges::count_if(owner, [](int one) { return one >= 0; }));
}

const json& fragment_of(const json& told, int number) {
  return told["fragments"].at(static_cast<std::size_t>(number));
}

// Each fragment that covers a sample has a step or is in a group, and no step says that a rule was broken.
void expect_all_told(const json& told, Kinds& kinds) {
  std::set<int> with_step;
  for (const json& step : told["steps"]) {
    ++kinds[step["kind"]];
    with_step.insert(step["fragment"].get<int>());
    EXPECT_EQ(step["what"].get<std::string>().find("against the parameters"), std::string::npos) << step["what"];
  }
  for (const json& fragment : told["fragments"])
    if (mask(fragment["covers"]) != 0) {
      EXPECT_TRUE(with_step.contains(fragment["number"].get<int>())) << fragment;
    }
}

// The samples as the analysis sees them. Of the first of each group alone it asks for normal and slope.
std::vector<sbaa_transcription::Sample> analysed_samples(const json& told, const std::vector<int>& owner) {
  std::vector<sbaa_transcription::Sample> samples(owner.size(), {glm::vec3(0), 0, 0, SUBPIXEL_NO_TRIANGLE});
  for (std::size_t s = 0; s < owner.size(); ++s) {
    if (owner[s] < 0) continue;
    const json& fragment = fragment_of(told, owner[s]);
    samples[s].triangle = fragment["triangle"]["record"].get<std::uint32_t>();
    samples[s].depth = fragment["depths"][s].get<float>();
  }
  for (const json& step : told["steps"]) {
    if (!step.contains("first")) continue;
    sbaa_transcription::Sample& first = samples.at(step["first"].get<std::size_t>());
    EXPECT_EQ(step["depth"].get<float>(), first.depth);
    first.normal = vector(step["normal"]);
    first.slope = step["slope"].get<float>();
  }
  return samples;
}

TEST(PixelStory, SurfacesReplayedByTheTranscriptionAreTheFrame) {
  Kinds kinds;
  const std::tuple<const char*, ParameterValues, sbaa_transcription::Options> cases[] = {
      {"grass", {{"surfaces", 2}}, {true, 2, std::numbers::pi / 4}},
      {"grass", {{"surfaces", 4}, {"samples", 16}, {"mode", "id"}}, {false, 4, std::numbers::pi / 4}},
      {"foliage", {{"surfaces", 1}, {"normal_angle", 1.2}}, {true, 1, 1.2}},
  };
  for (const auto& [scene, given, options] : cases) {
    each_story(scene, "sbaa", given, [&, &options = options](const json& told, glm::vec3 radiance) {
      const std::vector<int> owner = owners(told);
      expect_all_told(told, kinds);
      const std::vector<sbaa_transcription::Sample> samples = analysed_samples(told, owner);
      const auto found = sbaa_transcription::find_surfaces(samples, options);
      std::vector<std::uint64_t> masks(found.size(), 0);
      for (const json& step : told["steps"]) {
        if (!step.contains("first")) continue;
        ASSERT_LT(step["surface"].get<std::size_t>(), masks.size());
        EXPECT_EQ(step["kind"] == "stored", masks[step["surface"].get<std::size_t>()] == 0);
        masks[step["surface"].get<std::size_t>()] |= mask(step["samples"]);
      }
      for (std::size_t j = 0; j < found.size(); ++j) EXPECT_EQ(masks[j], found[j].mask()) << "surface " << j;

      const std::vector<std::uint32_t> kept = sbaa_transcription::analyse(samples, options);
      int shown = 0;
      for (std::size_t k = 0; k < told["surfaces"].size(); ++k) {
        const json& surface = told["surfaces"][k];
        ASSERT_EQ(mask(surface["covers"]), kept[k]);
        EXPECT_EQ(told["executions"][k]["samples"], surface["covers"]);
        EXPECT_EQ(surface["weight"], std::popcount(kept[k]));
        EXPECT_EQ(told["executions"][k]["weight"], surface["weight"]);
        const int first = owner[static_cast<std::size_t>(std::countr_zero(kept[k]))];
        EXPECT_EQ(surface["surface"]["words"], fragment_of(told, first)["surface"]["words"]);
        float nearest = 0, farthest = 1;
        for (std::size_t s = 0; s < samples.size(); ++s) {
          if ((kept[k] >> s & 1u) == 0) continue;
          nearest = std::max(nearest, samples[s].depth);
          farthest = std::min(farthest, samples[s].depth);
        }
        EXPECT_EQ(surface["nearest"].get<float>(), nearest);
        EXPECT_EQ(surface["farthest"].get<float>(), farthest);
        shown += std::popcount(kept[k]);
      }
      for (std::size_t k = told["surfaces"].size(); k < kept.size(); ++k) EXPECT_EQ(kept[k], 0u);
      const int n = static_cast<int>(owner.size()), sky = n - covered_samples(owner);
      const glm::vec3 sum = lit_sum(told, sky) * (static_cast<float>(n) / static_cast<float>(shown + sky));
      EXPECT_EQ(sum / static_cast<float>(n), radiance);
    });
  }
  for (const char* kind : {"stored", "merged", "same hash", "kept", "dropped", "hidden", "transparent"})
    EXPECT_GT(kinds[kind], 0u) << kind;
}

// As of `streaming` in pixel_story_test.cpp.
TEST(PixelStory, SurfacesThatTheParametersForbidAreSaidToBeAgainstThem) {
  FrameScene scene(test_device(), story_capture("grass"), {}, {0, kWidth, kHeight});
  PixelStory story({29, 20});
  const RecordedFrame recorded(scene, find_technique("sbaa").with({}), &story);
  const auto merge = [&](glm::vec4 compared) {
    gpu_types::SbaaStep step{};
    step.head = {1, 0, 0, 1};
    step.face.w = 0.5f;
    step.depth.x = 2;  // 1.5 to 2.5
    step.compared[0] = compared;
    const json told = sbaa_steps(story, {8, 4, true, 0.5f}, {&step, 1}, {});
    for (const json& one : told)
      if (one.contains("first")) return one["what"].get<std::string>();
    return std::string();
  };
  EXPECT_EQ(merge({0.75, 2, 3, 0}).find("against the parameters"), std::string::npos);
  EXPECT_NE(merge({0.75, 2, 3, 0}).find("merged into surface 0"), std::string::npos);
  EXPECT_NE(merge({0.25, 2, 3, 0}).find("against the parameters: cosine of normals 0.2500, not above 0.5000"),
            std::string::npos);
  EXPECT_NE(merge({0.75, 3, 4, 0}).find("against the parameters: depths 3 to 4 apart from its 1.5 to 2.5"),
            std::string::npos);
}

// The seeds and each sample's aggregate, by the paper's algorithm from the positions and normals that are told.
void expect_clustered(const json& definition, std::uint64_t covered, std::uint32_t most) {
  std::vector<agaa_transcription::Given> samples;
  for (const json& sample : definition["samples"])
    samples.push_back({vector(sample["position"]), vector(sample["normal"])});
  ASSERT_EQ(mask(definition["covered"]), covered);
  const auto expected = agaa_transcription::paper_aggregates(samples, static_cast<std::uint32_t>(covered), most, 0.01f);
  EXPECT_EQ(definition["seeds"].get<std::vector<std::size_t>>(), expected.seeds);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const json& sample = definition["samples"][s];
    ASSERT_EQ(sample["aggregate"].is_null(), !expected.of[s].has_value());
    if (expected.of[s]) {
      EXPECT_EQ(sample["aggregate"], *expected.of[s]) << "sample " << s;
    }
    for (std::size_t a = 0; a < expected.seeds.size(); ++a)
      EXPECT_EQ(sample["from_seeds"][a].get<float>(),
                agaa_transcription::distance(samples[s], samples[expected.seeds[a]]));
  }
}

TEST(PixelStory, AggregatesReplayedByTheTranscriptionAreTheFrame) {
  Kinds kinds;
  std::size_t alone = 0;
  for (const auto& [scene, aggregates, samples] : {std::tuple{"grass", 2, 8}, {"grass", 4, 16}, {"foliage", 1, 8}}) {
    const ParameterValues given{{"aggregates", aggregates}, {"samples", samples}};
    each_story(scene, "agaa", given, [&, aggregates = aggregates](const json& told, glm::vec3 radiance) {
      const std::vector<int> owner = owners(told);
      expect_all_told(told, kinds);
      std::uint64_t covered = 0;
      for (std::size_t s = 0; s < owner.size(); ++s) covered |= std::uint64_t{owner[s] >= 0} << s;
      const json definition = told.value("definition", json());
      const std::set<int> visible(owner.begin(), owner.end());
      ASSERT_EQ(definition.is_null(), visible.size() - (visible.contains(-1) ? 1 : 0) < 2 || aggregates == 1);
      alone += definition.is_null();
      if (!definition.is_null()) expect_clustered(definition, covered, static_cast<std::uint32_t>(aggregates));

      // Words of fixed point are added up as whole numbers.
      std::map<int, std::vector<std::uint32_t>> sums;
      std::map<int, std::uint64_t> masks;
      int before = -1;
      for (const json& step : told["steps"]) {
        if (step["kind"] != "added") continue;
        const int fragment = step["fragment"].get<int>(), slot = step["slot"].get<int>();
        EXPECT_LT(before, fragment) << "not in submission order";
        before = fragment;
        std::uint64_t own = 0;
        for (std::size_t s = 0; s < owner.size(); ++s) own |= std::uint64_t{owner[s] == fragment} << s;
        ASSERT_EQ(mask(step["samples"]), own);
        ASSERT_EQ(step["weight"], std::popcount(own));
        const auto first = static_cast<std::size_t>(std::countr_zero(own));
        if (!definition.is_null()) {
          EXPECT_EQ(slot, definition["samples"][first]["aggregate"]);
        }
        const json& words = step["adds"]["words"];
        sums[slot].resize(words.size());
        for (std::size_t i = 0; i < words.size(); ++i) sums[slot][i] += words[i].get<std::uint32_t>();
        masks[slot] |= own;
      }
      ASSERT_EQ(told["surfaces"].size(), sums.size());
      ASSERT_EQ(told["executions"].size(), sums.size());
      for (std::size_t k = 0; k < sums.size(); ++k) {
        const json& aggregate = told["surfaces"][k];
        const int slot = aggregate["slot"].get<int>();
        EXPECT_EQ(aggregate["surface"]["words"].get<std::vector<std::uint32_t>>(), sums[slot]);
        EXPECT_EQ(mask(aggregate["covers"]), masks[slot]);
        EXPECT_EQ(told["executions"][k]["of"], slot);
        EXPECT_EQ(told["executions"][k]["samples"], aggregate["covers"]);
        EXPECT_EQ(told["executions"][k]["weight"], aggregate["weight"]);
      }
      const int n = static_cast<int>(owner.size());
      EXPECT_EQ(lit_sum(told, n - covered_samples(owner)) / static_cast<float>(n), radiance);
    });
  }
  for (const char* kind : {"seed", "added", "hidden", "transparent"}) EXPECT_GT(kinds[kind], 0u) << kind;
  EXPECT_GT(alone, 0u);
}

struct ListCase {
  const char* scene;
  ParameterValues given;
  bool first_covered = false;
};

// Figures 3 and 4 of Fridvalszky and Toth 2020: a block of its own for the fragment of the pixel's chosen sample, one
// of the pool for each other; those without one are as if they were that of the pixel's own.
TEST(PixelStory, BlocksReplayedAreTheFrame) {
  Kinds kinds;
  std::size_t leaks = 0;
  const ListCase cases[] = {
      {"grass", {}},
      {"grass", {{"pool", 0.4}, {"lighting", "lists"}}},
      {"grass", {{"pool", 0.2}, {"allocation", "tiles"}, {"samples", 4}}},
      {"foliage", {{"pool", 0.3}, {"first_block", "covered"}}, true},
      {"city", {{"pool", 0}}},
      {"foliage", {{"pool", 0}}},
  };
  for (const ListCase& of : cases) {
    each_story(of.scene, "linked_list", of.given, [&](const json& told, glm::vec3 radiance) {
      const std::vector<int> owner = owners(told);
      expect_all_told(told, kinds);
      // The visible fragments by their first samples, and the one whose block is the pixel's own.
      std::vector<int> order;
      for (const int one : owner)
        if (one >= 0 && std::ranges::find(order, one) == order.end()) order.push_back(one);
      const int own = of.first_covered ? (order.empty() ? -1 : order[0]) : owner[0];
      std::map<int, const json*> steps, blocks;
      for (const json& step : told["steps"]) steps[step["fragment"].get<int>()] = &step;
      for (const json& block : told["surfaces"]) blocks[block["slot"].get<int>()] = &block;
      std::vector<int> listed;
      int lost = 0;
      for (const int one : order) {
        const json& step = *steps.at(one);
        const auto count = static_cast<int>(std::ranges::count(owner, one));
        EXPECT_EQ(std::popcount(mask(step["samples"])), count);
        if (one == own) {
          EXPECT_EQ(step["kind"], "stored");
        } else if (step["kind"] == "overflow") {
          lost += count;
          continue;
        } else {
          ASSERT_EQ(step["kind"], "linked");
          EXPECT_EQ(step["pointer"].get<std::uint32_t>() & ((1u << 26) - 1), step["slot"].get<std::uint32_t>());
        }
        listed.push_back(step["slot"].get<int>());
        const json& block = *blocks.at(listed.back());
        EXPECT_EQ(block["surface"]["words"], fragment_of(told, one)["surface"]["words"]);
      }
      EXPECT_EQ(told["maps"]["overflow"], lost);
      // The list is in the order of first samples, the pixel's own block before it.
      if (const auto at = std::ranges::find_if(listed, [&](int slot) { return (*blocks.at(slot))["pointer"] == 0; });
          at != listed.end())
        std::rotate(listed.begin(), at, at + 1);
      ASSERT_EQ(told["surfaces"].size(), listed.size());
      int shown = 0;
      for (std::size_t i = 0; i < listed.size(); ++i) {
        const json& block = told["surfaces"][i];
        EXPECT_EQ(block["slot"], listed[i]);
        const bool is_own = block["pointer"] == 0;
        std::uint64_t samples = 0;
        for (std::size_t s = 0; s < owner.size(); ++s) {
          if (owner[s] < 0) continue;
          const json& step = *steps.at(owner[s]);
          const bool here = step["kind"] == "overflow" ? is_own : step["slot"] == block["slot"];
          samples |= std::uint64_t{here} << s;
        }
        EXPECT_EQ(mask(block["covers"]), samples);
        EXPECT_EQ(block["weight"], std::popcount(samples));
        shown += std::popcount(samples);
      }
      for (const json& execution : told["executions"]) {
        EXPECT_EQ(execution["samples"], (*blocks.at(execution["of"].get<int>()))["covers"]);
        EXPECT_EQ(execution["weight"], (*blocks.at(execution["of"].get<int>()))["weight"]);
      }
      leaks += told["maps"]["leaks"].get<std::size_t>();
      const int n = static_cast<int>(owner.size());
      EXPECT_EQ(lit_sum(told, n - shown) / static_cast<float>(n), radiance);
    });
  }
  for (const char* kind : {"stored", "linked", "overflow", "hidden", "transparent"}) EXPECT_GT(kinds[kind], 0u) << kind;
  EXPECT_GT(leaks, 0u);
}

}  // namespace
}  // namespace subpixel::replay
