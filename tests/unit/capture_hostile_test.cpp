// Files whose checksums hold but whose contents lie: every count, size, reference and range, one at a time.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "capture_format/limits.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint32_t kHuge = 0xfffffff0u;

TEST(CaptureHostile, TheUnchangedFileIsFine) {
  EXPECT_EQ(Forgery().refused(), "");
}

TEST(CaptureHostile, ChunkHeaders) {
  const auto refused_after = [](std::size_t field, auto value) {
    Forgery forgery;
    const std::size_t at = forgery.chunk(ChunkType::buffer, 1);
    forgery.set(at + field, value);
    forgery.sign(at);
    return forgery;
  };
  EXPECT_REFUSED(refused_after(0, std::uint32_t{0x41414141}), "unknown chunk type");
  EXPECT_REFUSED(refused_after(0, ChunkType::metadata), "stands after a later kind");
  EXPECT_REFUSED(refused_after(4, std::uint32_t{7}), "out of sequence");
  EXPECT_REFUSED(refused_after(8, std::uint32_t{2}), "version 1 knows no zlib");
  EXPECT_REFUSED(refused_after(8, std::uint32_t{3}), "unknown codec");
  EXPECT_REFUSED(refused_after(12, std::uint32_t{1}), "field reserved");
  EXPECT_REFUSED(refused_after(16, std::numeric_limits<std::uint64_t>::max()), "field stored_bytes");
  EXPECT_REFUSED(refused_after(16, std::uint64_t{1} << 40), "field stored_bytes");
  EXPECT_REFUSED(refused_after(24, std::numeric_limits<std::uint64_t>::max()), "field decoded_bytes");
  EXPECT_REFUSED(refused_after(24, std::uint64_t{0}), "field decoded_bytes");
}

TEST(CaptureHostile, DecompressionNeverTakesWhatTheHeaderPromises) {
  Forgery forgery;
  const std::size_t at = forgery.chunk(ChunkType::frame, 0);
  forgery.set(at + 8, Codec::zstd);
  forgery.set(at + 24, std::uint64_t{1} << 32);
  forgery.sign(at);
  EXPECT_REFUSED(forgery, "field decoded_bytes");
}

TEST(CaptureHostile, TextLengths) {
  for (const std::uint32_t length : {kHuge, kMaxTextBytes + 1}) {
    Forgery forgery;
    forgery.set_payload(ChunkType::metadata, 0, 0, length);
    EXPECT_REFUSED(forgery, "longer than 65536 bytes");
  }
  Forgery forgery;
  forgery.set_payload(ChunkType::metadata, 0, 0, kMaxTextBytes);
  EXPECT_REFUSED(forgery, "field title");
  Forgery not_utf8;
  not_utf8.set_payload(ChunkType::buffer, 1, 4, std::uint8_t{0xff});
  EXPECT_REFUSED(not_utf8, "not UTF-8");
}

TEST(CaptureHostile, DataReferences) {
  Forgery buffer;
  buffer.set_payload(ChunkType::buffer, 1, 4 + 7, kHuge);  // after the name "indices"
  EXPECT_REFUSED(buffer, "chunk BUFR 1, decoded byte 15, field data");
  Forgery unused;
  unused.set_payload(ChunkType::texture, 1, 4 + 4 + 16, std::uint32_t{0});  // after the name "file"
  EXPECT_REFUSED(unused, "no buffer or texture refers to it");
}

TEST(CaptureHostile, Textures) {
  const auto refused_after = [](std::size_t field, std::uint32_t value) {
    Forgery forgery;
    forgery.set_payload(ChunkType::texture, 0, 4 + 4 + field, value);  // after the name "dots"
    return forgery;
  };
  EXPECT_REFUSED(refused_after(0, 2), "no texture encoding");
  EXPECT_REFUSED(refused_after(4, 2), "neither 0 nor 1");
  EXPECT_REFUSED(refused_after(8, 0), "field width");
  EXPECT_REFUSED(refused_after(8, kHuge), "field width");
  EXPECT_REFUSED(refused_after(8, 3), "8 bytes instead of 12");
  EXPECT_REFUSED(refused_after(12, 16385), "field height");
}

TEST(CaptureHostile, MaterialCount) {
  for (const std::uint32_t count : {3u, 1000u, kMaxMaterials + 1, kHuge}) {
    Forgery forgery;
    forgery.set_payload(ChunkType::material, 0, 0, count);
    EXPECT_REFUSED(forgery, "chunk MATL 0");
  }
  Forgery fewer;
  fewer.set_payload(ChunkType::material, 0, 0, std::uint32_t{1});
  EXPECT_REFUSED(fewer, "bytes follow the last field");
}

TEST(CaptureHostile, DrawAndLightCounts) {
  // The count stands before its first record: the range of light 0 follows it by 28 bytes; the name of draw 0 at once.
  const std::size_t first_draw = Forgery().find_in_frame(std::array<char, 7>{'i', 'n', 'd', 'e', 'x', 'e', 'd'}) - 4;
  const std::size_t first_light = first_draw - 4 - 2 * 28;
  for (const std::uint32_t count : {3u, 100u, kMaxDraws + 1, kHuge}) {
    Forgery forgery;
    forgery.set_payload(ChunkType::frame, 0, first_draw - 4, count);
    EXPECT_REFUSED(forgery, "chunk FRAM 0");
  }
  for (const std::uint32_t count : {100u, kMaxPointLights + 1, kHuge}) {
    Forgery forgery;
    forgery.set_payload(ChunkType::frame, 0, first_light - 4, count);
    EXPECT_REFUSED(forgery, "field point_lights");
  }
}

// Offsets in the record of the draw "indexed", as SPEC.md has them.
constexpr std::size_t kDrawMaterial = 4 + 7;
constexpr std::size_t kDrawPosition = kDrawMaterial + 4;
constexpr std::size_t kDrawIndexType = kDrawPosition + 4 * 20;
constexpr std::size_t kDrawInstanceBuffer = kDrawIndexType + 28 + 64;

Forgery forged_draw(std::size_t field, auto value) {
  Forgery forgery;
  const std::size_t draw = forgery.find_in_frame(std::array<char, 7>{'i', 'n', 'd', 'e', 'x', 'e', 'd'}) - 4;
  forgery.set_payload(ChunkType::frame, 0, draw + field, value);
  return forgery;
}

TEST(CaptureHostile, DrawReferencesAndRanges) {
  constexpr std::uint64_t kFar = std::numeric_limits<std::uint64_t>::max();
  EXPECT_REFUSED(forged_draw(kDrawMaterial, 2u), "draw 0, field material");
  EXPECT_REFUSED(forged_draw(kDrawPosition, 5u), "field position.buffer");
  EXPECT_REFUSED(forged_draw(kDrawPosition, kNone), "field position.buffer");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 4, 8u), "field position.format");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 4, kHuge), "field position.format");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 8, std::uint64_t{9}), "field position.offset");
  EXPECT_EQ(forged_draw(kDrawPosition + 8, std::uint64_t{8}).refused(), "");  // the last element ends with the buffer
  EXPECT_REFUSED(forged_draw(kDrawPosition + 8, kFar), "field position.offset");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 8, kFar - 70), "field position.offset");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 16, 11u), "field position.stride");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 16, 0u), "field position.stride");
  EXPECT_REFUSED(forged_draw(kDrawPosition + 16, kHuge), "field position.offset");
  EXPECT_EQ(forged_draw(kDrawPosition + 20 + 16, 0u).refused(), "");  // one normal for all vertices
  EXPECT_REFUSED(forged_draw(kDrawIndexType, 3u), "field index_type");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 4, 5u), "field index_buffer");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 4, kNone), "field index_buffer");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 8, std::uint64_t{4}), "field index_offset");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 8, kFar), "field index_offset");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 16, 5u), "no multiple of 3");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 16, 9u), "field index_offset");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 16, 0xfffffffcu), "field index_offset");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer, 5u), "field instance_buffer");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer, kNone), "must be 1 without an instance buffer");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer + 4, std::uint64_t{1}), "field instance_offset");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer + 4, kFar - 60), "field instance_offset");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer + 12, 3u), "field instance_offset");
  EXPECT_REFUSED(forged_draw(kDrawInstanceBuffer + 12, kHuge), "field instance_offset");
}

TEST(CaptureHostile, IndexValues) {
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 8, std::uint64_t{0}), "indices 0 to 9");  // takes in the 9 before
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 20, 1), "indices 1 to 4");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 20, -1), "indices -1 to 2");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 20, std::numeric_limits<std::int32_t>::min()), "are not all among the 4");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 20, std::numeric_limits<std::int32_t>::max()), "are not all among the 4");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 24, 3u), "indices 0 to 3");
  EXPECT_REFUSED(forged_draw(kDrawIndexType + 24, kHuge), "field position.offset");
}

TEST(CaptureHostile, FrameNumbers) {
  // Name "first" and time come first, then view and projection.
  constexpr std::size_t kView = 4 + 5 + 8;
  constexpr std::size_t kClipDepth = kView + 128;
  const auto refused_after = [](std::size_t offset, auto value) {
    Forgery forgery;
    forgery.set_payload(ChunkType::frame, 0, offset, value);
    return forgery;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_REFUSED(refused_after(kView, nan), "not finite: byte");
  EXPECT_REFUSED(refused_after(kView + 60, infinity), "field view");
  EXPECT_REFUSED(refused_after(kView + 64, nan), "field projection");
  EXPECT_REFUSED(refused_after(kClipDepth, 3u), "field clip_depth");
  EXPECT_REFUSED(refused_after(kClipDepth + 4, 2u), "field clip_y_up");
  EXPECT_REFUSED(refused_after(kClipDepth + 8, 0u), "field width");
  EXPECT_REFUSED(refused_after(kClipDepth + 12, kHuge), "field height");
  EXPECT_REFUSED(refused_after(kClipDepth + 16, -1.0f), "field exposure");
  EXPECT_REFUSED(refused_after(kClipDepth + 20, nan), "field sky");
  EXPECT_REFUSED(refused_after(kClipDepth + 32, infinity), "field ambient");
  EXPECT_REFUSED(refused_after(kClipDepth + 44, 2u), "field has_sun");
}

TEST(CaptureHostile, TooManyTriangles) {
  Capture capture = small_capture();
  // 2^16 instances of 2 triangles, drawn 2^12 times: 2^29 from a few kilobytes.
  capture.buffers[2].bytes.resize(sizeof(Matrix4) << 16);
  capture.frames[0].draws[0].instance_count = 1u << 16;
  capture.frames[0].draws.resize(1u << 12, capture.frames[0].draws[0]);
  for (Draw& draw : capture.frames[0].draws) draw = capture.frames[0].draws[0];
  try {
    encode_capture(capture);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("triangles, instances counted"), std::string::npos) << error.what();
  }
}

TEST(CaptureHostile, FooterAndIndex) {
  Forgery index;
  const std::size_t at = index.chunk(ChunkType::index);
  index.set(at + kChunkHeaderBytes + 8, std::uint64_t{24});
  index.sign(at);
  EXPECT_REFUSED(index, "differs from the chunk that is there");
}

}  // namespace
}  // namespace subpixel::capture
