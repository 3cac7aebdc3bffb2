#include "replay/gpu/litmus.hpp"

#include <fmt/format.h>

#include <cstring>

#include "capture_format/error.hpp"
#include "replay/gpu/pass_recorder.hpp"

namespace subpixel::gpu {
namespace {
constexpr std::uint32_t kSide = 256;       // several tiles in each direction
constexpr std::uint32_t kTriangles = 512;  // over each pixel
}  // namespace

LitmusResult run_order_litmus(Device& device) {
  PassRecorder recorder(device);
  Image& image = recorder.image({"order litmus", VK_FORMAT_R32G32B32A32_UINT, kSide, kSide, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false});
  RasterPass pass;
  pass.name = "order litmus";
  pass.pipeline.vertex = "frontend/litmus.vert";
  pass.pipeline.fragment = "frontend/litmus.frag";
  pass.pipeline.targets = {{VK_FORMAT_R32G32B32A32_UINT}, VK_FORMAT_UNDEFINED, VK_SAMPLE_COUNT_1_BIT, true, true};
  pass.colours = {{image}};
  pass.clear_colours = {{}};
  pass.draws = [](DrawEncoder& encoder) { encoder.draw(3 * kTriangles); };
  recorder.raster(std::move(pass));
  recorder.run();
  const auto bytes = download(device, image);
  std::vector<std::uint32_t> texels(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(texels.data(), bytes.data(), bytes.size());
  LitmusResult result;
  for (std::size_t i = 0; i < texels.size(); i += 4) {
    result.fragments += kTriangles;
    result.order_violations += texels[i + 2];
    result.lost_updates += kTriangles - std::min(kTriangles, texels[i + 1]);
  }
  return result;
}

void require_ordered_access(Device& device) {
  const LitmusResult result = run_order_litmus(device);
  if (result.order_violations == 0 && result.lost_updates == 0) return;
  throw DeviceError(
      "device",
      fmt::format("fragments of a pixel are not in primitive order: {} violations and {} lost updates in {}",
                  result.order_violations, result.lost_updates, result.fragments),
      "ordered-access litmus on " + device.info().device);
}

}  // namespace subpixel::gpu
