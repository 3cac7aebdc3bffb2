// Version 3: strips and fans, indices of 8 bits and packed vertex formats, against what Vulkan and exact values say.
#include <gtest/gtest.h>

#include <cmath>

#include "capture_format/checks.hpp"
#include "capture_format/record_writer.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::capture {
namespace {

using Indices = std::vector<std::uint32_t>;

// One draw over eight vertices with the given indices.
template <typename Index>
Capture drawn(Topology topology, const std::vector<Index>& indices, bool restart) {
  Capture capture;
  capture.buffers = {{"vertices", std::vector<std::byte>(8 * 12)}, {"indices", bytes_of(indices)}};
  capture.materials.emplace_back();
  Draw draw;
  draw.position = {0, VertexFormat::float32x3, 0, 12};
  draw.vertex_count = 8;
  draw.topology = topology;
  draw.restart = restart;
  draw.index_type = sizeof(Index) == 1 ? IndexType::uint8 : sizeof(Index) == 2 ? IndexType::uint16 : IndexType::uint32;
  draw.index_buffer = 1;
  draw.index_count = static_cast<std::uint32_t>(indices.size());
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  frame.draws = {draw};
  capture.frames = {frame};
  return capture;
}

Indices read_back(const Capture& capture) {
  const Capture read = decode_capture(encode_capture(capture));
  const Draw& draw = read.frames[0].draws[0];
  EXPECT_EQ(draw.topology, Topology::triangle_list);
  EXPECT_FALSE(draw.restart);
  return decode_indices(read, draw);
}

TEST(CaptureTopology, StripsTurnEveryOtherTriangle) {
  const Indices expected{0, 1, 2, 1, 3, 2, 2, 3, 4};
  EXPECT_EQ(read_back(drawn<std::uint8_t>(Topology::triangle_strip, {0, 1, 2, 3, 4}, false)), expected);
  EXPECT_EQ(read_back(drawn<std::uint16_t>(Topology::triangle_strip, {0, 1, 2, 3, 4}, false)), expected);
  EXPECT_EQ(read_back(drawn<std::uint32_t>(Topology::triangle_strip, {0, 1, 2, 3, 4}, false)), expected);
}

TEST(CaptureTopology, FansShareTheirFirstVertex) {
  EXPECT_EQ(read_back(drawn<std::uint16_t>(Topology::triangle_fan, {5, 1, 2, 3}, false)), (Indices{1, 2, 5, 2, 3, 5}));
}

TEST(CaptureTopology, RestartsBeginAnewAndCountNothing) {
  EXPECT_EQ(read_back(drawn<std::uint8_t>(Topology::triangle_strip, {0, 1, 2, 255, 3, 255, 255, 4, 5, 6, 7}, true)),
            (Indices{0, 1, 2, 4, 5, 6, 5, 7, 6}));
  EXPECT_EQ(read_back(drawn<std::uint16_t>(Topology::triangle_fan, {0xffff, 0, 1, 2, 0xffff, 5, 6, 7, 4}, true)),
            (Indices{1, 2, 0, 6, 7, 5, 7, 4, 5}));
  EXPECT_EQ(read_back(drawn<std::uint32_t>(Topology::triangle_strip, {0xffffffff, 0xffffffff}, true)), Indices{});
}

TEST(CaptureTopology, TooFewIndicesMakeNoTriangle) {
  for (std::size_t count : {0u, 1u, 2u}) {
    EXPECT_EQ(read_back(drawn(Topology::triangle_strip, std::vector<std::uint16_t>(count, 1), false)), Indices{});
  }
}

TEST(CaptureTopology, StripsWithoutIndicesAndWithABase) {
  Capture capture = drawn<std::uint16_t>(Topology::triangle_strip, {}, false);
  Draw& draw = capture.frames[0].draws[0];
  draw.index_type = IndexType::none;
  draw.index_buffer = kNone;
  draw.base_vertex = 3;
  draw.index_count = 4;
  EXPECT_EQ(read_back(capture), (Indices{3, 4, 5, 4, 6, 5}));
  Capture indexed = drawn<std::uint16_t>(Topology::triangle_fan, {2, 3, 4}, false);
  indexed.frames[0].draws[0].base_vertex = -2;
  EXPECT_EQ(read_back(indexed), (Indices{1, 2, 0}));
}

TEST(CaptureTopology, ListsOfEightBitsStayLists) {
  const Capture capture = drawn<std::uint8_t>(Topology::triangle_list, {0, 1, 2, 7, 6, 5}, false);
  EXPECT_EQ(read_back(capture), (Indices{0, 1, 2, 7, 6, 5}));
  EXPECT_EQ(decode_capture(encode_capture(capture)).buffers.size(), 2u);
}

TEST(CaptureTopology, EqualRangesBecomeOneList) {
  Capture capture = drawn<std::uint16_t>(Topology::triangle_strip, {0, 1, 2, 3}, false);
  for (int i = 0; i < 5; ++i) capture.frames[0].draws.push_back(capture.frames[0].draws[0]);
  capture.frames.push_back(capture.frames[0]);
  const Capture read = decode_capture(encode_capture(capture));
  ASSERT_EQ(read.buffers.size(), 3u);
  EXPECT_EQ(read.buffers[2].bytes.size(), 12u);
  // What was read and is written again is a capture of lists, and stays the same from then on.
  EXPECT_EQ(encode_capture(decode_capture(encode_capture(read))), encode_capture(read));
}

TEST(CaptureTopology, MoreThanTheCallerTakesIsRefused) {
  const Capture capture = drawn(Topology::triangle_strip, std::vector<std::uint16_t>(10000, 1), false);
  const std::vector<std::byte> bytes = encode_capture(capture);
  EXPECT_NE(refusal(bytes, {.decoded_bytes = 30000}).find("too large as triangle lists"), std::string::npos);
}

TEST(CaptureTopology, EveryLieIsRefused) {
  const std::pair<const char*, void (*)(Draw&)> lies[] = {
      {"topology", [](Draw& d) { d.topology = Topology{3}; }},
      {"restart", [](Draw& d) { d.topology = Topology::triangle_list, d.index_count = 3; }},
      {"restart", [](Draw& d) { d.index_type = IndexType::none, d.index_buffer = kNone; }},
      {"index_buffer", [](Draw& d) { d.restart = false; }},  // 255 is no vertex then
      {"index_type", [](Draw& d) { d.index_type = IndexType{4}; }},
      {"index_offset", [](Draw& d) { d.index_offset = 2; }},
      {"position.format", [](Draw& d) { d.position.format = VertexFormat{17}; }}};
  const Capture honest = drawn<std::uint8_t>(Topology::triangle_strip, {0, 1, 2, 255, 3}, true);
  ASSERT_EQ(refusal(encode_capture(honest)), "");
  for (const auto& [field, tell] : lies) {
    Capture lying = honest;
    tell(lying.frames[0].draws[0]);
    EXPECT_THROW(encode_capture(lying), InputError) << field;
    Forgery forgery(honest);
    forgery.replace_payload(ChunkType::frame, 0, RecordWriter(3).frame(lying.frames[0]));
    EXPECT_REFUSED(forgery, std::string("field ") + field);
  }
}

TEST(CaptureTopology, OlderVersionsKnowNoneOfIt) {
  Capture plain = drawn<std::uint16_t>(Topology::triangle_list, {0, 1, 2}, false);
  EXPECT_EQ(needed_version(plain), 1u);
  for (void (*change)(Draw&) :
       {+[](Draw& d) { d.topology = Topology::triangle_fan; }, +[](Draw& d) { d.index_type = IndexType::uint8; },
        +[](Draw& d) {
          d.normal = {0, VertexFormat::octahedral_snorm8, 0, 2};
        },
        +[](Draw& d) {
          d.colour = {0, VertexFormat::unorm10x3_2, 0, 4};
        }}) {
    Capture changed = plain;
    change(changed.frames[0].draws[0]);
    EXPECT_EQ(needed_version(changed), 3u);
  }
}

std::vector<float> decoded(VertexFormat format, const std::vector<std::byte>& bytes, std::uint32_t components) {
  Capture capture;
  capture.buffers = {{"one", bytes}};
  EXPECT_EQ(element_bytes(format), bytes.size());
  return decode_stream(capture, {0, format, 0, 0}, 1, components);
}

TEST(CaptureTopology, PackedFormatsHaveVulkansValues) {
  const auto word = [](std::uint32_t value) { return bytes_of(std::vector<std::uint32_t>{value}); };
  EXPECT_EQ(decoded(VertexFormat::snorm10x3_2, word(511u | 513u << 10 | 512u << 20 | 1u << 30), 4),
            (std::vector<float>{1, -1, -1, 1}));
  EXPECT_EQ(decoded(VertexFormat::snorm10x3_2, word(0u | 1u << 10 | 1023u << 20 | 2u << 30), 4),
            (std::vector<float>{0, 1 / 511.0f, -1 / 511.0f, -1}));
  EXPECT_EQ(decoded(VertexFormat::unorm10x3_2, word(1023u | 0u << 10 | 341u << 20 | 3u << 30), 4),
            (std::vector<float>{1, 0, 341 / 1023.0f, 1}));
  // 1 has exponent 15 and no mantissa; 1.5 the mantissa's highest bit.
  EXPECT_EQ(decoded(VertexFormat::float11x2_10, word((15u << 6) | (15u << 6 | 1u << 5) << 11 | (14u << 5) << 22), 3),
            (std::vector<float>{1, 1.5f, 0.5f}));
  const auto shorts = [](const std::vector<std::uint16_t>& values) { return bytes_of(values); };
  EXPECT_EQ(decoded(VertexFormat::float16x3, shorts({0x3c00, 0xc000, 0x3800}), 4),
            (std::vector<float>{1, -2, 0.5f, 1}));
  EXPECT_EQ(decoded(VertexFormat::snorm16x2, shorts({0x7fff, 0x8000}), 2), (std::vector<float>{1, -1}));
}

// The encoding of Cigolle et al. forwards, in doubles, and what comes back.
TEST(CaptureTopology, OctahedralDirectionsComeBack) {
  double worst_8 = 0, worst_16 = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2 * i + 1) / 2000.0, angle = 2.399963229728653 * i, r = std::sqrt(1 - z * z);
    const double n[3] = {r * std::cos(angle), r * std::sin(angle), z};
    const double sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
    double u = n[0] / sum, v = n[1] / sum;
    if (n[2] < 0) {
      const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
      v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
      u = folded;
    }
    const auto angle_to = [&](const std::vector<float>& got) {
      const double cross[3] = {n[1] * got[2] - n[2] * got[1], n[2] * got[0] - n[0] * got[2],
                               n[0] * got[1] - n[1] * got[0]};
      EXPECT_NEAR(std::hypot(got[0], got[1], got[2]), 1, 1e-6);
      return std::hypot(cross[0], cross[1], cross[2]);
    };
    worst_8 = std::max(
        worst_8, angle_to(decoded(VertexFormat::octahedral_snorm8,
                                  bytes_of(std::vector<std::int8_t>{static_cast<std::int8_t>(std::lround(127 * u)),
                                                                    static_cast<std::int8_t>(std::lround(127 * v))}),
                                  3)));
    worst_16 = std::max(
        worst_16,
        angle_to(decoded(VertexFormat::octahedral_snorm16,
                         bytes_of(std::vector<std::int16_t>{static_cast<std::int16_t>(std::lround(32767 * u)),
                                                            static_cast<std::int16_t>(std::lround(32767 * v))}),
                         3)));
  }
  EXPECT_LT(worst_8, 0.017);  // a degree
  EXPECT_LT(worst_16, 7e-5);
}

// A chunk of a kind that a later minor version may add is skipped, and said; before version 3 it was refused.
TEST(CaptureTopology, ChunksOfUnknownKindsAreSkippedAndSaid) {
  const Capture capture = drawn<std::uint8_t>(Topology::triangle_list, {0, 1, 2}, false);
  ASSERT_EQ(needed_version(capture), 3u);
  Capture two = capture;
  two.frames.push_back(two.frames[0]);
  Forgery with_two(two);
  with_two.set_type(ChunkType::frame, 1, four_cc("ZXXX"));
  ASSERT_EQ(with_two.refused(), "");
  const Capture read = decode_capture(with_two.bytes());
  EXPECT_EQ(read.frames.size(), 1u);
  ASSERT_EQ(read.metadata.notices.size(), 1u);
  EXPECT_NE(read.metadata.notices[0].find("ZXXX"), std::string::npos);
}

}  // namespace
}  // namespace subpixel::capture
