// What recording costs the thread that records, through C and through C++: a frame of 1,000 draws of known resources
// (the work that a frame has without anything new), and a MiB of new bytes. Best of several runs in ms; the writing
// thread works beside, so on a machine without a core to spare its time is in the numbers too. Usage:
// subpixel_bench_recorder [FOLDER]
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "capture_format/stream_recorder.hpp"
#include "recorder/subpixel_recorder.h"

namespace subpixel::capture {
namespace {

constexpr std::size_t kDraws = 1000;
constexpr int kFrames = 200;
constexpr std::size_t kNewBytes = 1 << 20, kNewBuffers = 128;

// Both recorders seen as what is measured of them.
struct Calls {
  std::function<std::uint32_t(const std::vector<std::uint32_t>&)> add_buffer;
  std::function<void()> begin_frame, end_frame;
  std::function<void(std::size_t)> draw;
};

std::string name_of(std::size_t draw) {
  return "objects/harbour/crane " + std::to_string(draw);  // longer than what a string holds without memory
}

void require(subpixel_status status) {
  if (status == SUBPIXEL_OK) return;
  fmt::print(stderr, "{}\n", subpixel_recorder_error());
  std::exit(1);
}

double ms_since(std::chrono::steady_clock::time_point before) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count();
}

// A buffer that no other is equal to, of noise: what does not compress is the most that there is to write.
std::vector<std::uint32_t> noise(std::size_t bytes, std::uint32_t seed) {
  std::vector<std::uint32_t> words(bytes / 4);
  for (std::uint32_t& word : words) word = seed = seed * 1664525u + 1013904223u;
  return words;
}

struct Measured {
  double frame_ms, draws_ms, end_ms, known_mb_ms, new_mb_ms;
};

Measured measure(const Calls& calls) {
  Measured best{1e9, 1e9, 1e9, 1e9, 0};
  for (int f = 0; f < kFrames; ++f) {
    const auto begin = std::chrono::steady_clock::now();
    calls.begin_frame();
    for (std::size_t d = 0; d < kDraws; ++d) calls.draw(d);
    const double draws = ms_since(begin);
    calls.end_frame();
    const double frame = ms_since(begin);
    if (frame < best.frame_ms) best = {frame, draws, frame - draws, best.known_mb_ms, 0};
    // The rest of a frame's time belongs to the application, and the writing thread works meanwhile.
    ::usleep(2000);
  }
  std::vector<std::vector<std::uint32_t>> buffers;
  for (std::size_t i = 0; i < kNewBuffers; ++i) buffers.push_back(noise(kNewBytes, static_cast<std::uint32_t>(i)));
  auto before = std::chrono::steady_clock::now();
  for (const auto& buffer : buffers) calls.add_buffer(buffer);
  best.new_mb_ms = ms_since(before) / kNewBuffers;
  before = std::chrono::steady_clock::now();
  for (const auto& buffer : buffers) calls.add_buffer(buffer);
  best.known_mb_ms = ms_since(before) / kNewBuffers;
  return best;
}

void print(const char* language, const Measured& m) {
  fmt::print("{:4} {:8.3f} {:8.3f} {:8.3f} {:12.3f} {:12.3f}\n", language, m.frame_ms, m.draws_ms, m.end_ms,
             m.new_mb_ms, m.known_mb_ms);
}

Measured measure_cpp(const std::filesystem::path& path) {
  StreamRecorder recorder(Metadata{}, path);
  const std::vector<std::uint32_t> vertices = noise(1000 * 32, 1);
  std::vector<std::uint16_t> order(3000);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint16_t>(i * 7 % 1000);
  const std::uint32_t vertex_buffer = recorder.add_buffer("vertices", std::as_bytes(std::span(vertices)));
  const std::uint32_t index_buffer = recorder.add_buffer("order", std::as_bytes(std::span(order)));
  const std::uint32_t material = recorder.add_material({});
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  std::vector<std::string> names;
  for (std::size_t d = 0; d < kDraws; ++d) names.push_back(name_of(d));
  Calls calls;
  calls.add_buffer = [&](const auto& words) { return recorder.add_buffer("new", std::as_bytes(std::span(words))); };
  calls.begin_frame = [&] { recorder.begin_frame(frame); };
  calls.end_frame = [&] { recorder.end_frame(); };
  calls.draw = [&](std::size_t d) {
    Draw draw;
    draw.name = names[d];
    draw.material = material;
    draw.position = {vertex_buffer, VertexFormat::float32x3, 0, 32};
    draw.normal = {vertex_buffer, VertexFormat::float32x3, 12, 32};
    draw.uv = {vertex_buffer, VertexFormat::float32x2, 24, 32};
    draw.vertex_count = 1000;
    draw.index_type = IndexType::uint16;
    draw.index_buffer = index_buffer;
    draw.index_offset = 6 * (d % 100);
    draw.index_count = 600;
    draw.transform[12] = static_cast<float>(d);
    recorder.draw(std::move(draw));
  };
  const Measured measured = measure(calls);
  recorder.finish();
  return measured;
}

Measured measure_c(const std::filesystem::path& path) {
  subpixel_metadata metadata;
  subpixel_material material;
  subpixel_frame frame;
  subpixel_draw draw;
  require(subpixel_metadata_init(&metadata, sizeof metadata));
  require(subpixel_material_init(&material, sizeof material));
  require(subpixel_frame_init(&frame, sizeof frame));
  require(subpixel_draw_init(&draw, sizeof draw));
  subpixel_recorder* recorder = nullptr;
  require(subpixel_recorder_create(path.c_str(), &metadata, nullptr, &recorder));
  const std::vector<std::uint32_t> vertices = noise(1000 * 32, 1);
  std::vector<std::uint16_t> order(3000);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint16_t>(i * 7 % 1000);
  std::uint32_t buffer = 0;
  require(subpixel_recorder_add_buffer(recorder, "vertices", vertices.data(), 4 * vertices.size(), &buffer));
  require(subpixel_recorder_add_buffer(recorder, "order", order.data(), 2 * order.size(), &draw.index_buffer));
  require(subpixel_recorder_add_material(recorder, &material, &draw.material));
  draw.position = {buffer, SUBPIXEL_FLOAT32X3, 0, 32};
  draw.normal = {buffer, SUBPIXEL_FLOAT32X3, 12, 32};
  draw.uv = {buffer, SUBPIXEL_FLOAT32X2, 24, 32};
  draw.vertex_count = 1000, draw.index_type = SUBPIXEL_INDEX_UINT16, draw.index_count = 600;
  std::vector<std::string> names;
  for (std::size_t d = 0; d < kDraws; ++d) names.push_back(name_of(d));
  Calls calls;
  calls.add_buffer = [&](const auto& words) {
    std::uint32_t number = 0;
    require(subpixel_recorder_add_buffer(recorder, "new", words.data(), 4 * words.size(), &number));
    return number;
  };
  calls.begin_frame = [&] { require(subpixel_recorder_begin_frame(recorder, &frame)); };
  calls.end_frame = [&] { require(subpixel_recorder_end_frame(recorder)); };
  calls.draw = [&](std::size_t d) {
    draw.name = names[d].c_str();
    draw.index_offset = 6 * (d % 100);
    draw.transform[12] = static_cast<float>(d);
    require(subpixel_recorder_draw(recorder, &draw));
  };
  const Measured measured = measure(calls);
  require(subpixel_recorder_finish(recorder));
  subpixel_recorder_destroy(recorder);
  return measured;
}

}  // namespace
}  // namespace subpixel::capture

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  const fs::path folder = (argc > 1 ? fs::path(argv[1]) : fs::temp_directory_path()) / "subpixel_bench_recorder";
  fs::create_directories(folder);
  fmt::print("ms    a frame of 1,000 draws: of it   a MiB of bytes:\n");
  fmt::print("     {:>8} {:>8} {:>8} {:>12} {:>12}\n", "all", "draws", "its end", "new", "known");
  subpixel::capture::print("C", subpixel::capture::measure_c(folder / "c.spcap"));
  subpixel::capture::print("C++", subpixel::capture::measure_cpp(folder / "cpp.spcap"));
  fs::remove_all(folder);
  return 0;
}
