#include "bench/precision/exact_frame.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "capture_format/streams.hpp"
#include "replay/scene/camera.hpp"
#include "shaders/frontend/sample_patterns.h"

namespace subpixel::precision {
namespace {

glm::dvec3 unit(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 1e-12 && std::isfinite(length) ? v / length : otherwise;
}

struct Corner {
  glm::dvec4 clip;
  glm::dvec3 world, normal, colour{1};
};

double cross2(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

}  // namespace

glm::dvec2 ExactFrame::sample_offset(std::uint32_t sample) {
  const auto offset = gpu_types::sample_offset(kSamples, sample);
  return glm::dvec2(offset.x, offset.y) / 128.0;
}

double ExactFrame::depth_at_sample(const ExactFragment& fragment, std::uint32_t sample) {
  return fragment.depth + glm::dot(fragment.slope, sample_offset(sample));
}

glm::dvec3 ExactFrame::world(const glm::dvec2& window, double depth) const {
  const glm::dvec4 point = inverse_ * glm::dvec4(2.0 * window / glm::dvec2(width, height) - 1.0, depth, 1);
  return glm::dvec3(point) / point.w;
}

double ExactFrame::distance(const glm::dvec2& window, double depth) const {
  return 1 / glm::dot(row_, glm::dvec4(2.0 * window / glm::dvec2(width, height) - 1.0, depth, 1));
}

double ExactFrame::depth_of_distance(const glm::dvec2& window, double distance) const {
  const glm::dvec2 ndc = 2.0 * window / glm::dvec2(width, height) - 1.0;
  return (1 / distance - row_.x * ndc.x - row_.y * ndc.y - row_.w) / row_.z;
}

ExactFrame::ExactFrame(const capture::Capture& capture, std::uint32_t image_width, std::uint32_t image_height)
    : width(image_width),
      height(image_height),
      pixels(std::size_t{image_width} * image_height),
      frame_(capture.frames[0]) {
  const replay::Camera camera = replay::camera_of(frame_, 0);
  inverse_ = camera.inverse_view_projection;
  row_ = glm::transpose(inverse_)[3];
  eye_ = camera.eye;
  near_ = 1 / (row_.z + row_.w);
  sky = {frame_.sky[0], frame_.sky[1], frame_.sky[2]};
  for (const capture::Draw& draw : frame_.draws) {
    const auto& material = capture.materials[draw.material];
    const auto positions = capture::decode_stream(capture, draw.position, draw.vertex_count, 3);
    const auto normals = capture::decode_stream(capture, draw.normal, draw.vertex_count, 3);
    const auto indices = capture::decode_indices(capture, draw);
    ExactSurface base;
    base.albedo = {material.base_colour[0], material.base_colour[1], material.base_colour[2]};
    base.emissive = {material.emissive[0], material.emissive[1], material.emissive[2]};
    base.metallic = static_cast<double>(material.metallic);
    base.roughness = static_cast<double>(material.roughness);
    base.unlit = material.unlit;
    const auto colours = capture::decode_stream(capture, draw.colour, draw.vertex_count, 3);
    for (const capture::Matrix4& transform : capture::world_transforms(capture, draw)) {
      const glm::dmat4 world = replay::matrix(transform);
      const glm::dmat3 to_normal = glm::transpose(glm::inverse(glm::dmat3(world)));
      for (std::size_t t = 0; t + 3 <= indices.size(); t += 3) {
        Corner corner[3];
        bool usable = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t at = std::size_t{indices[t + k]} * 3;
          const glm::dvec4 point = world * glm::dvec4(positions[at], positions[at + 1], positions[at + 2], 1);
          corner[k].world = glm::dvec3(point);
          corner[k].clip = camera.view_projection * point;
          if (!normals.empty())
            corner[k].normal = to_normal * glm::dvec3(normals[at], normals[at + 1], normals[at + 2]);
          if (!colours.empty()) corner[k].colour = {colours[at], colours[at + 1], colours[at + 2]};
          usable = usable && corner[k].clip.w > 1e-9 && std::isfinite(glm::dot(corner[k].clip, glm::dvec4(1)));
        }
        if (!usable) continue;
        glm::dvec2 p[3];
        double z[3];
        for (int k = 0; k < 3; ++k) {
          const glm::dvec3 ndc = glm::dvec3(corner[k].clip) / corner[k].clip.w;
          p[k] = (glm::dvec2(ndc) * 0.5 + 0.5) * glm::dvec2(width, height);
          z[k] = ndc.z;
        }
        const double area = cross2(p[1] - p[0], p[2] - p[0]);
        // Positive: clockwise on a screen whose y points down, the back.
        if (area == 0 || (area > 0 && !material.two_sided)) continue;
        const glm::dvec2 low = glm::min(glm::min(p[0], p[1]), p[2]), high = glm::max(glm::max(p[0], p[1]), p[2]);
        if (high.x < 0 || high.y < 0 || low.x > width || low.y > height) continue;
        const auto first = glm::ivec2(glm::clamp(glm::floor(low), glm::dvec2(0), glm::dvec2(width - 1, height - 1)));
        const auto last = glm::ivec2(glm::clamp(glm::floor(high), glm::dvec2(0), glm::dvec2(width - 1, height - 1)));
        const glm::dvec3 face =
            unit(glm::cross(corner[1].world - corner[0].world, corner[2].world - corner[0].world), {0, 0, 1});
        const glm::dvec2 slope((z[1] - z[0]) * (p[2].y - p[0].y) - (z[2] - z[0]) * (p[1].y - p[0].y),
                               (z[2] - z[0]) * (p[1].x - p[0].x) - (z[1] - z[0]) * (p[2].x - p[0].x));
        for (int y = first.y; y <= last.y; ++y) {
          for (int x = first.x; x <= last.x; ++x) {
            const glm::dvec2 centre(x + 0.5, y + 0.5);
            const auto weights = [&](const glm::dvec2& q) {
              return glm::dvec3(cross2(p[2] - p[1], q - p[1]), cross2(p[0] - p[2], q - p[2]),
                                cross2(p[1] - p[0], q - p[0])) /
                     area;
            };
            const auto inside = [](const glm::dvec3& w) { return w.x >= 0 && w.y >= 0 && w.z >= 0; };
            ExactFragment fragment;
            fragment.at = glm::dvec2(0);
            glm::dvec2 sum(0);
            for (std::uint32_t s = 0; s < kSamples; ++s) {
              if (!inside(weights(centre + sample_offset(s)))) continue;
              fragment.mask |= 1u << s;
              sum += sample_offset(s);
            }
            if (fragment.mask == 0) continue;
            if (!inside(weights(centre))) fragment.at = sum / static_cast<double>(std::popcount(fragment.mask));
            const glm::dvec3 at_centre = weights(centre), screen = weights(centre + fragment.at);
            fragment.depth = at_centre.x * z[0] + at_centre.y * z[1] + at_centre.z * z[2];
            fragment.slope = slope / area;
            fragment.depth_at = fragment.depth + glm::dot(fragment.slope, fragment.at);
            if (!(fragment.depth_at >= 0 && fragment.depth_at <= 1)) continue;
            glm::dvec3 w = screen / glm::dvec3(corner[0].clip.w, corner[1].clip.w, corner[2].clip.w);
            w /= w.x + w.y + w.z;
            fragment.surface = base;
            fragment.surface.albedo *= w.x * corner[0].colour + w.y * corner[1].colour + w.z * corner[2].colour;
            fragment.surface.position = w.x * corner[0].world + w.y * corner[1].world + w.z * corner[2].world;
            const glm::dvec3 side = area > 0 ? -face : face;
            fragment.surface.normal =
                normals.empty() ? side
                                : unit(w.x * corner[0].normal + w.y * corner[1].normal + w.z * corner[2].normal, side) *
                                      (area > 0 ? -1.0 : 1.0);
            pixels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)].push_back(fragment);
          }
        }
      }
    }
  }
}

glm::dvec3 ExactFrame::shade(const ExactSurface& s) const {
  if (s.unlit) return glm::clamp(s.albedo, 0.0, 1.0);
  const glm::dvec3 view = unit(eye_ - s.position, {0, 0, 1}), normal = unit(s.normal, view);
  const double roughness = std::clamp(s.roughness, 0.089, 1.0), alpha2 = std::pow(roughness, 4);
  const glm::dvec3 diffuse_colour = s.albedo * (1 - s.metallic);
  const glm::dvec3 reflectance = glm::mix(glm::dvec3(0.04), s.albedo, s.metallic);
  const double cosine = glm::dot(normal, view), normal_view = std::clamp(cosine, 1e-3, 1.0);
  const double smith_view = std::sqrt(normal_view * normal_view * (1 - alpha2) + alpha2);
  const auto reflected = [&](const glm::dvec3& light, double normal_light) {
    const double half2 = std::max(2 + 2 * glm::dot(light, view), 1e-6);
    const double sum = std::max(normal_light + cosine, 0.0), sum2 = std::min(sum * sum, half2);
    const double denominator = std::max((alpha2 - 1) * sum2 + half2, alpha2 * half2);
    const double smith_light = std::sqrt(normal_light * normal_light * (1 - alpha2) + alpha2);
    const double lobe =
        alpha2 * half2 * half2 /
        (2 * std::numbers::pi * denominator * denominator * (normal_light * smith_view + normal_view * smith_light));
    const glm::dvec3 fresnel =
        reflectance + (1.0 - reflectance) * std::pow(1 - std::min(0.5 * std::sqrt(half2), 1.0), 5);
    return (diffuse_colour / std::numbers::pi * (1.0 - fresnel) + fresnel * lobe) * normal_light;
  };
  const glm::dvec4 r = roughness * glm::dvec4(-1.0, -0.0275, -0.572, 0.022) + glm::dvec4(1.0, 0.0425, 1.04, -0.04);
  const double a004 = std::min(r.x * r.x, std::exp2(-9.28 * normal_view)) * r.x + r.y;
  const glm::dvec2 scale_bias = glm::dvec2(-1.04, 1.04) * a004 + glm::dvec2(r.z, r.w);
  const glm::dvec3 specular = glm::clamp(reflectance * scale_bias.x + scale_bias.y, 0.0, 1.0);
  glm::dvec3 radiance = glm::dvec3(frame_.ambient[0], frame_.ambient[1], frame_.ambient[2]) *
                            (diffuse_colour * (1.0 - specular) + specular) +
                        s.emissive;
  if (frame_.sun) {
    const auto& sun = *frame_.sun;
    const glm::dvec3 light = -unit({sun.direction[0], sun.direction[1], sun.direction[2]}, {0, -1, 0});
    radiance += glm::dvec3(sun.irradiance[0], sun.irradiance[1], sun.irradiance[2]) *
                reflected(light, std::clamp(glm::dot(normal, light), 0.0, 1.0));
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(frame_.point_lights.size(), 256); ++i) {
    const auto& point = frame_.point_lights[i];
    const glm::dvec3 to_light = glm::dvec3(point.position[0], point.position[1], point.position[2]) - s.position;
    const double range2 = static_cast<double>(point.range) * static_cast<double>(point.range),
                 d2 = glm::dot(to_light, to_light);
    const double window = std::max(1 - d2 * d2 / (range2 * range2), 0.0);
    const glm::dvec3 light = to_light / std::sqrt(std::max(d2, 1e-20));
    double inside = 1;
    if (point.cone) {
      const auto& d = point.cone->direction;
      const double outer = point.cone->outer_cosine, between = point.cone->inner_cosine - outer;
      inside = std::clamp((-glm::dot(light, unit({d[0], d[1], d[2]}, {0, -1, 0})) - outer) / between, 0.0, 1.0);
    }
    const double attenuation = inside * inside * window * window * std::min(1 / std::max(d2, 1e-20), 1e4 / range2);
    radiance += glm::dvec3(point.intensity[0], point.intensity[1], point.intensity[2]) *
                (attenuation * reflected(light, std::clamp(glm::dot(normal, light), 0.0, 1.0)));
  }
  return glm::clamp(radiance, 0.0, 60000.0);
}

glm::dvec3 ExactFrame::display(const glm::dvec3& radiance) const {
  glm::dvec3 shown;
  for (int c = 0; c < 3; ++c) {
    const double x = std::clamp(radiance[c] * static_cast<double>(frame_.exposure), 0.0, 1e6);
    const double y = x * (2.43 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    shown[c] = y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
  }
  return glm::clamp(shown, 0.0, 1.0);
}

}  // namespace subpixel::precision
