#include "tests/service/fake_worker/made_up_result.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "replay/measure/flip.hpp"
#include "replay/measure/metrics.hpp"
#include "tests/service/fake_worker/png.hpp"

namespace subpixel::tests {

using nlohmann::json;

namespace {

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

}  // namespace

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
    write_png(job.out_dir / result.images[role], width, height, rgb);
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
    if (!std::filesystem::exists(shared)) write_png(shared, width, height, reference);
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

}  // namespace subpixel::tests
