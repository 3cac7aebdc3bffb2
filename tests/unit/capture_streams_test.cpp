// Vertex formats, indices and instances decoded to plain numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "capture_format/streams.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

std::vector<float> decode(const std::vector<std::byte>& bytes, VertexFormat format, std::uint32_t count,
                          std::uint32_t components) {
  Capture capture;
  capture.buffers = {{"b", bytes}};
  return decode_stream(capture, {0, format, 0, element_bytes(format)}, count, components);
}

TEST(CaptureStreams, FloatsComeAsTheyAre) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> values{1, -2.5f, std::numeric_limits<float>::infinity(), nan, 5, 6};
  const std::vector<float> out = decode(bytes_of(values), VertexFormat::float32x3, 2, 3);
  EXPECT_EQ(out[1], -2.5f);
  EXPECT_TRUE(std::isinf(out[2]));
  EXPECT_TRUE(std::isnan(out[3]));
}

TEST(CaptureStreams, MissingComponentsAreZeroAndOne) {
  EXPECT_EQ(decode(bytes_of(std::vector<float>{3, 4}), VertexFormat::float32x2, 1, 4),
            (std::vector<float>{3, 4, 0, 1}));
  EXPECT_EQ(decode(bytes_of(std::vector<float>{3, 4, 5}), VertexFormat::float32x3, 1, 2), (std::vector<float>{3, 4}));
}

TEST(CaptureStreams, NormalisedIntegers) {
  const std::vector<std::int8_t> bytes{127, -127, -128, 0};
  EXPECT_EQ(decode(bytes_of(bytes), VertexFormat::snorm8x4, 1, 4), (std::vector<float>{1, -1, -1, 0}));
  const std::vector<std::int16_t> shorts{32767, -32767, -32768, 0};
  EXPECT_EQ(decode(bytes_of(shorts), VertexFormat::snorm16x4, 1, 4), (std::vector<float>{1, -1, -1, 0}));
  EXPECT_EQ(decode(bytes_of(std::vector<std::uint16_t>{65535, 0}), VertexFormat::unorm16x2, 1, 2),
            (std::vector<float>{1, 0}));
  EXPECT_EQ(decode(bytes_of(std::vector<std::uint16_t>{65535, 0, 13107, 52428}), VertexFormat::unorm16x4, 1, 4),
            (std::vector<float>{1, 0, 0.2f, 0.8f}));
  EXPECT_EQ(decode(bytes_of(std::vector<std::uint8_t>{255, 0, 51, 128}), VertexFormat::unorm8x4, 1, 4),
            (std::vector<float>{1, 0, 0.2f, 128.0f / 255}));
}

TEST(CaptureStreams, HalvesAreExact) {
  EXPECT_EQ(half_to_float(0x3c00), 1.0f);
  EXPECT_EQ(half_to_float(0xc000), -2.0f);
  EXPECT_EQ(half_to_float(0x7bff), 65504.0f);
  EXPECT_EQ(half_to_float(0x0001), std::ldexp(1.0f, -24));
  EXPECT_EQ(half_to_float(0x03ff), std::ldexp(1023.0f, -24));
  EXPECT_EQ(half_to_float(0x0400), std::ldexp(1.0f, -14));
  EXPECT_EQ(half_to_float(0x7c00), std::numeric_limits<float>::infinity());
  EXPECT_EQ(half_to_float(0xfc00), -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(half_to_float(0x7e00)));
  EXPECT_TRUE(std::signbit(half_to_float(0x8000)));
}

TEST(CaptureStreams, StrideZeroRepeatsOneValue) {
  Capture capture;
  capture.buffers = {{"b", bytes_of(std::vector<float>{1, 2})}};
  EXPECT_EQ(decode_stream(capture, {0, VertexFormat::float32x2, 0, 0}, 2, 2), (std::vector<float>{1, 2, 1, 2}));
}

TEST(CaptureStreams, AbsentIsEmpty) {
  EXPECT_TRUE(decode_stream(Capture{}, VertexStream{}, 5, 3).empty());
}

TEST(CaptureStreams, IndicesHaveTheBaseAdded) {
  const Capture capture = small_capture();
  EXPECT_EQ(decode_indices(capture, capture.frames[0].draws[0]), (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3}));
  EXPECT_EQ(decode_indices(capture, capture.frames[0].draws[1]), (std::vector<std::uint32_t>{1, 2, 3}));
  Capture other;
  other.buffers = {{"i", bytes_of(std::vector<std::uint32_t>{10, 11, 12})}};
  Draw draw;
  draw.index_type = IndexType::uint32;
  draw.index_buffer = 0;
  draw.index_count = 3;
  draw.base_vertex = -10;
  EXPECT_EQ(decode_indices(other, draw), (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST(CaptureStreams, InstancesArePlacedByTheTransformOnTop) {
  const Capture capture = small_capture();
  Draw draw = capture.frames[0].draws[0];
  draw.transform = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 5, 0, 1};  // twice as large, 5 up
  const std::vector<Matrix4> places = world_transforms(capture, draw);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[0], draw.transform);
  EXPECT_EQ(places[1][12], 6.0f);  // the instance's 3 to the right, doubled
  EXPECT_EQ(places[1][13], 5.0f);
  EXPECT_EQ(triangle_count(draw), 4u);
  EXPECT_EQ(world_transforms(capture, capture.frames[0].draws[1]).size(), 1u);
}

}  // namespace
}  // namespace subpixel::capture
