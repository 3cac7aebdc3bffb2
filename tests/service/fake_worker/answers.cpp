#include "tests/service/fake_worker/answers.hpp"

#include <signal.h>

#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/base64.hpp"
#include "tests/service/fake_worker/fake_capture.hpp"
#include "tests/service/fake_worker/made_up_result.hpp"

namespace subpixel::tests {

using nlohmann::json;

int info(const std::string& path) {
  const json fake = read_fake_capture(path);
  if (fake.value("how", "") == "info_kill") ::raise(SIGKILL);
  if (fake.value("how", "") == "info_hang") std::this_thread::sleep_for(std::chrono::hours(1));
  const bool reaches = fake.value("how", "") == "info_reach";
  if (fake.value("how", "") == "info_internal") {
    std::cerr << "subpixel: internal error: no such shader: please report it\n";
    return 70;
  }
  std::cout << json{{"title", reaches ? reached(fake) : fake.value("title", "A fake capture")},
                    {"frame_count", fake.value("frames", 2)},
                    {"width", fake.value("width", 64)},
                    {"height", fake.value("height", 36)},
                    {"triangles", 1234},
                    {"notices", fake.value("notices", json::array())},
                    {"features", {"textures", "alpha test"}},
                    {"feature_reasons",
                     {{"textures", "2 of 2 materials: bark, leaf"}, {"alpha test", "1 of 2 materials: <b>leaf</b>"}}}}
                   .dump(2)
            << "\n";
  return 0;
}

int view(const std::vector<std::string>& arguments) {
  const json fake = read_fake_capture(arguments[1]);
  if (fake.value("how", "") == "view_kill") ::raise(SIGKILL);
  if (fake.value("how", "") == "view_nested") {
    constexpr std::size_t kDepth = 400'000;
    std::cout << R"({"draws_of_frame":)" << std::string(kDepth, '[') << std::string(kDepth, ']') << "}\n";
    return 0;
  }
  if (fake.value("how", "") == "view_without_draws") {
    std::cout << R"({"title":"A fake capture"})"
              << "\n";
    return 0;
  }
  std::uint32_t frame = 0, width = 0, height = 0;
  for (const std::string& argument : arguments) {
    if (argument.starts_with("--frame=")) frame = static_cast<std::uint32_t>(std::stoul(argument.substr(8)));
    if (!argument.starts_with("--size=")) continue;
    width = static_cast<std::uint32_t>(std::stoul(argument.substr(7)));
    height = static_cast<std::uint32_t>(std::stoul(argument.substr(argument.find('x') + 1)));
  }
  if (frame > 4000) {
    std::cerr << "subpixel: frames: 4001 is not within 0-1: --frame\n";
    return 2;
  }
  json seen{-1, width * (height / 2)};
  for (std::uint32_t y = height / 2; y < height; ++y)
    for (const std::uint32_t run : {0u, width / 2, 1u, width - width / 2}) seen.push_back(run);
  const auto draw = [&](int number, const char* name, json textures) {
    return json{{"draw", number},
                {"name", name},
                {"material", {{"number", 1}, {"name", "<b>bark</b>"}}},
                {"triangles", 12},
                {"instances", 1},
                {"vertices", 24},
                {"index_type", "u16"},
                {"textures", std::move(textures)},
                {"bytes", 480},
                {"pixels", width / 2 * (height - height / 2)}};
  };
  const std::vector<std::uint8_t> picture =
      replay::encode_png(display_image(render(width, height, frame, 4), width, height));
  std::cout << json{{"title", "A fake capture"},
                    {"draws_of_frame",
                     {{"frame", frame},
                      {"name", "frame " + std::to_string(frame)},
                      {"size", {width, height}},
                      {"device", "no device at all"},
                      {"picture", base64_text(picture)},
                      {"seen", seen},
                      {"draws",
                       {draw(0, "<i>trunk</i>", {{{"slot", "base_colour_texture"}, {"texture", 4}, {"name", "bark"}}}),
                        draw(1, "leaves", json::array())}}}}}
                   .dump(1)
            << "\n";
  return 0;
}

int tell(const std::vector<std::string>& arguments) {
  const json fake = read_fake_capture(arguments[1]);
  if (fake.value("how", "") == "pixel_kill") ::raise(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(fake.value("story_ms", 0)));
  for (const std::string& argument : arguments) {
    if (argument.starts_with("--at=") && std::stoi(argument.substr(5)) > 4000) {
      std::cerr << "subpixel: pixel: it is not within 0,0 and 63,35: --at\n";
      return 2;
    }
  }
  const json surface{{"normal", {0, 0, 1}},
                     {"albedo", {0.5, 0.25, 0.125}},
                     {"roughness", 0.8},
                     {"metallic", 0},
                     {"emissive", {0, 0, 0}}};
  const json triangle{
      {"draw", 3}, {"instance", 0}, {"triangle", 17}, {"material", 1}, {"material_name", "<b>leaf</b>"}};
  const json fragment{{"number", 0},        {"triangle", triangle}, {"covers", "0x3"},
                      {"passes", "0x3"},    {"surface", surface},   {"plane", {{"depth", 0.25}, {"dx", 0}, {"dy", 0}}},
                      {"shaded_at", {0, 0}}};
  const json result{{"radiance", {0.5, 0.25, 0.125}}, {"display", {0.7, 0.5, 0.3}}, {"executions", 1}};
  const json story{{"technique", "streaming"},
                   {"parameters", {{"surfaces", 3}}},
                   {"samples", 2},
                   {"pattern",
                    {{{"at", {0.25, 0.25}}, {"fragment", 0}, {"depth", 0.25}},
                     {{"at", {-0.25, -0.25}}, {"fragment", nullptr}, {"depth", 0}}}},
                   {"fragments", {fragment}},
                   {"steps", {{{"fragment", 0}, {"what", "stored as surface 0"}}}},
                   {"maps", {{"merges", 0}}},
                   {"resolve", {{"what", "the mean of 2 samples: 2 of what is lit, 0 of the sky"}}},
                   {"executions", {{{"of", 0}, {"samples", "0x3"}, {"weight", 2}, {"value", {0.5, 0.25, 0.125}}}}},
                   {"result", result}};
  // One of a technique that keeps aggregates, one of a filter.
  json kept = story, filtered = story;
  kept["technique"] = "agaa";
  const json aggregate{{"normal", {0, 0, 1}},
                       {"diffuse", {0.5, 0.25, 0.125}},
                       {"reflectance", {0.04, 0.04, 0.04}},
                       {"roughness", 0.8},
                       {"emissive", {0, 0, 0}}};
  kept["surfaces"] = {{{"slot", 0},
                       {"covers", "0x3"},
                       {"weight", 2},
                       {"depth_of", "reversed depth"},
                       {"nearest", 0.25},
                       {"farthest", 0.2},
                       {"surface", aggregate}}};
  filtered["technique"] = "fxaa";
  filtered["filter"] = {
      {{"kind", "luma"}, {"neighbourhood", {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}}, {"what", "0.5000 here"}},
      {{"kind", "blend"}, {"what", "0.7500 of the pixel's <b>value</b>"}}};
  std::cout << json{{"arguments", arguments},
                    {"pixel", {1, 2}},
                    {"frame", 0},
                    {"size", {64, 36}},
                    {"capture", "fake"},
                    {"stories", {story, kept, filtered}},
                    {"reference",
                     {{"samples", 4},
                      {"result", result},
                      {"shadings",
                       {{{"turn", 0},
                         {"at", {0.125, -0.125}},
                         {"samples", 4},
                         {"triangle", triangle},
                         {"radiance", {0.5, 0.25, 0.125}}}}}}}}
                   .dump(1)
            << "\n";
  return 0;
}

int differ(const std::vector<std::string>& arguments) {
  const json a = read_fake_capture(arguments[1]), b = read_fake_capture(arguments[2]);
  if (b.value("how", "") == "diff_kill") ::raise(SIGKILL);
  const int draws_a = a.value("draws", 2), draws_b = b.value("draws", 2);
  json added = json::array();
  for (int draw = draws_a; draw < draws_b; ++draw) added.push_back({{"draw", draw}, {"name", "<b>new</b> tree"}});
  json changed = json::array();
  if (draws_a != draws_b) {
    changed.push_back({{"a", 0},
                       {"b", 0},
                       {"name", "trunk"},
                       {"renamed", false},
                       {"matched_by", "name"},
                       {"moved", nullptr},
                       {"mesh", json::array()},
                       {"material", {{{"field", "roughness"}, {"a", 0.5}, {"b", 0.7}}}},
                       {"textures", json::array()}});
  }
  const bool same = a == b;
  std::cout << json{{"same", same},
                    {"fields", json::array()},
                    {"frames_a", 1},
                    {"frames_b", 1},
                    {"frames",
                     {{{"frame", 0},
                       {"same", same},
                       {"fields", json::array()},
                       {"draws_a", draws_a},
                       {"draws_b", draws_b},
                       {"equal", draws_a - static_cast<int>(changed.size())},
                       {"reordered", 0},
                       {"added", added},
                       {"gone", json::array()},
                       {"changed", changed}}}}}
                   .dump(1)
            << "\n";
  return same ? 0 : 1;
}

}  // namespace subpixel::tests
