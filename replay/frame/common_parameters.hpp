// The parameters that techniques share, declared once.
#pragma once

#include <cstdint>
#include <vector>

#include "replay/frame/parameter_fields.hpp"
#include "replay/frontend/frontend_frame.hpp"

namespace subpixel::replay {

// Values are those of the specialization constants.
enum class ShadingModel : std::uint32_t { ggx = 0, blinn_phong = 1 };
// Samples are averaged as linear radiance, or after the tone curve.
enum class Resolve : std::uint32_t { linear = 0, tone_mapped = 1 };

// Of every technique.
struct CommonParameters {
  std::uint32_t samples = 8;  // visibility samples per pixel
  AlphaDecision alpha = AlphaDecision::to_coverage;
  Resolve resolve = Resolve::linear;
  ShadingModel shading = ShadingModel::ggx;

  virtual ~CommonParameters() = default;
};

// What brings fragments in submission order: lists by pixel where frames are not too deep, or one ordered pass. Both
// leave the same bits.
enum class FragmentOrder { lists, one_pass };

// Of techniques that go through fragments in that order.
struct OrderedParameters : CommonParameters {
  FragmentOrder order = FragmentOrder::lists;
};

// Of techniques whose image is accumulated over frames. An image of frame k is made of the frames k - history to k, run
// one after the other for it alone, so that it does not depend on what else was run; the first frame stands for those
// before it.
struct TemporalParameters : CommonParameters {
  std::uint32_t history = 16;
  std::uint32_t jitter = 8;  // places of the sample in the pixel, which frames take in turns; 1: its centre
};

namespace field {
Field<CommonParameters> samples(const std::vector<double>& allowed);
Field<CommonParameters> alpha();
Field<CommonParameters> resolve();
Field<CommonParameters> shading();
Field<OrderedParameters> order();
Field<TemporalParameters> history();
Field<TemporalParameters> jitter();
}  // namespace field

// Specialization constants of shading model, alpha decision and resolve.
gpu::Constants common_constants(const CommonParameters& parameters);

}  // namespace subpixel::replay
