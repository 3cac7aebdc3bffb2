#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

Parameter samples_parameter(std::vector<double> allowed, int default_value) {
  Parameter p;
  p.name = "samples";
  p.kind = ParameterKind::integer;
  p.doc = "visibility samples per pixel";
  p.unit = "samples";
  p.minimum = allowed.front();
  p.maximum = allowed.back();
  p.allowed = std::move(allowed);
  p.default_value = default_value;
  return p;
}

Parameter choice_parameter(std::string_view name, std::string_view doc, std::vector<std::string_view> choices) {
  Parameter p;
  p.name = name;
  p.kind = ParameterKind::choice;
  p.doc = doc;
  p.default_value = std::string(choices.front());
  p.choices = std::move(choices);
  return p;
}

Parameter integer_parameter(std::string_view name, std::string_view doc, double minimum, double maximum,
                            int default_value, std::vector<double> allowed) {
  Parameter p;
  p.name = name;
  p.doc = doc;
  p.minimum = minimum;
  p.maximum = maximum;
  p.allowed = std::move(allowed);
  p.default_value = default_value;
  return p;
}

Parameter number_parameter(std::string_view name, std::string_view doc, std::string_view unit, double minimum,
                           double maximum, double default_value) {
  Parameter p;
  p.name = name;
  p.kind = ParameterKind::number;
  p.doc = doc;
  p.unit = unit;
  p.minimum = minimum;
  p.maximum = maximum;
  p.default_value = default_value;
  return p;
}

Parameter condition_parameter(std::string_view name, std::string_view doc) {
  Parameter p;
  p.name = name;
  p.kind = ParameterKind::boolean;
  p.doc = doc;
  p.default_value = true;
  return p;
}

Parameter alpha_parameter() {
  Parameter p;
  p.name = "alpha";
  p.kind = ParameterKind::choice;
  p.doc =
      "how alpha-tested materials decide: alpha's plane at each sample, once per fragment, or a texture read per "
      "sample";
  p.choices = {"to_coverage", "test", "per_sample"};
  p.default_value = "to_coverage";
  return p;
}

Parameter resolve_parameter() {
  Parameter p;
  p.name = "resolve";
  p.kind = ParameterKind::choice;
  p.doc = "samples are averaged as linear radiance, or after the tone curve";
  p.choices = {"linear", "tone_mapped"};
  p.default_value = "linear";
  return p;
}

Parameter shading_parameter() {
  Parameter p;
  p.name = "shading";
  p.kind = ParameterKind::choice;
  p.doc = "reflection model";
  p.choices = {"ggx", "blinn_phong"};
  p.default_value = "ggx";
  return p;
}

gpu::Constants common_constants(const FrameSetup& setup) {
  const std::string alpha = setup.choice("alpha");
  return {{CONSTANT_SHADING_MODEL,
           setup.choice("shading") == "blinn_phong" ? SHADING_MODEL_BLINN_PHONG : SHADING_MODEL_GGX},
          {CONSTANT_ALPHA_MODE, alpha == "test"         ? ALPHA_MODE_TEST
                                : alpha == "per_sample" ? ALPHA_MODE_PER_SAMPLE
                                                        : ALPHA_MODE_TO_COVERAGE},
          {CONSTANT_RESOLVE, setup.choice("resolve") == "tone_mapped" ? 1u : 0u}};
}

double fitted_surface_bits(SceneFeatures features) {
  double bits = 24 + 32;  // albedo, normal
  if (features.has(FEATURE_METAL)) bits += 8;
  if (features.has(FEATURE_VARYING_ROUGHNESS)) bits += 8;
  if (features.has(FEATURE_EMISSIVE)) bits += 32;
  return bits;
}

}  // namespace subpixel::replay
