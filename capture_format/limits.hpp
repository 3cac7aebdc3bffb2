// What a capture may hold at most. A file comes from anywhere, so every count and size is held to these before memory
// is taken or loops are run for it. SPEC.md lists them; recorder, writer, reader and validator all use these.
#pragma once

#include <cstdint>

namespace subpixel::capture {

inline constexpr std::uint32_t kMaxBuffers = 1u << 20;
inline constexpr std::uint32_t kMaxTextures = 1u << 16;
inline constexpr std::uint32_t kMaxMaterials = 1u << 16;
inline constexpr std::uint32_t kMaxFrames = 1u << 16;
inline constexpr std::uint32_t kMaxDraws = 1u << 20;        // of one frame
inline constexpr std::uint32_t kMaxPointLights = 1u << 16;  // of one frame
inline constexpr std::uint32_t kMaxNotices = 4096;          // of the metadata
inline constexpr std::uint32_t kMaxTextBytes = 1u << 16;    // of one name or metadata text
inline constexpr std::uint32_t kMaxTextureSide = 16384;     // texels
inline constexpr std::uint32_t kMaxFrameSide = 16384;       // pixels
inline constexpr std::uint64_t kMaxTriangles = 1ull << 28;  // of one frame, instances counted

// Index values are read once for each different range; a hostile file could overlap ranges without end.
inline constexpr std::uint64_t kMaxIndicesChecked = 1ull << 31;

// What one reader call may take; a caller with less memory lowers it.
struct ReadLimits {
  std::uint64_t file_bytes = 8ull << 30;
  std::uint64_t decoded_bytes = 8ull << 30;  // all chunks together, and all buffers and textures together
};

}  // namespace subpixel::capture
