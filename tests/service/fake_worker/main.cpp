// A stand-in for `subpixel worker` and `subpixel info`: it speaks the worker protocol without a device and goes wrong
// on request. Its "captures" are text: "FAKE " and a JSON object that says how to behave:
//   title, frames, notices   what `info` reports
//   result_ms           how long each result takes
//   fail_at, how        before result number fail_at (from 0, skipped ones counted): see misbehave()
//   times               it goes wrong so often and then no more; without it always
//   reach               the file that `reach` and `info_reach` try to open
//   log                 a file of the cache folder that gets a line "frame/technique" for each result measured
//   width, height       of the images; 0: as asked for
//   tweak               a file; while it is there, its JSON object changes what one technique measures: `technique`,
//                       `slower` (factor), `executions` (added), `mse` (factor), `pixel` (added to the first one)
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "base/base64.hpp"
#include "replay/measure/flip.hpp"
#include "replay/measure/image.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/results/worker_protocol.hpp"
#include "tests/service/fake_worker/png.hpp"
#include "tests/service/fake_worker/probe.hpp"

namespace {

using nlohmann::json;
using namespace subpixel;

void say(const json& message) {
  std::cout << message.dump() << std::endl;
}

json read_fake_capture(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::getline(file, text);  // what follows only makes the file larger
  if (!text.starts_with("FAKE ")) {
    std::cerr << "subpixel: can't read the capture: the file does not begin as one: " << path << ", byte offset 0\n";
    ::_exit(3);
  }
  return json::parse(text.substr(5));
}

std::string reached(const json& fake) {
  const int file = ::open(fake.value("reach", "").c_str(), O_RDONLY | O_CLOEXEC);
  return std::string("reach: ") + (file >= 0 ? "done" : ::strerror(errno));
}

// Whether it is time to go wrong once more: the cache folder outlives workers, and a file in it counts.
bool is_due(const json& fake, const std::filesystem::path& cache) {
  if (!fake.contains("times")) return true;
  std::error_code none_yet;
  const std::filesystem::path counter = cache / "times";
  const std::uintmax_t times = std::filesystem::file_size(counter, none_yet);
  if (!none_yet && times >= fake["times"].get<std::uintmax_t>()) return false;
  std::ofstream(counter, std::ios::app) << 'x';
  return true;
}

void misbehave(const std::string& how) {
  if (how == "segv") ::raise(SIGSEGV);
  if (how == "kill") ::raise(SIGKILL);
  if (how == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  if (how == "chatter") {
    while (true) say({{"type", "progress"}, {"stage", "replay"}, {"done", 1}, {"total", 2}, {"detail", "on and on"}});
  }
  if (how == "exit") {
    std::cerr << "first words\nthe driver lost the device\n";
    ::_exit(4);
  }
  if (how == "error") {
    say({{"type", "error"}, {"message", "can't replay: the device lacks int64: feature shaderInt64"}, {"exit", 4}});
    ::_exit(4);
  }
  if (how == "internal") {
    say({{"type", "error"}, {"message", "internal error: no such shader: please report it"}, {"exit", 70}});
    ::_exit(70);
  }
  if (how == "garbage") std::cout << "\x01\xff not json at all" << std::endl;
  if (how == "long_line") std::cout << std::string(std::size_t{64} << 20, 'x') << std::endl;
  if (how == "quit") ::_exit(0);
  if (how == "memory") {
    // Untouched pages cost nothing but count as address space.
    if (::mmap(nullptr, std::size_t{64} << 30, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0) ==
        MAP_FAILED) {
      std::cerr << "out of memory\n";
      ::abort();
    }
  }
}

struct Colour {
  double r, g, b;
};

// Something with edges at every angle, so that the viewer has something to compare.
Colour scene_at(double x, double y, std::uint32_t frame) {
  const double angle = std::atan2(y - 0.5, x - 0.5) + 0.02 * frame;
  const double radius = std::hypot(x - 0.5, y - 0.5);
  const bool spoke = std::fmod(angle * 16 / 3.14159265 + 64, 2) < 1 && radius < 0.42;
  if (spoke) return {0.95 - radius, 0.55 + 0.3 * x, 0.25};
  return {0.25 + 0.3 * y, 0.45 + 0.3 * y, 0.75};
}

std::vector<std::uint8_t> render(std::uint32_t width, std::uint32_t height, std::uint32_t frame, int samples) {
  std::vector<std::uint8_t> pixels;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      Colour sum{0, 0, 0};
      for (int s = 0; s < samples; ++s) {
        const int row = s / 4, rows = (samples + 3) / 4;
        const double jitter_x = (s % 4 + 0.5) / std::min(samples, 4), jitter_y = (row + 0.5) / rows;
        const Colour c =
            scene_at((x + jitter_x) / width, 0.5 + ((y + jitter_y) / height - 0.5) * height / width, frame);
        sum = {sum.r + c.r, sum.g + c.g, sum.b + c.b};
      }
      for (const double value : {sum.r, sum.g, sum.b}) {
        pixels.push_back(static_cast<std::uint8_t>(std::clamp(value / samples, 0.0, 1.0) * 255));
      }
    }
  }
  return pixels;
}

replay::Image display_image(const std::vector<std::uint8_t>& rgb, std::uint32_t width, std::uint32_t height) {
  replay::Image image(width, height, 3);
  for (std::size_t i = 0; i < rgb.size(); ++i) image.pixels[i] = static_cast<float>(rgb[i]) / 255;
  return image;
}

replay::ResultsHead make_head(const replay::ReplayJob& job, const std::string& title, std::uint32_t width,
                              std::uint32_t height) {
  replay::ResultsHead head;
  head.capture_title = title;
  head.driver = "fake";
  head.driver_version = "1.0";
  head.device = "no device at all";
  head.cpu_model = "test double";
  head.build = "fake";
  head.date_utc = "2025-01-01T00:00:00Z";
  head.width = width;
  head.height = height;
  head.repeat = job.options.repeat;
  head.reference_samples = job.options.reference_samples;
  head.triangles_first_frame = 1234;
  head.features = {"textures", "alpha test"};
  return head;
}

json tweak_of(const json& fake, const std::string& technique) {
  std::ifstream file(fake.value("tweak", ""));
  if (!file) return json::object();
  json tweak = json::parse(file);
  return tweak.value("technique", technique) == technique ? tweak : json::object();
}

replay::FrameResult make_result(const replay::ReplayJob& job, std::uint32_t frame, std::uint32_t index,
                                std::uint32_t width, std::uint32_t height, const json& tweak) {
  const replay::TechniqueRequest& request = job.options.techniques[index];
  replay::FrameResult result;
  result.frame = frame;
  result.technique = request.technique;
  result.parameters = request.parameters;
  const auto samples = request.parameters.find("samples");
  result.samples = samples != request.parameters.end() ? samples->second.get<std::uint32_t>() : 1;
  result.width = width;
  result.height = height;
  const std::uint64_t pixels = std::uint64_t{width} * height;
  result.ms.passes = {
      {"set-up", 2.5}, {"geometry", 20.0 + 4 * result.samples + frame}, {"shade", 11.0 * result.samples}};
  for (auto& pass : result.ms.passes) {
    pass.median_ms *= tweak.value("slower", 1.0);
    result.ms.total_ms += pass.median_ms;
  }
  result.ms.spread_ms = 1.25;
  result.ms.least_ms = result.ms.total_ms - 0.5;
  result.ms.cold_ms = 400;
  result.memory.paper_bytes_per_pixel = 20.0 * result.samples;
  result.memory.fitted_bytes_per_pixel = 16.0 * result.samples;
  result.memory.paper_bytes = 20 * result.samples * pixels;
  result.memory.fitted_bytes = 16 * result.samples * pixels;
  result.memory.allocated_bytes = result.memory.paper_bytes + 4096;
  result.shading.executions = pixels * result.samples + tweak.value("executions", 0u);
  result.shading.per_pixel_mean = result.samples;
  result.shading.histogram = {pixels / 4, pixels - pixels / 4};
  if (job.options.reference_samples > 0) {
    result.error.mse = 1e-3 / result.samples * tweak.value("mse", 1.0);
    result.error.psnr_db = -10 * std::log10(result.error.mse);
  }
  const std::string stem = "f" + std::to_string(frame) + "-" + std::to_string(index);
  std::vector<std::uint8_t> image = render(width, height, frame, static_cast<int>(result.samples));
  image[0] = static_cast<std::uint8_t>(image[0] + tweak.value("pixel", 0));
  const auto write = [&](const std::string& role, const std::vector<std::uint8_t>& rgb) {
    // As with the real worker, a frame's techniques share the file of its reference, which is written once.
    const bool shared = role == "reference";
    result.images[role] = (shared ? "f" + std::to_string(frame) : stem) + "-" + role + ".png";
    if (shared && std::filesystem::exists(job.out_dir / result.images[role])) return;
    tests::write_png(job.out_dir / result.images[role], width, height, rgb);
  };
  const auto write_exr = [&](const std::string& role, const std::string& name, const std::vector<std::uint8_t>& bytes) {
    result.images[role] = name;
    std::ofstream(job.out_dir / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  const auto write_linear = [&](const std::string& role, const std::string& name,
                                const std::vector<std::uint8_t>& rgb) {
    replay::Image linear = display_image(rgb, width, height);
    linear.encoding = replay::Encoding::linear;
    for (float& value : linear.pixels) value = replay::srgb_decode(value);
    write_exr(role, name, replay::encode_exr(linear));
  };
  write("image", image);
  if (job.options.reference_samples > 0) {
    const std::vector<std::uint8_t> reference = render(width, height, frame, 64);
    std::vector<std::uint8_t> error(reference.size());
    for (std::size_t i = 0; i < error.size(); ++i) {
      error[i] = static_cast<std::uint8_t>(std::min(255, 4 * std::abs(int{image[i]} - int{reference[i]})));
    }
    // One file for all results of the frame, written with the first of them, as the real worker does.
    result.images["reference"] = "f" + std::to_string(frame) + "-reference.png";
    const std::filesystem::path shared = job.out_dir / result.images["reference"];
    if (!std::filesystem::exists(shared)) tests::write_png(shared, width, height, reference);
    write("error", error);
    write_linear("reference_hdr", "f" + std::to_string(frame) + "-reference.exr", reference);
    const replay::Image shown = display_image(image, width, height), truth = display_image(reference, width, height);
    const replay::FlipResult perceived = replay::flip(truth, shown);
    result.error.flip_mean = perceived.mean;
    write_exr("error_values", stem + "-error.exr", replay::encode_values_exr(replay::error_map(truth, shown), ""));
    write_exr("flip_values", stem + "-flip.exr", replay::encode_values_exr(perceived.map, ""));
  }
  write("shading", std::vector<std::uint8_t>(image.rbegin(), image.rend()));
  std::vector<std::uint32_t> counts(pixels);
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = i % 4 == 0 ? 0 : result.samples;
  write_exr("shading_values", stem + "-shading.exr", replay::encode_counts_exr(width, height, counts, "executions"));
  write_linear("hdr", stem + ".exr", image);
  return result;
}

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

// What a replay of times reports: results without images, `rounds` times.
int time_rounds(const replay::ReplayJob& job, const json& fake, std::uint32_t width, std::uint32_t height) {
  const auto [first, last] = job.options.frames.value_or(std::pair{0u, fake.value("frames", 2u) - 1});
  for (std::uint32_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t round = 0; round < job.options.rounds; ++round) {
      for (std::uint32_t index = 0; index < job.options.techniques.size(); ++index) {
        const json tweak = tweak_of(fake, job.options.techniques[index].technique);
        json result = replay::to_json(make_result(job, frame, index, width, height, tweak));
        result["images"] = json::object();
        say({{"type", "result"}, {"ordinal", index}, {"result", result}});
      }
    }
  }
  say({{"type", "done"}});
  return 0;
}

int work(const std::string& job_path) {
  std::ifstream file(job_path);
  const replay::ReplayJob job = replay::replay_job_from_json(json::parse(file));
  const json fake = read_fake_capture(job.capture.string());
  const bool thumbnail = job.options.reference_samples == 0 && job.options.width == 320;
  const auto [first, last] = job.options.frames.value_or(std::pair{0u, fake.value("frames", 2u) - 1});
  const int fail_at = thumbnail ? -1 : fake.value("fail_at", -1);
  const std::string how = fake.value("how", "");
  const std::uint32_t width = job.options.width != 0 ? job.options.width : fake.value("width", 64u);
  const std::uint32_t height = job.options.height != 0 ? job.options.height : fake.value("height", 36u);

  say({{"type", "progress"}, {"stage", "load"}, {"done", 0}, {"total", 1}, {"detail", "<b>capture</b>"}});
  say({{"type", "head"},
       {"head", replay::to_json(make_head(job, fake.value("title", "A fake capture"), width, height))}});
  const auto techniques = static_cast<std::uint32_t>(job.options.techniques.size());
  const std::uint32_t total = (last - first + 1) * techniques;
  if (job.options.rounds > 0) return time_rounds(job, fake, width, height);
  std::uint32_t done = 0;
  if (job.options.references_only) {
    const auto all = static_cast<std::size_t>(total) - job.options.skip.size();
    if (fake.contains("log"))
      std::ofstream(fake["log"].get<std::string>(), std::ios::app) << "references " << all << "\n";
    say({{"type", "done"}});
    return 0;
  }
  for (std::uint32_t frame = first; frame <= last; ++frame) {
    for (std::uint32_t index = 0; index < techniques; ++index, ++done) {
      const std::pair<std::uint32_t, std::uint32_t> pair{frame, index};
      if (std::ranges::find(job.options.skip, pair) != job.options.skip.end()) continue;
      if (fail_at == static_cast<int>(done) && how == "reach") {
        say({{"type", "error"}, {"message", reached(fake)}, {"exit", 3}});
        return 3;
      }
      if (fail_at == static_cast<int>(done) && is_due(fake, job.cache_dir)) misbehave(how);
      say({{"type", "progress"},
           {"stage", "replay"},
           {"done", done},
           {"total", total},
           {"detail", "frame " + std::to_string(frame) + " " + job.options.techniques[index].technique}});
      std::this_thread::sleep_for(std::chrono::milliseconds(thumbnail ? 0 : fake.value("result_ms", 0)));
      const json tweak = tweak_of(fake, job.options.techniques[index].technique);
      json result = replay::to_json(make_result(job, frame, index, width, height, tweak));
      if (fail_at == static_cast<int>(done) && how == "escape") result["images"]["image"] = "../job.json";
      if (fail_at == static_cast<int>(done) && how == "foreign") result["frame"] = 4000;
      if (fake.contains("log") && !thumbnail) {
        std::ofstream(fake["log"].get<std::string>(), std::ios::app) << frame << "/" << index << "\n";
      }
      say({{"type", "result"}, {"ordinal", index}, {"result", result}});
    }
  }
  if (how == "no_done") return 0;
  say({{"type", "head"},
       {"head", replay::to_json(make_head(job, fake.value("title", "A fake capture"), width, height))}});
  say({{"type", "done"}});
  return 0;
}

// What `info --draws --seen` adds: a sky over two draws, left and right. Frames above 4000 are refused.
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

// The story of a pixel whose options are among the arguments. With x above 4000 it is refused.
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

}  // namespace

// What `subpixel diff` says: of captures with other `draws` the added ones, and one that changed.
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

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 3 && arguments[0] == "info" && arguments[2] == "--json") return info(arguments[1]);
  if (arguments.size() > 3 && arguments[0] == "info" && arguments[2] == "--json") return view(arguments);
  if (arguments.size() == 3 && arguments[0] == "worker" && arguments[1] == "--job") return work(arguments[2]);
  if (arguments.size() == 3 && arguments[0] == "probe") return tests::probe(arguments[1], arguments[2]);
  if (arguments.size() > 3 && arguments[0] == "pixel" && arguments[2] == "--json") return tell(arguments);
  if (arguments.size() == 4 && arguments[0] == "diff" && arguments[3] == "--json") return differ(arguments);
  std::cerr << "usage: info FILE --json [OPTIONS] | worker --job FILE | pixel FILE --json OPTIONS | probe WHAT PATH\n";
  return 2;
}
