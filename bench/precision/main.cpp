// What each stored quantity costs: frames in float64, once exactly and once with one quantity rounded as a published
// format stores it, compared pixel by pixel. Prints the Markdown tables of docs/numerics.md.
//   subpixel_precision [scene ...]
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "bench/precision/exact_frame.hpp"
#include "bench/precision/formats.hpp"
#include "replay/frame/run_frame.hpp"
#include "replay/measure/flip.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference_cache.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::precision {
namespace {

using replay::Image;

// How a frame is rounded. Empty functions leave values as they are.
struct Format {
  std::string quantity, name;
  std::function<double(const ExactFrame&, const glm::dvec2& window, double depth)> depth;  // of lit points
  std::function<void(ExactSurface&)> surface;
  std::function<double(const ExactFrame&, const ExactFragment&, const glm::dvec2& window, std::uint32_t sample)> plane;
  std::function<double(double)> sample_value;  // a channel of one sample's radiance
  std::function<double(double sum, double value)> add;
  std::function<double(double)> shown;  // a channel of the display image
};

struct Rendered {
  Image radiance, display;
  std::uint64_t wrong_samples = 0, samples = 0;  // that show another fragment than without rounding
};

Rendered render(const ExactFrame& frame, const Format& format) {
  Rendered out{{frame.width, frame.height, 3, replay::Encoding::linear}, {frame.width, frame.height, 3}};
  for (std::uint32_t y = 0; y < frame.height; ++y) {
    for (std::uint32_t x = 0; x < frame.width; ++x) {
      const glm::dvec2 window(x + 0.5, y + 0.5);
      const auto& fragments = frame.pixels[std::size_t{y} * frame.width + x];
      std::vector<glm::dvec3> lit(fragments.size(), glm::dvec3(-1));
      glm::dvec3 sum(0);
      for (std::uint32_t s = 0; s < kSamples; ++s) {
        std::size_t exact = fragments.size(), shown = fragments.size();
        double nearest = -1, nearest_shown = -1e300;
        for (std::size_t f = 0; f < fragments.size(); ++f) {
          if ((fragments[f].mask >> s & 1) == 0) continue;
          const double depth = ExactFrame::depth_at_sample(fragments[f], s);
          if (depth > nearest) nearest = depth, exact = f;
          const double rounded = format.plane ? format.plane(frame, fragments[f], window, s) : depth;
          if (rounded > nearest_shown) nearest_shown = rounded, shown = f;
        }
        glm::dvec3 value = frame.sky;
        if (shown < fragments.size()) {
          ++out.samples;
          out.wrong_samples += shown != exact ? 1 : 0;
          if (lit[shown].x < 0) {
            ExactSurface surface = fragments[shown].surface;
            if (format.depth) {
              const glm::dvec2 at = window + fragments[shown].at;
              surface.position = frame.world(at, format.depth(frame, at, fragments[shown].depth_at));
            }
            if (format.surface) format.surface(surface);
            lit[shown] = frame.shade(surface);
          }
          value = lit[shown];
        }
        for (int c = 0; c < 3; ++c) {
          const double stored = format.sample_value ? format.sample_value(value[c]) : value[c];
          sum[c] = format.add ? format.add(sum[c], stored) : sum[c] + stored;
        }
      }
      const glm::dvec3 mean = sum / static_cast<double>(kSamples);
      glm::dvec3 shown = frame.display(mean);
      for (int c = 0; c < 3 && format.shown; ++c) shown[c] = format.shown(shown[c]);
      for (int c = 0; c < 3; ++c) {
        out.radiance.pixels[out.radiance.offset(x, y) + static_cast<std::size_t>(c)] = static_cast<float>(mean[c]);
        out.display.pixels[out.display.offset(x, y) + static_cast<std::size_t>(c)] = static_cast<float>(shown[c]);
      }
    }
  }
  return out;
}

// A plane kept as in section 3 of Kerzner and Salvi 2014: float depth at the centre, slopes in `Slope`.
template <typename Slope>
double distance_plane(const ExactFrame& frame, const ExactFragment& f, const glm::dvec2& window, std::uint32_t s,
                      const Slope& stored) {
  if (!frame.perspective()) return f.depth + glm::dot(f.slope, ExactFrame::sample_offset(s));
  const glm::dvec2 at = window + f.at;
  const double distance = frame.distance(at, f.depth_at), step = 1e-6;
  // The plane that touches at the shading point, as the technique builds it.
  const double dx = (frame.distance(at + glm::dvec2(step, 0), f.depth_at + step * f.slope.x) - distance) / step;
  const double dy = (frame.distance(at + glm::dvec2(0, step), f.depth_at + step * f.slope.y) - distance) / step;
  const glm::dvec2 slope(stored(dx), stored(dy));
  const double centre = static_cast<double>(static_cast<float>(distance - glm::dot(slope, f.at)));
  return -(centre + glm::dot(slope, ExactFrame::sample_offset(s)));
}

std::vector<Format> formats() {
  std::vector<Format> all;
  const auto depth = [&](const std::string& name, auto stored) {
    all.push_back({.quantity = "depth of lit points", .name = name, .depth = stored});
  };
  const auto surface = [&](const std::string& quantity, const std::string& name, auto stored) {
    all.push_back({.quantity = quantity, .name = name, .surface = stored});
  };
  depth("float32, reversed (ours)", [](const ExactFrame&, const glm::dvec2&, double z) { return to_float(z); });
  depth("24 bits, reversed", [](const ExactFrame&, const glm::dvec2&, double z) { return to_unorm(z, 24); });
  depth("24 bits, forward, far 1000", [](const ExactFrame& frame, const glm::dvec2& at, double z) {
    if (!frame.perspective()) return 1 - to_unorm(1 - z, 24);
    const double near = frame.near_plane(), far = 1000, scale = far / (far - near);
    const double forward = to_unorm(scale * (1 - near / frame.distance(at, z)), 24);
    return frame.depth_of_distance(at, near / std::max(1 - forward / scale, 1e-9));
  });
  depth("16 bits, reversed", [](const ExactFrame&, const glm::dvec2&, double z) { return to_unorm(z, 16); });
  surface("normal", "octahedral 2x16 (ours)", [](ExactSurface& s) { s.normal = octahedral(s.normal, 16); });
  surface("normal", "octahedral 2x12 (hybrid)", [](ExactSurface& s) { s.normal = octahedral(s.normal, 12); });
  surface("normal", "octahedral 2x8", [](ExactSurface& s) { s.normal = octahedral(s.normal, 8); });
  surface("normal", "spherical 2x8 (AGAA, visibility)", [](ExactSurface& s) { s.normal = spherical(s.normal, 8); });
  surface("normal", "3x8", [](ExactSurface& s) { s.normal = three_bytes(s.normal); });
  const auto each = [](glm::dvec3& v, auto stored) {
    for (int c = 0; c < 3; ++c) v[c] = stored(v[c]);
  };
  surface("albedo", "square root, 3x8 (ours)", [each](ExactSurface& s) {
    each(s.albedo, [](double v) { return std::pow(to_unorm(std::sqrt(v), 8), 2.0); });
  });
  surface("albedo", "linear, 3x8",
          [each](ExactSurface& s) { each(s.albedo, [](double v) { return to_unorm(v, 8); }); });
  surface("roughness, metallic", "8 (ours)", [](ExactSurface& s) {
    s.roughness = to_unorm(s.roughness, 8);
    s.metallic = to_unorm(s.metallic, 8);
  });
  surface("emission", "shared exponent 9+9+9+5 (ours)",
          [](ExactSurface& s) { s.emissive = shared_exponent(s.emissive); });
  const auto plane = [&](const std::string& name, auto stored) {
    all.push_back({.quantity = "depth planes at samples", .name = name, .plane = stored});
  };
  plane("distance, float32 slopes", [](const ExactFrame& frame, const ExactFragment& f, const glm::dvec2& at,
                                       std::uint32_t s) { return distance_plane(frame, f, at, s, to_float); });
  plane("distance, half slopes (streaming)", [](const ExactFrame& frame, const ExactFragment& f, const glm::dvec2& at,
                                                std::uint32_t s) { return distance_plane(frame, f, at, s, to_half); });
  plane("reversed depth, half slopes",
        [](const ExactFrame&, const ExactFragment& f, const glm::dvec2&, std::uint32_t s) {
          return to_float(f.depth) +
                 glm::dot(glm::dvec2(to_half(f.slope.x), to_half(f.slope.y)), ExactFrame::sample_offset(s));
        });
  const auto value = [&](const std::string& name, auto stored) {
    all.push_back({.quantity = "lit samples", .name = name, .sample_value = stored});
  };
  value("half", to_half);
  value("unsigned 11 bits (R11G11B10)", [](double v) { return to_small_float(v, 6); });
  value("unsigned 10 bits (R11G11B10)", [](double v) { return to_small_float(v, 5); });
  all.push_back({.quantity = "resolve sum", .name = "float32 (ours)", .add = [](double a, double b) {
                   return to_float(a + to_float(b));
                 }});
  all.push_back({.quantity = "resolve sum", .name = "half", .add = [](double a, double b) { return to_half(a + b); }});
  all.push_back(
      {.quantity = "display image", .name = "8 bits, for scale", .shown = [](double v) { return to_unorm(v, 8); }});
  return all;
}

// Sums of n values that were divided by n before each was rounded to a fixed-point target, as blending adds them
// (Crassin et al. 2016, section 3.4), against their mean.
void print_fixed_point() {
  fmt::print("\n| target | n | largest error | of the value, in steps of an 8-bit mean |\n| --- | --- | --- | --- |\n");
  for (const int bits : {8, 10, 16}) {
    for (const int n : {4, 8, 16, 32}) {
      double worst = 0;
      for (int i = 0; i <= 9973; ++i) {
        const double value = i / 9973.0;
        double sum = 0;
        for (int k = 0; k < n; ++k) sum += to_unorm(value / n, bits);
        worst = std::max(worst, std::abs(sum - value));
      }
      fmt::print("| unorm {} | {} | {:.1e} | {:.2f} |\n", bits, n, worst, worst * 255);
    }
  }
}

struct Loss {
  double flip = 0, worst = 0, wrong = 0;
};

std::vector<Loss> study(const std::string& name, std::uint32_t width, std::uint32_t height) {
  const capture::Capture capture = capture::generate(name, {.frames = 1, .width = width, .height = height});
  const ExactFrame frame(capture, width, height);
  const Rendered exact = render(frame, {});
  std::vector<Loss> losses;
  for (const Format& format : formats()) {
    const Rendered rounded = render(frame, format);
    Loss loss;
    for (std::size_t i = 0; i < exact.display.pixels.size(); ++i)
      loss.worst =
          std::max(loss.worst, std::abs(static_cast<double>(exact.display.pixels[i] - rounded.display.pixels[i])));
    loss.flip = replay::flip(exact.display, rounded.display).mean;
    if (rounded.samples > 0)
      loss.wrong = static_cast<double>(rounded.wrong_samples) / static_cast<double>(rounded.samples);
    losses.push_back(loss);
  }
  return losses;
}

void print_head(const char* first, const std::vector<std::string>& scenes, int columns) {
  fmt::print("{}", first);
  for (const std::string& scene : scenes) fmt::print(" {} |", scene);
  fmt::print("\n|");
  for (std::size_t s = 0; s < scenes.size() + static_cast<std::size_t>(columns); ++s) fmt::print(" --- |");
  fmt::print("\n");
}

void print_table(const std::vector<std::string>& scenes) {
  std::vector<std::vector<Loss>> losses;
  losses.reserve(scenes.size());
  for (const std::string& scene : scenes) losses.push_back(study(scene, 160, 90));
  print_head("| quantity | stored as | largest difference |", scenes, 3);
  const std::vector<Format> all = formats();
  for (std::size_t f = 0; f < all.size(); ++f) {
    double worst = 0;
    for (const auto& scene : losses) worst = std::max(worst, scene[f].worst);
    fmt::print("| {} | {} | {:.1e} |", all[f].quantity, all[f].name, worst);
    for (const auto& scene : losses) {
      const double flip = scene[f].flip * 1e3;
      const std::string text = fmt::format("{:.2f}", flip);
      fmt::print(" {} |", flip > 1 ? "**" + text + "**" : text);
    }
    fmt::print("\n");
  }
  fmt::print("\nSamples that show another surface than without the rounding:\n\n");
  print_head("| planes kept as |", scenes, 1);
  for (std::size_t f = 0; f < all.size(); ++f) {
    if (!all[f].plane) continue;
    fmt::print("| {} |", all[f].name);
    for (const auto& scene : losses) fmt::print(" {:.3f}% |", 100 * scene[f].wrong);
    fmt::print("\n");
  }
}

// The device's image against the exact one. `forward` shades as ExactFrame does: each fragment once, at the pixel's
// centre or in the middle of its samples.
void print_device() {
  fmt::print("\n`forward` on the device against float64:\n\n");
  fmt::print("| scene | MSE | FLIP, 1e-3 | pixels off by more than an 8-bit step | largest elsewhere |\n");
  fmt::print("| --- | --- | --- | --- | --- |\n");
  gpu::Device device;
  for (const char* name : {"cube", "spheres", "hard_interpenetrating", "hard_small_angle", "hard_roughness",
                           "hard_grazing", "hard_far_origin", "hard_bright_light", "hard_emissive_only"}) {
    replay::FrameScene scene(device, capture::generate(name, {.frames = 1, .width = 160, .height = 90}));
    const Image shown = run_frame(scene, replay::find_technique("forward").with()).display;
    const Image exact = render(ExactFrame(scene.capture, scene.width(), scene.height()), {}).display;
    std::size_t off = 0;
    double elsewhere = 0;
    for (std::size_t i = 0; i < exact.pixels.size(); i += 3) {
      double worst = 0;
      for (std::size_t c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(static_cast<double>(shown.pixels[i + c] - exact.pixels[i + c])));
      if (worst > 1.0 / 255)
        ++off;
      else
        elsewhere = std::max(elsewhere, worst);
    }
    fmt::print("| {} | {:.1e} | {:.2f} | {:.2f}% | {:.1e} |\n", name, replay::mse(exact, shown),
               1e3 * replay::flip(exact, shown).mean,
               300.0 * static_cast<double>(off) / static_cast<double>(exact.pixels.size()), elsewhere);
  }
}

// Techniques that can keep a quantity in two ways: their two images compared, and the error of each.
void print_variants() {
  struct Variant {
    std::string_view technique, parameter, published, other;
  };
  constexpr Variant kVariants[] = {{"agaa", "storage", "fixed", "float"}, {"streaming", "depth_space", "view", "clip"}};
  fmt::print("\nThe same technique with a quantity kept in two ways:\n\n");
  fmt::print("| technique | scene | FLIP between, 1e-3 | FLIP to the reference, 1e-3 | |\n");
  fmt::print("| --- | --- | --- | --- | --- |\n");
  gpu::Device device;
  const auto folder = std::filesystem::temp_directory_path() / "subpixel_numerics_references";
  for (const char* name : {"grass", "city", "spheres", "hard_railings", "hard_overflow", "hard_depth_range"}) {
    const capture::SceneInfo info = capture::find_scene(name);
    const bool small = info.group == capture::SceneGroup::hard;
    replay::FrameScene scene(
        device,
        capture::generate(name, {.frames = 1, .width = small ? info.width : 160, .height = small ? info.height : 90}));
    const Image reference =
        cached_reference(device, scene.scene, 0, {.samples = 64}, replay::ReferenceCache(folder)).image.display;
    for (const Variant& v : kVariants) {
      for (const replay::Technique* technique : replay::techniques()) {
        if (technique->name != v.technique) continue;
        const auto with = [&](std::string_view value) {
          return run_frame(scene, technique->with({{std::string(v.parameter), std::string(value)}})).display;
        };
        const Image published = with(v.published), other = with(v.other);
        const double between = 1e3 * replay::flip(published, other).mean;
        fmt::print("| `{}` {}={} / {} | {} | {}{:.2f}{} | {:.1f} | {:.1f} |\n", v.technique, v.parameter, v.published,
                   v.other, name, between > 1 ? "**" : "", between, between > 1 ? "**" : "",
                   1e3 * replay::flip(reference, published).mean, 1e3 * replay::flip(reference, other).mean);
      }
    }
  }
}

}  // namespace
}  // namespace subpixel::precision

int main(int argc, char** argv) {
  using namespace subpixel::precision;
  std::vector<std::string> scenes(argv + 1, argv + argc);
  if (scenes.empty())
    scenes = {"grass",
              "city",
              "bamboo",
              "tubes",
              "spheres",
              "hard_grazing",
              "hard_depth_range",
              "hard_far_origin",
              "hard_interpenetrating",
              "hard_small_angle",
              "hard_bright_light",
              "hard_emissive_only"};
  print_table(scenes);
  print_fixed_point();
  print_device();
  print_variants();
  return 0;
}
