// Deferred shading of n full G-buffer samples, every one of them lit: the brute force all techniques are compared with.
// Our passes find visibility first and write attributes of visible samples only, so more than 8 samples reuse one
// group's buffer; the paper layout is that of the whole buffer, as a device would hold it.
#include "replay/techniques/deferred.hpp"

namespace subpixel::replay {
namespace {

struct NoaaParameters : CommonParameters {
  NoaaParameters() { samples = 1; }
};

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  record_resolve(recorder, setup, record_shaded_samples(recorder, setup));
}

void record_msaa(gpu::PassRecorder& recorder, const SetupFor<PrepassParameters>& setup) {
  if (setup.parameters.prepass) return record(recorder, setup);
  const auto [visibility, gbuffer] = record_gbuffer_in_order(recorder, setup);
  gpu::Image& sum = sum_image(recorder, setup);
  for (std::uint32_t group = 0; group < setup.samples / gbuffer_group(setup.samples); ++group)
    record_sample_shading(recorder, setup, visibility, gbuffer, sum, group);
  record_resolve(recorder, setup, sum);
}

}  // namespace

extern const Technique kNoaa, kMsaa;

const Technique kNoaa = TechniqueOf<NoaaParameters>{
    .name = "noaa",
    .title = "No anti-aliasing",
    .paper = "",
    .fields = {field::samples({1}), field::alpha(), field::resolve(), field::shading()},
    .maps = {},
    .layout = full_sample_layout,
    .record = record,
    .lists = ListedMasks::visible,
};

const Technique kMsaa = TechniqueOf<PrepassParameters>{
    .name = "msaa",
    .title = "Deferred MSAA, every sample shaded",
    .paper = "",
    .fields = {field::samples({4, 8, 16, 32, 64}), field::prepass(), field::alpha(), field::resolve(),
               field::shading()},
    .maps = {written_map()},
    .layout = full_sample_layout,
    .record = record_msaa,
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
