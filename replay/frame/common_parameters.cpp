#include "replay/frame/common_parameters.hpp"

#include "shaders/include/interface.h"

namespace subpixel::replay {

static_assert(static_cast<std::uint32_t>(ShadingModel::blinn_phong) == SHADING_MODEL_BLINN_PHONG);
static_assert(static_cast<std::uint32_t>(AlphaDecision::test) == ALPHA_MODE_TEST);
static_assert(static_cast<std::uint32_t>(AlphaDecision::per_sample) == ALPHA_MODE_PER_SAMPLE);

namespace field {

Field<CommonParameters> samples(const std::vector<double>& allowed) {
  return integer("samples", &CommonParameters::samples, one_of(allowed), "visibility samples per pixel", "samples");
}

Field<CommonParameters> alpha() {
  return choice(
      "alpha", &CommonParameters::alpha,
      "how alpha-tested materials decide: alpha's plane at each sample, once per fragment, or a texture read per "
      "sample",
      {{"to_coverage", AlphaDecision::to_coverage},
       {"test", AlphaDecision::test},
       {"per_sample", AlphaDecision::per_sample}});
}

Field<CommonParameters> resolve() {
  return choice("resolve", &CommonParameters::resolve,
                "samples are averaged as linear radiance, or after the tone curve",
                {{"linear", Resolve::linear}, {"tone_mapped", Resolve::tone_mapped}});
}

Field<CommonParameters> shading() {
  return choice("shading", &CommonParameters::shading, "reflection model",
                {{"ggx", ShadingModel::ggx}, {"blinn_phong", ShadingModel::blinn_phong}});
}

Field<OrderedParameters> order() {
  return choice(
      "order", &OrderedParameters::order,
      "how fragments come in submission order: as lists by pixel where frames are not too deep, or "
      "in one ordered geometry pass, as published; both leave the same bits, but for masks that a table makes",
      {{"lists", FragmentOrder::lists}, {"one_pass", FragmentOrder::one_pass}});
}

Field<TemporalParameters> history() {
  return integer("history", &TemporalParameters::history, {0, 256},
                 "frames that are run before a frame for what it takes from the past; the first stands for those that "
                 "the capture lacks",
                 "frames");
}

Field<TemporalParameters> jitter() {
  return integer(
      "jitter", &TemporalParameters::jitter, one_of({1, 2, 4, 8, 16, 32}),
      "places of the sample in the pixel, points of Halton's sequence that frames take in turns; 1: the centre");
}

}  // namespace field

gpu::Constants common_constants(const CommonParameters& parameters) {
  return {{CONSTANT_SHADING_MODEL, static_cast<std::uint32_t>(parameters.shading)},
          {CONSTANT_ALPHA_MODE, static_cast<std::uint32_t>(parameters.alpha)},
          {CONSTANT_RESOLVE, static_cast<std::uint32_t>(parameters.resolve)}};
}

}  // namespace subpixel::replay
