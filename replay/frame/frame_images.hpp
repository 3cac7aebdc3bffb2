// The images of a frame: what its passes draw to, what they leave as outputs and as maps.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "replay/frame/frame_setup.hpp"

namespace subpixel::replay {

// An image of the frame's size that passes draw to and later ones read.
gpu::Image& target_image(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name, VkFormat format);
// The same of `layers`, seen as an array even if it is one.
gpu::Image& target_array(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name, VkFormat format,
                         std::uint32_t layers);

// Makes the frame's radiance and display, the attachments of the pass that writes both.
std::vector<gpu::Attachment> make_outputs(gpu::PassRecorder& recorder, const FrameSetup& setup);
// R32_UINT, a value for each pixel.
gpu::Image& map_image(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name);
// Makes maps of the frame's outputs, the attachments of the pass that writes them in this order.
std::vector<gpu::Attachment> make_maps(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                       std::initializer_list<const char*> names);

// A pass over all pixels with the frame's constants.
gpu::RasterPass fullscreen_pass(const FrameSetup& setup, std::string name, std::string fragment);

// Host steps that make maps, so that those cost a technique no time. `once`: a step that does its work in the first
// run, where every run leaves the same; `run_pass`: what it does if that is one pass.
std::function<void()> once(std::function<void()> work);
std::function<void()> run_pass(gpu::Device& device, gpu::RasterPass pass);

}  // namespace subpixel::replay
