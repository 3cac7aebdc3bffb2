// Captures for bench/scaling.py and for measuring how a large one is loaded. Usage:
//   subpixel_bench_captures draws DRAWS TEXTURES FILE   boxes on a plane, a draw each, with so many textures
//   subpixel_bench_captures bytes MIB FILE              buffers and textures of so many MiB in all, which the frame
//   uses subpixel_bench_captures load FILE                   time of loading it over that of zstd alone
#include <fmt/format.h>
#include <sys/resource.h>
#include <zstd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/mapped_file.hpp"
#include "base/numbers.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/reading/capture_file.hpp"
#include "capture_format/writer.hpp"
#include "scenes/builder/scene_builder.hpp"

namespace subpixel::capture {
namespace {

Metadata metadata(const std::string& title) {
  Metadata made;
  made.title = title;
  return made;
}

// Of low bits that do not compress and high ones that do, as vertices and photographs have them.
std::vector<std::byte> rough_bytes(std::size_t count, std::uint32_t seed) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    seed = seed * 1664525u + 1013904223u;
    const auto smooth = static_cast<std::uint32_t>(i / 64);
    bytes[i] = static_cast<std::byte>((i % 4 < 2 ? seed >> 24 : smooth >> (8 * (i % 4 - 2))) & 0xff);
  }
  return bytes;
}

Texture rough_texture(const std::string& name, std::uint32_t side, std::uint32_t seed) {
  Texture texture;
  texture.name = name;
  texture.width = texture.height = side;
  texture.bytes = rough_bytes(std::size_t{side} * side * 4, seed);
  return texture;
}

void add_light(SceneBuilder& scene) {
  scene.environment.sun = DirectionalLight{{0.5f, -0.6f, -0.7f}, {3, 3, 3}, false};
  scene.environment.ambient = {0.1f, 0.1f, 0.12f};
}

// `draws` boxes in rows that fill the view, so that pixels are the same whatever their number.
Capture many_draws(std::uint32_t draws, std::uint32_t textures) {
  SceneBuilder scene(metadata("many draws"));
  add_light(scene);
  std::vector<std::uint32_t> materials;
  for (std::uint32_t t = 0; t < textures; ++t) {
    Material material;
    material.name = fmt::format("material {}", t);
    material.base_colour_texture = scene.add_texture(rough_texture(fmt::format("texture {}", t), 64, t + 1));
    material.roughness = 0.5f;
    materials.push_back(scene.add_material(material));
  }
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(draws)));
  const double step = 20.0 / side;
  Mesh box;
  add_box(box, {0, 0, 0}, glm::dvec3(0.8 * step));
  const Draw mesh = scene.add_mesh("box", box);
  for (std::uint32_t d = 0; d < draws; ++d) {
    const std::uint32_t column = d % side, row = d / side;
    scene.draw(mesh, fmt::format("box {}", d), materials[d % textures],
               translation({column * step - 10, row * step - 10, 0}));
  }
  return scene.finish(CameraPath({{0, {0, 0, 24}, {0, 0, 0}, 45}}), 1, 1280, 720);
}

// Meshes of a MiB and textures of a MiB in turn, all in one frame.
Capture many_bytes(std::uint32_t mib) {
  SceneBuilder scene(metadata("many bytes"));
  add_light(scene);
  constexpr std::uint32_t kVertices = 20'000;  // of 28 bytes, and indices
  for (std::uint32_t m = 0; m < mib; m += 2) {
    const std::vector<std::byte> noise = rough_bytes(std::size_t{kVertices} * 12, m + 1);
    Mesh mesh;
    for (std::uint32_t v = 0; v < kVertices; ++v) {
      std::uint32_t word = 0;
      std::memcpy(&word, &noise[std::size_t{v} * 12], sizeof word);
      const double x = (word & 0xffff) / 65536.0, y = (word >> 16) / 65536.0;
      mesh.add_vertex({x, y, (v % 100) * 0.01}, {0, 0, 1}, {x, y});
    }
    for (std::uint32_t v = 0; v + 2 < kVertices; ++v) mesh.add_triangle(v, v + 1, v + 2);
    mesh.indices.resize(120'000);
    Material material;
    material.name = fmt::format("material {}", m);
    material.base_colour_texture = scene.add_texture(rough_texture(fmt::format("texture {}", m), 512, m + 7));
    scene.draw(scene.add_mesh(fmt::format("mesh {}", m), mesh), fmt::format("draw {}", m),
               scene.add_material(material));
  }
  return scene.finish(CameraPath({{0, {0.5, 0.5, 4}, {0.5, 0.5, 0}, 45}}), 1, 64, 64);
}

double processor_s() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

// Every zstd payload of the file, nothing checked: into memory of its own each, as a reader keeps it, or all into one
// buffer, as zstd's own program writes it on.
std::uint64_t decompress_all(std::span<const std::byte> file, const ChunkList& list, bool keep) {
  std::uint64_t bytes = 0;
  std::vector<std::vector<char>> kept(1);
  for (const ChunkAt& chunk : list.chunks) {
    if (chunk.header.codec != Codec::zstd) continue;
    const auto stored = file.subspan(chunk.offset + kChunkHeaderBytes, chunk.header.stored_bytes);
    if (keep) kept.emplace_back();
    kept.back().reserve(chunk.header.decoded_bytes);  // not set to 0
    const std::size_t got =
        ZSTD_decompress(kept.back().data(), chunk.header.decoded_bytes, stored.data(), stored.size());
    if (ZSTD_isError(got) != 0) throw InputError("zstd", ZSTD_getErrorName(got), "");
    bytes += got;
  }
  return bytes;
}

// The least of several turns, by the clock and of the processor.
struct Least {
  double wall_s = 1e9, processor_s = 1e9;
};

template <typename Work>
void measure(Least& least, const Work& work) {
  const double processor_before = processor_s();
  const auto before = std::chrono::steady_clock::now();
  work();
  least.wall_s =
      std::min(least.wall_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
  least.processor_s = std::min(least.processor_s, processor_s() - processor_before);
}

void measure_loading(const std::string& path) {
  constexpr int kTurns = 5;
  Least kept, alone, loading;
  std::uint64_t bytes = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    for (const bool keep : {true, false}) {
      const MappedFile file(path, ReadLimits{}.file_bytes);
      const ChunkList list = list_chunks(file.bytes(), {});
      measure(keep ? kept : alone, [&] { bytes = decompress_all(file.bytes(), list, keep); });
    }
    measure(loading, [&] {
      const CaptureFile file(path);
      const Capture capture = file.load(0, file.frame_count() - 1);
    });
  }
  const auto line = [&](const char* what, double Least::*figure) {
    fmt::print(
        "{}: zstd alone into one buffer {:.3f}, into memory that is kept {:.3f}; loading {:.3f}, {:.2f} and {:.2f} "
        "times\n",
        what, alone.*figure, kept.*figure, loading.*figure, loading.*figure / (alone.*figure),
        loading.*figure / (kept.*figure));
  };
  fmt::print("{:.1f} MiB decoded, seconds, the least of {} turns each; zstd on one core\n",
             static_cast<double>(bytes) / (1 << 20), kTurns);
  line("by the clock", &Least::wall_s);
  line("of the processor", &Least::processor_s);
}

std::uint32_t number(const char* text) {
  const auto value = parse_number<std::uint32_t>(text);
  if (!value || *value == 0) throw UsageError("number", "not a whole number above 0", text);
  return *value;
}

int run(int count, char** arguments) {
  const std::string_view what = count > 1 ? arguments[1] : "";
  if (what == "draws" && count == 5) {
    write_capture(many_draws(number(arguments[2]), number(arguments[3])), arguments[4]);
  } else if (what == "bytes" && count == 4) {
    write_capture(many_bytes(number(arguments[2])), arguments[3]);
  } else if (what == "load" && count == 3) {
    measure_loading(arguments[2]);
  } else {
    throw UsageError("usage", "draws DRAWS TEXTURES FILE | bytes MIB FILE | load FILE", "");
  }
  return 0;
}

}  // namespace
}  // namespace subpixel::capture

int main(int count, char** arguments) {
  try {
    return subpixel::capture::run(count, arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
