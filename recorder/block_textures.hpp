// Block-compressed texels as image files, which is how a capture holds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace subpixel::recording {

// What the file's headers say of one format of blocks (4 x 4 texels each).
struct BlockFormat {
  std::uint32_t block_bytes = 0;
  std::uint32_t four_cc = 0;   // of the pixel format
  std::uint32_t dxgi = 0;      // of the second header; 0: there is none
  bool is_normal_map = false;  // x and y of normals
};

// Bytes of one level of width x height texels. Sides up to 2^16 don't wrap.
std::uint64_t level_bytes(const BlockFormat& format, std::uint32_t width, std::uint32_t height);

// A DDS file of one level (Microsoft, "Programming Guide for DDS"), `blocks` being level_bytes() of it.
std::vector<std::byte> dds_file(const BlockFormat& format, std::uint32_t width, std::uint32_t height,
                                std::span<const std::byte> blocks);

// The format of a number of subpixel_texture_format; none for a number that is not of blocks.
std::optional<BlockFormat> block_format(std::uint32_t texture_format);

}  // namespace subpixel::recording
