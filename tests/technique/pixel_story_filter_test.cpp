// Stories of techniques that filter a finished image or accumulate frames, replayed by plain code from the images that
// they start from: the same decisions, and the bits of the frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tests/technique/pixel_story_fixture.hpp"
#include "tests/technique/smaa_transcription.hpp"

namespace subpixel::replay {
namespace {

constexpr int kColumns = kWidth, kRows = kHeight;

TechniqueRun plain_run(const std::string& scene_name, const std::string& technique, const ParameterValues& given,
                       std::uint32_t frame = 0) {
  FrameScene scene(test_device(), story_capture(scene_name, frame + 1), {}, {frame, kWidth, kHeight});
  return technique_run(run_frame(scene, find_technique(technique).with(given)));
}

std::size_t index_of(int x, int y) {
  x = std::clamp(x, 0, kColumns - 1);
  y = std::clamp(y, 0, kRows - 1);
  return static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
}

glm::ivec2 pixel_of(const json& told) {
  return {told["pixel"][0].get<int>(), told["pixel"][1].get<int>()};
}

const json* step_of(const json& told, const std::string& kind) {
  for (const json& step : told["filter"])
    if (step["kind"] == kind) return &step;
  return nullptr;
}

struct FxaaSettings {
  float relative = 0.125f, least = 0.03f, blur = 0.75f;
  std::size_t steps = 16;
};

// The share of the pixel across the edge, which is told of, worked out again from the luma that is told.
float expected_share(const json& told, const TechniqueRun& plain, const FxaaSettings& settings) {
  const auto luma = (*step_of(told, "luma"))["neighbourhood"].get<std::vector<float>>();
  const auto shown = [&](glm::ivec2 p) {
    return glm::dot(glm::vec3(plain.display[index_of(p.x, p.y)]), glm::vec3(0.299f, 0.587f, 0.114f));
  };
  const glm::ivec2 p = pixel_of(told);
  for (int k = 0; k < 9; ++k)
    EXPECT_NEAR(luma[static_cast<std::size_t>(k)], shown(p + glm::ivec2(k % 3 - 1, k / 3 - 1)), 1e-6f);
  const auto [nw, n, ne, w, m, e, sw, s, se] =
      std::tuple(luma[0], luma[1], luma[2], luma[3], luma[4], luma[5], luma[6], luma[7], luma[8]);
  const json& contrast = *step_of(told, "contrast");
  const float highest = std::max({m, n, s, w, e}), lowest = std::min({m, n, s, w, e});
  EXPECT_EQ(contrast["contrast"].get<float>(), highest - lowest);
  EXPECT_EQ(contrast["threshold"].get<float>(), std::max(settings.least, settings.relative * highest));
  const bool edge_here = highest - lowest >= std::max(settings.least, settings.relative * highest);
  EXPECT_EQ(step_of(told, "direction") != nullptr, edge_here);
  if (!edge_here || step_of(told, "direction") == nullptr) return 0;

  const json &direction = *step_of(told, "direction"), &search = *step_of(told, "search");
  const float down = std::abs(nw + sw - 2 * w) + 2 * std::abs(n + s - 2 * m) + std::abs(ne + se - 2 * e);
  const float right = std::abs(nw + ne - 2 * n) + 2 * std::abs(w + e - 2 * m) + std::abs(sw + se - 2 * s);
  EXPECT_EQ(direction["down"].get<float>(), down);
  EXPECT_EQ(direction["right"].get<float>(), right);
  const bool level = down >= right;
  const float before = level ? n : w, after = level ? s : e;
  const bool towards_after = std::abs(after - m) > std::abs(before - m);
  const glm::ivec2 across = (level ? glm::ivec2(0, 1) : glm::ivec2(1, 0)) * (towards_after ? 1 : -1);
  EXPECT_EQ(glm::ivec2(direction["across"][0].get<int>(), direction["across"][1].get<int>()), across);
  const float other = towards_after ? after : before, edge = 0.5f * (m + other),
              tolerance = 0.25f * std::abs(other - m);
  EXPECT_EQ(search["edge"].get<float>(), edge);
  EXPECT_EQ(search["tolerance"].get<float>(), tolerance);

  std::array<float, 2> steps{}, at_end{};
  for (int side = 0; side < 2; ++side) {
    const auto differences = search[side == 0 ? "back" : "ahead"].get<std::vector<float>>();
    const glm::ivec2 along = (level ? glm::ivec2(1, 0) : glm::ivec2(0, 1)) * (side == 0 ? -1 : 1);
    for (std::size_t k = 0; k < differences.size(); ++k) {
      const glm::ivec2 q = p + static_cast<int>(k + 1) * along;
      EXPECT_NEAR(differences[k], 0.5f * (shown(q) + shown(q + across)) - edge, 2e-6f);
      EXPECT_EQ(std::abs(differences[k]) < tolerance && k + 1 < settings.steps, k + 1 < differences.size());
    }
    steps[static_cast<std::size_t>(side)] = static_cast<float>(differences.size());
    at_end[static_cast<std::size_t>(side)] = differences.empty() ? 0 : differences.back();
  }
  const float nearer = std::min(steps[0], steps[1]), difference = steps[0] < steps[1] ? at_end[0] : at_end[1];
  const bool cut_off = settings.steps > 0 && std::abs(difference) >= tolerance && (difference > 0) != (m > edge);
  const float of_step = cut_off ? std::max(0.5f - (nearer - 0.5f) / (steps[0] + steps[1] - 1), 0.0f) : 0.0f;
  const float surroundings = (2 * (n + s + w + e) + nw + ne + sw + se) / 12;
  const float t = std::clamp(std::abs(surroundings - m) / (highest - lowest), 0.0f, 1.0f);
  const float isolation = t * t * (3 - 2 * t);
  const json& offset = *step_of(told, "offset");
  EXPECT_FLOAT_EQ(offset["of_step"].get<float>(), of_step);
  EXPECT_NEAR(offset["of_blur"].get<float>(), settings.blur * isolation * isolation, 1e-6f);
  return std::max(offset["of_step"].get<float>(), offset["of_blur"].get<float>());
}

TEST(PixelStory, FilterOfFxaaReplayedIsTheFrame) {
  std::size_t changed = 0, unchanged = 0, by_step = 0;
  const std::pair<ParameterValues, FxaaSettings> cases[] = {
      {{}, {}},
      {{{"search_steps", 3}, {"blur", 0.25}, {"edge_threshold", 0.01}, {"least_contrast", 0}}, {0.01f, 0, 0.25f, 3}},
      {{{"search_steps", 0}}, {0.125f, 0.03f, 0.75f, 0}},
  };
  for (const char* scene : {"grass", "city"}) {
    const TechniqueRun plain = plain_run(scene, "noaa", {});
    for (const auto& [given, settings] : cases) {
      each_story(scene, "fxaa", given, [&, &settings = settings](const json& told, glm::vec3 radiance) {
        const float share = expected_share(told, plain, settings);
        const json& blend = *step_of(told, "blend");
        EXPECT_EQ(blend["share"].get<float>(), share);
        const glm::ivec2 p = pixel_of(told);
        glm::ivec2 across(0);
        if (const json* direction = step_of(told, "direction"))
          across = {(*direction)["across"][0].get<int>(), (*direction)["across"][1].get<int>()};
        const glm::vec3 own(plain.radiance[index_of(p.x, p.y)]);
        const glm::vec3 other(plain.radiance[index_of(p.x + across.x, p.y + across.y)]);
        EXPECT_EQ(vector(blend["own"]), own);
        EXPECT_EQ(vector(blend["other"]), other);
        EXPECT_EQ(own * (1.0f - share) + other * share, radiance);
        EXPECT_EQ(told["maps"]["changed"], share > 0 ? 1 : 0);
        ++(share > 0 ? changed : unchanged);
        if (const json* offset = step_of(told, "offset")) by_step += (*offset)["of_step"] == share && share > 0;
      });
    }
  }
  EXPECT_GT(changed, 20u);
  EXPECT_GT(unchanged, 5u);
  EXPECT_GT(by_step, 5u);
}

glm::vec3 radiance_of_tone(glm::vec3 y) {
  y = glm::clamp(y, glm::vec3(0), glm::vec3(0.99999f));
  const glm::vec3 a = 2.43f * (1.0f - y), b = 0.03f - 0.59f * y, c = -0.14f * y;
  return (-b + glm::sqrt(glm::max(b * b - 4.0f * a * c, glm::vec3(0)))) / (2.0f * a);
}

namespace brute = smaa_transcription;

// What edges and weights are told, beside those of the transcription.
void expect_patterns(const json& told, const brute::Edges& edges, const brute::Grid<glm::dvec4>& weights,
                     const brute::Settings& settings) {
  const glm::ivec2 p = pixel_of(told);
  for (const json& step : told["filter"]) {
    if (step["kind"] == "blend") continue;
    const glm::ivec2 at = p + (step["of"] == "its eastern neighbour"    ? glm::ivec2(1, 0)
                               : step["of"] == "its southern neighbour" ? glm::ivec2(0, 1)
                                                                        : glm::ivec2(0));
    if (step["kind"] == "edges") {
      EXPECT_EQ(step["west"], edges.west.at(at.x, at.y) == 1);
      EXPECT_EQ(step["north"], edges.north.at(at.x, at.y) == 1);
      EXPECT_EQ(step["west"].get<bool>(), step["steps"][0].get<float>() >= static_cast<float>(settings.threshold) &&
                                              static_cast<float>(settings.adaptation) * step["steps"][0].get<float>() >=
                                                  step["most"].get<float>());
      continue;
    }
    const glm::dvec4 expected = weights.at(at.x, at.y);
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(step["weights"][static_cast<std::size_t>(k)].get<double>(), expected[k], 1e-5);
      EXPECT_NEAR(step["bytes"][static_cast<std::size_t>(k)].get<int>(), expected[k] * 255, 0.5001);
    }
    // What is told of lines and diagonals makes the weights.
    if (step.contains("level") && !step["level"].is_null()) {
      const json& line = step["level"];
      const int left = line["distances"][0].get<int>(), right = line["distances"][1].get<int>();
      const auto end = [](const json& bits) {
        return brute::End{(bits.get<int>() & 1) != 0, (bits.get<int>() & 2) != 0};
      };
      const glm::dvec2 areas =
          brute::compressed_line_areas(end(line["crossed"][0]), end(line["crossed"][1]), left, right);
      for (int k = 0; k < 2; ++k) {
        const auto i = static_cast<std::size_t>(k);
        EXPECT_NEAR(line["areas"][i].get<double>(), areas[k], 1e-6);
        EXPECT_NEAR(line["areas"][i].get<double>() * line["corners_leave"][i].get<double>(), expected[k], 1e-5);
      }
    }
  }
}

TEST(PixelStory, FilterOfSmaaReplayedIsTheFrame) {
  std::map<std::string, std::size_t> kinds;
  const std::tuple<ParameterValues, brute::Settings, bool> cases[] = {
      {{}, {0.1, 2, false, 16, 8, 0.25}, true},
      {{{"quality", "low"}, {"blend", "radiance"}}, {0.15, 2, false, 4, 0, 1}, false},
      {{{"threshold", 0.02}, {"edges", "colour"}}, {0.02, 2, true, 16, 8, 0.25}, true},
  };
  for (const char* scene : {"grass", "city"}) {
    const TechniqueRun plain = plain_run(scene, "noaa", {});
    brute::Grid<glm::vec3> shown(kColumns, kRows);
    for (std::size_t i = 0; i < plain.display.size(); ++i) shown.values[i] = glm::vec3(plain.display[i]);
    for (const auto& [given, settings, displayed] : cases) {
      const brute::Edges edges = brute::find_edges(shown, settings);
      const brute::Grid<glm::dvec4> weights = brute::find_weights(edges, settings);
      each_story(
          scene, "smaa", given, [&, &settings = settings, displayed = displayed](const json& told, glm::vec3 radiance) {
            expect_patterns(told, edges, weights, settings);
            for (const json& step : told["filter"])
              for (const char* pattern : {"level", "upright", "rising", "falling"})
                kinds[pattern] += step.contains(pattern) && step["kind"] == "weights";
            // The bytes of the pixel's four edges, of which two are its neighbours'.
            std::map<std::string, std::vector<int>> bytes;
            for (const json& step : told["filter"])
              if (step["kind"] == "weights") bytes[step["of"]] = step["bytes"].get<std::vector<int>>();
            const json& blend = *step_of(told, "blend");
            const auto weight = [&](const char* of, std::size_t byte) {
              return static_cast<float>(bytes.at(bytes.contains(of) ? of : "the pixel").at(byte)) / 255.0f;
            };
            const float north = weight("the pixel", 0), south = weight("its southern neighbour", 1);
            const float west = weight("the pixel", 2), east = weight("its eastern neighbour", 3);
            EXPECT_EQ(blend["weights"].get<std::vector<float>>(), (std::vector<float>{north, south, west, east}));
            const bool sideways = std::max(east, west) > std::max(south, north);
            const float after = sideways ? east : south, before = sideways ? west : north, sum = after + before;
            const glm::vec3 own = vector(blend["own"]), first = vector(blend["before"]["value"]),
                            last = vector(blend["after"]["value"]);
            const glm::ivec2 p = pixel_of(told);
            if (!displayed) {
              EXPECT_EQ(own, glm::vec3(plain.radiance[index_of(p.x, p.y)]));
            }
            if (sum == 0) {
              ++kinds["alone"];
              EXPECT_EQ(glm::vec3(plain.radiance[index_of(p.x, p.y)]), radiance);
              return;
            }
            ++kinds["blended"];
            const auto mix = [](glm::vec3 a, glm::vec3 b, float share) { return a * (1.0f - share) + b * share; };
            const glm::vec3 mixed = (after * mix(own, last, after) + before * mix(own, first, before)) / sum;
            EXPECT_EQ(vector(blend["mixed"]), mixed);
            EXPECT_EQ(displayed ? radiance_of_tone(mixed) : mixed, radiance);
            const float share = (after * after + before * before) / sum * 255.0f + 0.5f;
            EXPECT_EQ(told["maps"]["blended"], static_cast<std::uint32_t>(share));
          });
    }
  }
  for (const char* kind : {"level", "upright", "rising", "falling", "alone", "blended"})
    EXPECT_GT(kinds[kind], 0u) << kind;
}

glm::vec3 ycocg(glm::vec3 c) {
  return {0.25f * c.r + 0.5f * c.g + 0.25f * c.b, 0.5f * c.r - 0.5f * c.b, -0.25f * c.r + 0.5f * c.g - 0.25f * c.b};
}

struct TaaCase {
  const char* bounds;
  const char* filter;
  bool progressive;
};

// History at `position`, by Catmull and Rom's cubic or between four pixels.
glm::vec3 read_history(const TechniqueRun& before, glm::vec2 position, bool cubic) {
  const glm::vec2 low = glm::floor(position - 0.5f), t = position - 0.5f - low;
  const auto weights = [cubic](float f) {
    if (!cubic) return glm::vec4(0, 1 - f, f, 0);
    return glm::vec4(((-0.5f * f + 1) * f - 0.5f) * f, (1.5f * f - 2.5f) * f * f + 1, ((-1.5f * f + 2) * f + 0.5f) * f,
                     (0.5f * f - 0.5f) * f * f);
  };
  const glm::vec4 across = weights(t.x), down = weights(t.y);
  glm::vec3 sum(0);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      sum += across[x] * down[y] *
             glm::vec3(before.radiance[index_of(static_cast<int>(low.x) + x - 1, static_cast<int>(low.y) + y - 1)]);
  return glm::max(sum, glm::vec3(0));
}

// The history within the bounds of 3x3 pixels.
glm::vec3 bounded(const std::vector<glm::vec3>& colours, glm::vec3 before, const std::string& bounds,
                  const json& told) {
  if (bounds == "none") return before;
  glm::vec3 low(1e30f), high(-1e30f), sum(0), squares(0);
  for (const glm::vec3& colour : colours) {
    low = glm::min(low, colour);
    high = glm::max(high, colour);
    sum += colour;
    squares += colour * colour;
  }
  if (bounds == "variance") {
    const glm::vec3 mean = sum / 9.0f, reach = glm::sqrt(glm::max(squares / 9.0f - mean * mean, glm::vec3(0)));
    low = mean - reach;
    high = mean + reach;
  }
  EXPECT_EQ(vector(told["low"]), low);
  EXPECT_EQ(vector(told["high"]), high);
  const glm::vec3 colour = ycocg(before);
  glm::vec3 inside = glm::clamp(colour, low, high);
  EXPECT_EQ(told["moved"], inside != colour);
  if (inside == colour) return before;
  if (bounds != "clamp") {
    const glm::vec3 middle = 0.5f * (low + high), way = colour - middle, half = 0.5f * (high - low);
    const glm::vec3 lengths = glm::abs(way) / glm::max(half, glm::vec3(1e-7f));
    inside = middle + way / std::max({lengths.x, lengths.y, lengths.z, 1.0f});
  }
  return glm::max(glm::vec3(inside.x + inside.y - inside.z, inside.x + inside.z, inside.x - inside.y - inside.z),
                  glm::vec3(0));
}

// Frame 2 of three, whose history is what frame 1 with a history of one leaves: the same jitter, the same frames.
TEST(PixelStory, AccumulationOfTaaReplayedIsTheFrame) {
  std::map<std::string, std::size_t> kinds;
  const TaaCase cases[] = {{"variance", "catmull_rom", true},
                           {"clip", "bilinear", false},
                           {"clamp", "bilinear", true},
                           {"none", "catmull_rom", false}};
  for (const char* scene : {"city"}) {
    for (const TaaCase& of : cases) {
      ParameterValues given{
          {"bounds", of.bounds}, {"filter", of.filter}, {"progressive", of.progressive}, {"luma_weights", false}};
      given["history"] = 0;
      const TechniqueRun own = plain_run(scene, "taa", given, 2);
      given["history"] = 1;
      FrameScene before_scene(test_device(), story_capture(scene, 3), {}, {1, kWidth, kHeight});
      const TechniqueRun before = technique_run(run_frame(before_scene, find_technique("taa").with(given)));
      given["history"] = 2;
      each_story(
          scene, "taa", given,
          [&](const json& told, glm::vec3 radiance) {
            const glm::ivec2 p = pixel_of(told);
            const json &motion = *step_of(told, "motion"), &blend = *step_of(told, "blend");
            const glm::vec2 came_from(motion["came_from"][0].get<float>(), motion["came_from"][1].get<float>());
            EXPECT_EQ(motion["inside"],
                      came_from.x >= 0 && came_from.y >= 0 && came_from.x < kColumns && came_from.y < kRows);
            const glm::ivec2 front(motion["front"][0].get<int>(), motion["front"][1].get<int>());
            EXPECT_LE(std::max(std::abs(front.x - p.x), std::abs(front.y - p.y)), 1);
            const json& shows = told["pattern"][0]["fragment"];
            if (front == p && !shows.is_null()) {
              const json& fragment = told["fragments"].at(shows.get<std::size_t>());
              EXPECT_EQ(motion["triangle"], fragment["triangle"]["record"]);
              EXPECT_EQ(motion["depth"], told["pattern"][0]["depth"]);
            }
            const glm::vec3 value(own.radiance[index_of(p.x, p.y)]);
            EXPECT_EQ(vector(blend["own"]), value);
            const json* const history = step_of(told, "history");
            EXPECT_EQ(told["maps"]["rejected"], history == nullptr || !history->contains("value") ? 1 : 0);
            if (history == nullptr || !history->contains("value")) {
              ++kinds["rejected"];
              EXPECT_EQ(value, radiance);
              return;
            }
            const glm::vec3 sample = read_history(before, came_from, std::string(of.filter) == "catmull_rom");
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(vector((*history)["value"])[c], sample[c], 2e-6f * (1 + sample[c]));
            const json& bounds = *step_of(told, "bounds");
            std::vector<glm::vec3> colours;
            colours.reserve(9);
            for (int k = 0; k < 9; ++k)
              colours.push_back(ycocg(glm::vec3(own.radiance[index_of(p.x + k % 3 - 1, p.y + k / 3 - 1)])));
            for (std::size_t k = 0; bounds.contains("colours") && k < 9; ++k)
              EXPECT_EQ(vector(bounds["colours"][k]), colours[k]);
            const glm::vec3 kept = bounded(colours, vector((*history)["value"]), of.bounds, bounds);
            EXPECT_EQ(vector(bounds["kept"]), kept);
            const float frames = (*history)["frames"].get<float>() + 1;
            EXPECT_EQ(blend["frames"].get<float>(), frames);
            const float share = of.progressive ? std::max(0.1f, 1.0f / frames) : 0.1f;
            EXPECT_EQ(blend["share"].get<float>(), share);
            EXPECT_EQ(kept + share * (value - kept), radiance);
            ++kinds[bounds["moved"].get<bool>() ? "moved" : "kept"];
          },
          2);
    }
  }
  for (const char* kind : {"moved", "kept"}) EXPECT_GT(kinds[kind], 0u) << kind;
}

// A black card in front leaves a bright wall behind: nothing of it was to be seen there.
TEST(PixelStory, HistoryOfWhatWasHiddenIsToldToBeRejected) {
  capture::Capture capture = flat_capture(48, 24);
  const auto wall = add_emitter(capture, {0.8f, 0.6f, 0.4f}), card = add_emitter(capture, {0, 0, 0});
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.8f), wall).name = "wall";
  add_triangles(capture, rectangle(-0.5f, -1, 0.5f, 1, 0.5f), card).name = "card";
  capture.frames[0].view[14] = -1;
  capture.frames[0].projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0.25f, 0, 0, 0, 1, 1};
  capture.frames.push_back(capture.frames[0]);
  capture.frames[1].draws[1].transform[12] = 0.5f;  // 12 pixels
  FrameScene scene(test_device(), capture, {}, {1, 48, 24});
  const ParameterValues given{{"history", 1}, {"jitter", 1}, {"bounds", "none"}, {"luma_weights", false}};
  for (const auto& [x, rejected] : {std::pair{18u, true}, std::pair{4u, false}}) {
    PixelStory story({x, 12});
    RecordedFrame recorded(scene, find_technique("taa").with(given), &story);
    recorded.run();
    const json told = recorded.story();
    const json& history = *step_of(told, "history");
    EXPECT_EQ(history["what"].get<std::string>().starts_with("rejected"), rejected) << history;
    EXPECT_EQ(told["maps"]["rejected"], rejected ? 1 : 0);
    if (rejected) {
      EXPECT_EQ((*step_of(told, "blend"))["own"], told["result"]["radiance"]);
    }
  }
}

}  // namespace
}  // namespace subpixel::replay
