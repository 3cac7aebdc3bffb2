// Results and images of the made-up worker: nothing is replayed, but every number and picture is there.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "replay/measure/image.hpp"
#include "replay/results/worker_protocol.hpp"

namespace subpixel::tests {

// Rows of 8-bit RGB from the top.
std::vector<std::uint8_t> render(std::uint32_t width, std::uint32_t height, std::uint32_t frame, int samples);
replay::Image display_image(const std::vector<std::uint8_t>& rgb, std::uint32_t width, std::uint32_t height);

replay::ResultsHead make_head(const replay::ReplayJob& job, const std::string& title, std::uint32_t width,
                              std::uint32_t height);

// What the capture's `tweak` changes of a technique; an empty object for nothing.
nlohmann::json tweak_of(const nlohmann::json& fake, const std::string& technique);

// The result of the job's technique `index`; its images are written into the job's out_dir.
replay::FrameResult make_result(const replay::ReplayJob& job, std::uint32_t frame, std::uint32_t index,
                                std::uint32_t width, std::uint32_t height, const nlohmann::json& tweak);

}  // namespace subpixel::tests
