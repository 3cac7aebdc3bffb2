// What a technique gets for one frame, and what it leaves.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "replay/frontend/frontend.hpp"
#include "replay/techniques/technique.hpp"

namespace subpixel::replay {

// Images the technique allocated from its recorder and filled.
struct FrameOutputs {
  gpu::Image* radiance = nullptr;  // RGBA32F: rgb linear radiance, a lighting executions of the pixel
  gpu::Image* display = nullptr;   // RGBA32F: rgb display values in [0, 1]
  // Further maps by the name of their MapDescription: R32_UINT, one value a pixel.
  std::vector<std::pair<std::string, gpu::Image*>> maps;
  // Counters filled by the technique's host steps while the passes run.
  std::map<std::string, std::uint64_t> counters;
};

struct FrameSetup {
  GpuScene& scene;
  Frontend& frontend;
  std::uint32_t width = 0, height = 0;
  std::uint32_t samples = 0;
  const ParameterValues& parameters;
  FrameOutputs& outputs;

  double number(std::string_view name) const { return parameters.at(std::string(name)).get<double>(); }
  std::string choice(std::string_view name) const { return parameters.at(std::string(name)).get<std::string>(); }
};

// Parameters that every technique built on the front-end has.
Parameter samples_parameter(std::vector<double> allowed, int default_value);
// One of `choices`, of which the first is the default; one that is on by default.
Parameter choice_parameter(std::string_view name, std::string_view doc, std::vector<std::string_view> choices);
// `allowed` as in Parameter: empty for every whole number of the range.
Parameter integer_parameter(std::string_view name, std::string_view doc, double minimum, double maximum,
                            int default_value, std::vector<double> allowed = {});
Parameter number_parameter(std::string_view name, std::string_view doc, std::string_view unit, double minimum,
                           double maximum, double default_value);
Parameter condition_parameter(std::string_view name, std::string_view doc);
Parameter alpha_parameter();
Parameter resolve_parameter();
Parameter shading_parameter();
// Specialization constants those parameters set: shading model, alpha mode, resolve.
gpu::Constants common_constants(const FrameSetup& setup);

// Bits a surface of this scene takes in a G-buffer that holds only what the scene needs, without depth.
double fitted_surface_bits(SceneFeatures features);

}  // namespace subpixel::replay
